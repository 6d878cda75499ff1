"""What a run promises whatever comes: a full disk, a killed run, PAUSE, a page that cannot be made, a second run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from holonom.app import run as running
from holonom.app.console.cli import main
from holonom.app.recording import read_recording
from holonom.app.report import reporting
from holonom.app.report.findings import summary

HELLO = """
[cell]
name = "hello"
time_limit = "5s"
[[robot]]
model = "puma560"
home = ["0deg", "45deg", "-180deg", "0deg", "-45deg", "0deg"]
controllers = ["cascade", "computed_torque"]
program = "p.arps"
"""


def cell(folder: Path, *lines: str) -> Path:
    (folder / "cell.toml").write_text(HELLO, "utf-8")
    (folder / "p.arps").write_text("\n".join([".PROGRAM main()", *lines, ".END", ""]), "utf-8")
    return folder / "cell.toml"


def broken(*_: object, **__: object) -> None:
    raise ZeroDivisionError("nothing moved")


def test_a_program_of_two_lines_under_two_controllers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Nothing moves, so nothing can be compared: a report all the same."""
    out = tmp_path / "out"
    assert main(["run", str(cell(tmp_path, 'TYPE "hello world"')), "-o", str(out)]) == 0
    assert capsys.readouterr().out.splitlines()[0] == "hello world"
    assert {path.name for path in out.iterdir()} == {
        "recording.mcap", "recording_cascade.mcap", "report.html", "summary.json",
    }  # fmt: skip
    assert "could not be made" not in (out / "report.html").read_text("utf-8")
    assert json.loads((out / "summary.json").read_text("utf-8"))["outcome"] == "done"


def test_pause_under_two_controllers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert main(["run", str(cell(tmp_path, 'TYPE "a"', "PAUSE", 'TYPE "b"')), "-o", str(out)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("a\nhello: program at PAUSE")
    assert (out / "recording_cascade.mcap").exists()


@pytest.mark.parametrize("what", ["page", "summary"])
def test_what_cannot_be_made_takes_nothing_with_it(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Neither how the run ended nor the files beside it."""
    if what == "page":
        monkeypatch.setattr(reporting, "page_html", broken)
    else:
        monkeypatch.setattr(summary, "arm_summary", broken)
    out = tmp_path / "out"
    assert main(["run", str(cell(tmp_path, 'TYPE "x"')), "-o", str(out)]) == 0
    assert "hello: program ended" in capsys.readouterr().out
    page, told = (out / "report.html").read_text("utf-8"), json.loads((out / "summary.json").read_text("utf-8"))
    assert told["outcome"] == "done"
    assert 'class="outcome ok">program ended' in page
    if what == "page":
        assert "could not be made (ZeroDivisionError: nothing moved)" in page
    else:
        assert told["untold"] == "ZeroDivisionError: nothing moved"


def test_a_failed_run_says_so_where_its_page_cannot_be_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(reporting, "page_html", broken)
    assert main(["run", str(cell(tmp_path, "x = 1 / 0")), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    assert "p.arps:2" in capsys.readouterr().err
    assert 'class="outcome bad"' in (tmp_path / "out" / "report.html").read_text("utf-8")


def test_a_recording_that_is_gone_is_a_fault_of_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Somebody removed it while the run went on: no bad input of the user's."""
    before = running._run_all

    def run_and_lose(plans, folder, interrupts, **more):
        done = before(plans, folder, interrupts, **more)
        (folder.path / "recording.mcap").unlink()
        return done

    monkeypatch.setattr(running, "_run_all", run_and_lose)
    assert main(["run", str(cell(tmp_path, 'TYPE "x"')), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    assert "its recording cannot be read again" in capsys.readouterr().err


def test_a_full_disk(tmp_path: Path) -> None:
    """Files of at most 60 kilobytes: told in words, what was recorded can be read, no lock stays."""
    out = tmp_path / "out"
    run = f"{sys.executable} -m holonom run {cell(tmp_path, 'DELAY 1')} -o {out} --quiet"
    command = f"unset HOLONOM_CACHE_LOG; ulimit -f 60; exec {run}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.returncode == 1, done.stderr
    assert "File too large" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (out / ".lock").exists()
    assert "cannot write the recording" in done.stderr or "program ended" in done.stderr
    assert read_recording(out / "recording.mcap").end() > 0.0

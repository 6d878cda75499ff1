"""The folder of a run: one run at a time, nothing lost, nothing half written, nothing removed that is not its own."""

from __future__ import annotations

import fcntl
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from holonom.app.console.output import LOCK, RunFolder
from holonom.errors import OutputError, OutputFault

HOLDER = """
import sys, time
from holonom.app.console.output import RunFolder
with RunFolder(sys.argv[1]) as folder:
    print("in", flush=True)
    time.sleep(60)
"""


def holder(path: Path) -> subprocess.Popen:
    run = subprocess.Popen([sys.executable, "-c", HOLDER, str(path)], stdout=subprocess.PIPE, text=True)
    assert run.stdout is not None
    assert run.stdout.readline() == "in\n"
    return run


def test_a_second_run_is_refused_and_told_of_the_first(tmp_path: Path) -> None:
    with holder(tmp_path) as first:
        with pytest.raises(OutputError, match="writes to the output folder") as refused, RunFolder(tmp_path):
            pytest.fail("let in")
        assert re.search(rf"process {first.pid}, begun \d{{4}}-\d\d-\d\d \d\d:\d\d:\d\d,", str(refused.value))
        first.send_signal(signal.SIGKILL)
        first.wait()
        assert (tmp_path / LOCK).exists()
        with RunFolder(tmp_path):
            assert str(os.getpid()) in (tmp_path / LOCK).read_text()
        assert not (tmp_path / LOCK).exists()


def test_two_in_one_process(tmp_path: Path) -> None:
    with RunFolder(tmp_path):
        with pytest.raises(OutputError, match=f"process {os.getpid()}"), RunFolder(tmp_path):
            pytest.fail("let in")
        with RunFolder(tmp_path / "other"):
            pass


def test_a_run_that_ends_while_another_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its lock is another file by then: who got the old one tries again."""
    lock, flock = tmp_path / LOCK, fcntl.flock

    def late(file, operation) -> None:
        monkeypatch.setattr(fcntl, "flock", flock)
        lock.unlink()
        flock(file, operation)

    monkeypatch.setattr(fcntl, "flock", late)
    with RunFolder(tmp_path):
        assert lock.exists()
        with pytest.raises(OutputError, match="writes to"), RunFolder(tmp_path):
            pytest.fail("let in")


def test_only_a_runs_own_files_go(tmp_path: Path) -> None:
    names = ("recording.mcap", "recording_cascade.mcap", "summary.json", "report.html", "recording_mine.mcap", "a.toml")
    for name in names:
        (tmp_path / name).write_text(name)
    with RunFolder(tmp_path, recordings=("recording.mcap", "recording_cascade.mcap")):
        left = {path.name for path in tmp_path.iterdir()}
        assert left == {"recording_mine.mcap", "a.toml", LOCK}


def test_a_refused_run_removes_nothing(tmp_path: Path) -> None:
    with RunFolder(tmp_path) as folder:
        folder.write("summary.json", "{}")
        with pytest.raises(OutputError), RunFolder(tmp_path):
            pytest.fail("let in")
        assert (tmp_path / "summary.json").read_text() == "{}"


def test_files_appear_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, data: bytes) -> int:
        with self.open("wb") as stream:
            stream.write(data[: len(data) // 2])
        raise OSError(28, "No space left on device")

    with RunFolder(tmp_path) as folder:
        folder.write("summary.json", "first")
        monkeypatch.setattr(Path, "write_bytes", full)
        with pytest.raises(OutputFault, match="No space left on device; what was recorded is in"):
            folder.write("summary.json", "second")
        assert (tmp_path / "summary.json").read_text() == "first"
    assert [path.name for path in tmp_path.iterdir()] == ["summary.json"]


def test_a_folder_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "summary.json").mkdir()
    with RunFolder(tmp_path) as folder:
        with pytest.raises(OutputFault, match=r"cannot write .*summary\.json"):
            folder.write("summary.json", "{}")
        assert folder.write("report.html", "page").read_text() == "page"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["report.html", "summary.json"]


def test_a_folder_that_is_read_only(tmp_path: Path) -> None:
    """Status 1 (`OutputFault`); root, who writes everywhere, is somebody else for a while."""
    own = os.geteuid()
    tmp_path.chmod(0o500)
    try:
        if own == 0:
            os.seteuid(65534)
        with pytest.raises(OutputFault, match="cannot write to the output folder"), RunFolder(tmp_path / "out"):
            pytest.fail("let in")
    finally:
        os.seteuid(own)
        tmp_path.chmod(0o700)

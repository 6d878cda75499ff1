"""The command line: exit statuses, messages for people and machines, and what it loads."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from holonom import __version__
from holonom.app.commands import COMMANDS
from holonom.app.console.answer import Answer
from holonom.app.console.cli import main
from holonom.app.console.interrupts import Interrupted
from holonom.errors import CellError, MotionError


def give_run(monkeypatch: pytest.MonkeyPatch, outcome: Answer | BaseException) -> list[tuple[Any, ...]]:
    """Put a command `run` with a given outcome in place of the real one; returns its calls as they come."""
    calls: list[tuple[Any, ...]] = []

    def run_cell(
        cell: Path, output: Path, *, seed: int | None, quiet: bool, say: Callable[[str], None], allow_outside: bool
    ) -> Answer:
        calls.append((cell, output, seed, quiet))
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome

    module = ModuleType("holonom.app.run")
    module.run_cell = run_cell  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "holonom.app.run", module)
    return calls


def test_run_passes_on_what_it_was_given(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    calls = give_run(monkeypatch, Answer("24 coins placed", {"coins": 24}))
    assert main(["run", "a/cell.toml", "-o", "out", "--seed", "7", "--quiet"]) == 0
    assert main(["run", "a/cell.toml"]) == 0
    assert main(["run", "a/cell.toml", "--json"]) == 0
    cell = Path("a/cell.toml")
    assert calls == [
        (cell, Path("out"), 7, True),
        (cell, Path("runs/a"), None, False),
        (cell, Path("runs/a"), None, True),
    ]
    text, data = capsys.readouterr().out.split("24 coins placed\n")[1:]
    assert text == ""
    assert json.loads(data) == {"coins": 24}


@pytest.mark.parametrize(("error", "status"), [(CellError("cell.toml:3: bad"), 2), (MotionError("out of reach"), 1)])
def test_errors_of_ours(
    error: Exception, status: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    give_run(monkeypatch, error)
    assert main(["run", "cell.toml"]) == status
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", f"holonom: error: {error}\n")
    assert main(["run", "cell.toml", "--json"]) == status
    shown = capsys.readouterr()
    assert shown.err == ""
    assert json.loads(shown.out) == {"error": {"type": type(error).__name__, "message": str(error), "status": status}}


def test_a_defect_shows_its_traceback(monkeypatch: pytest.MonkeyPatch) -> None:
    give_run(monkeypatch, ZeroDivisionError())
    with pytest.raises(ZeroDivisionError):
        main(["run", "cell.toml"])


def test_interrupted(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    give_run(monkeypatch, KeyboardInterrupt())
    assert main(["run", "cell.toml"]) == 130
    assert capsys.readouterr().err == "holonom: interrupted\n", "nothing was recorded"
    give_run(monkeypatch, Interrupted("what was recorded until now is kept in out"))
    assert main(["run", "cell.toml"]) == 130
    assert capsys.readouterr().err == "holonom: interrupted; what was recorded until now is kept in out\n"


WORDS = ["methods --json", "methods", "--help", "run --help", "--version", "doctor", "run nothing.toml --json"]


@pytest.mark.parametrize("words", WORDS)
def test_nobody_reads(words: str) -> None:
    """As behind `| head`: no traceback, status 141, whichever command prints."""
    reader, writer = os.pipe()
    os.close(reader)
    command = [sys.executable, "-m", "holonom", *words.split()]
    done = subprocess.run(command, stdout=writer, stderr=subprocess.PIPE, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode == 141 or words == "run --help", "there argparse takes it for printed"
    both = subprocess.run([*command, "--what"], stdout=writer, stderr=writer, check=False)
    os.close(writer)
    assert both.returncode == 141


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("after", [0.05, 0.2, 0.6, 1.0])
def test_interrupted_before_the_motion(after: float, number: signal.Signals, tmp_path: Path) -> None:
    """In imports, in the building of the cell: one line, status 130, and no word of a recording."""
    (tmp_path / "cell.toml").write_text(SLOW, "utf-8")
    code = f"import os, threading; threading.Timer({after}, os.kill, (os.getpid(), {int(number)})).start()\n"
    code += "import sys, holonom.__main__; sys.exit(holonom.__main__.main())"
    command = [sys.executable, "-c", code, "run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out")]
    default = {"preexec_fn": lambda: signal.signal(signal.SIGINT, signal.default_int_handler)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, **default)
    kept = f"; what was recorded until now is kept in {tmp_path / 'out'}"
    recorded = (tmp_path / "out" / "recording.mcap").exists()  # a fast machine is in motion by then
    assert (done.returncode, done.stderr) == (130, f"holonom: interrupted{kept if recorded else ''}\n")


SLOW = """
[cell]
name = "slow"
time_limit = "24min"

[[robot]]
model = "puma560"
hold = "1000s"
"""


def test_json_holds_no_nan(monkeypatch: pytest.MonkeyPatch) -> None:
    give_run(monkeypatch, Answer("", {"x": float("nan")}))
    with pytest.raises(ValueError, match="JSON"):
        main(["run", "cell.toml", "--json"])


WRONG = {
    (): "no command came; there is demo, new, run, check",
    ("--jso",): "option '--jso' came before a command",
    ("runn",): "no command 'runn'; there is bench, .*; did you mean 'run'?",
    ("calibrate",): "holonom calibrate needs a subject; there is dynamics, drive, odometry, process",
    ("calibrate", "dynamic"): "no subject of holonom calibrate 'dynamic'; .*; did you mean 'dynamics'?",
    ("run",): "required: CELL; 'holonom run --help' says",
    ("run", "a", "b"): "'b' came; it is unknown or one too many",
    ("run", "c", "-x"): "'-x' came; it is unknown",
    ("run", "c", "-o"): "-o/--output: expected one argument",
    ("run", "--sed", "3", "c"): "no option of holonom run '--sed'; .*; did you mean '--seed'?",
    ("run", "c", "--quie"): "no option of holonom run '--quie'; .*; did you mean '--quiet'?",
    ("run", "c", "--seed", "x"): "--seed is 'x'; it must be a whole number",
    ("run", "c", "--seed", "-3"): "--seed is -3; it must be 0 to 9,223",
    ("bench", "--seed", "1.5"): "--seed is '1.5'; it must be a whole number",
    ("calibrate", "dynamics", "r.mcap"): "required: --arm",
    ("calibrate", "dynamics", "r", "--arm", "a", "--cutoff", "nan"): "--cutoff is nan; it must be finite",
    ("calibrate", "odometry", "l", "--method", "umbmrk"): "no value of --method 'umbmrk'; .*; did you mean 'umbmark'?",
    ("calibrate", "odometry", "l", "--limits", "1", "2"): "--limits: expected 4 arguments",
    ("calibrate", "odometry", "l", "--limits", "1", "2", "3", "x"): "--limits is 'x'; it must be a number",
    ("doctor", "--schema", "--show-kernel", "k"): "not allowed with argument --schema",
    ("methods", "comands"): "no value of KIND 'comands'; .*; did you mean 'commands'?",
}


@pytest.mark.parametrize("words", WRONG, ids=" ".join)
def test_wrong_usage_is_bad_input(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert re.match(f"holonom: error: .*{WRONG[words]}", shown.err), shown.err
    assert shown.err.count("\n") == 1
    assert main([*words, "--json"]) == 2
    shown = capsys.readouterr()
    assert shown.err == ""
    error = json.loads(shown.out)["error"]
    assert (error["type"], error["status"]) == ("UsageError", 2)
    if words:
        assert re.match(f".*{WRONG[words]}", error["message"]), error
        assert main([words[0], "--json", *words[1:]]) == 2
        assert json.loads(capsys.readouterr().out)["error"]["type"] == "UsageError"


@pytest.mark.parametrize(
    "words", [["--help"], ["-h"], ["calibrate", "--help"], *([*n.split(), "-h"] for n in COMMANDS)]
)
def test_help(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with contextlib.suppress(SystemExit):  # argparse leaves by one, with status 0
        assert main(words) == 0
    shown = capsys.readouterr()
    assert shown.err == ""
    assert shown.out.startswith(f"usage: {' '.join(['holonom', *words[:-1]])} [-h]")
    for name in COMMANDS if len(words) == 1 else ():
        assert f"{name:20}{COMMANDS[name].help}" in shown.out


def test_one_command_loads_no_other(tmp_path: Path) -> None:
    code = "import sys; from holonom.app.console.cli import main; main(['check', 'x.toml']); print(*sys.modules)"
    loaded = set(python("-c", code, folder=tmp_path).stdout.splitlines()[-1].split())
    assert {name for name in loaded if name.startswith("holonom.app.commands.")} == {"holonom.app.commands.check"}


def test_doctor_says_what_is_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--json"]) == 0
    data: Mapping[str, Any] = json.loads(capsys.readouterr().out)
    assert data["holonom"] == __version__
    assert data["cores"] >= 1
    assert all(data["packages"].values())
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    assert __version__ in text
    assert data["cache"]["folder"] in text


def test_doctor_shows_and_empties_the_kernel_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HOLONOM_CACHE", str(tmp_path))
    monkeypatch.setenv("HOLONOM_CACHE_LIMIT", "3M")
    (tmp_path / "a.loop-00ff.kernel").write_bytes(bytes(1000))
    (tmp_path / "mine.txt").write_text("not a kernel")
    assert main(["doctor", "--json"]) == 0
    expected = {"folder": str(tmp_path), "kernels": 1, "size": 1000, "limit": 3 * 2**20}
    assert json.loads(capsys.readouterr().out)["cache"] == expected
    assert main(["doctor", "--empty-cache", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {"removed": expected}
    assert main(["doctor"]) == 0
    assert f"{tmp_path} (0 kernels, 0.0 of at most 3 MiB)" in capsys.readouterr().out
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]


def test_a_limit_that_is_no_size_is_bad_input(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("HOLONOM_CACHE_LIMIT", "1 GB")
    assert main(["doctor"]) == 2
    assert "HOLONOM_CACHE_LIMIT is '1 GB'" in capsys.readouterr().err


def test_doctor_says_what_is_missing(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    from holonom.app.about import doctor

    monkeypatch.setattr(
        doctor, "EXTRAS", {"vision": doctor.Extra("cameras", {"json": "json", "no_such_module": "no-such-package"})}
    )
    monkeypatch.setattr(doctor, "NEEDED", ("no-such-need",))
    monkeypatch.setenv("PATH", "")
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    assert "[vision]        lacks no-such-package: in the clone, pip install -e '.[vision]'; for cameras" in text
    assert "no-such-need    missing" in text
    assert "browser         none" in text


def test_doctor_lists_every_extra(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All that pyproject.toml has, with all that each brings, but the one that is all of them."""
    import tomllib

    from holonom.app.about.doctor import EXTRAS

    stated = tomllib.loads((root / "pyproject.toml").read_text("utf-8"))["project"]["optional-dependencies"]
    assert set(EXTRAS) == set(stated) - {"all"}
    for name, extra in EXTRAS.items():
        assert set(extra.modules.values()) == {re.split(r"[>=;\s]", need)[0] for need in stated[name]}
    assert main(["doctor"]) == 0
    text = capsys.readouterr().out
    for name, extra in EXTRAS.items():
        assert re.search(rf"^\[{name}\] .*; for {extra.purpose}$", text, re.MULTILINE)


def test_doctor_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--schema"]) == 0
    assert capsys.readouterr().out == (Path(__file__).parents[2] / "docs" / "cell.schema.json").read_text("utf-8")


def test_doctor_shows_a_kernel(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--show-kernel", "puma560.gravity"]) == 0
    source = capsys.readouterr().out
    compile(source, "gravity", "exec")
    assert "def single" in source
    assert main(["doctor", "--show-kernel", "gravitty"]) == 2
    assert "did you mean 'gravity'" in capsys.readouterr().err
    assert main(["doctor", "--show-kernel", "puma56.gravity"]) == 2
    assert "did you mean 'puma560'" in capsys.readouterr().err


def python(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def test_as_a_module(tmp_path: Path) -> None:
    done = python("-m", "holonom", "--version", folder=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"holonom {__version__}\n")
    done = python("-m", "holonom", "doctor", "--show-kernel", "nonsense", folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("holonom: error: ")


def test_a_bad_cell_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text("[cell\n")
    for command in (["run", "cell.toml", "-o", "out"], ["check", "cell.toml"]):
        done = python("-m", "holonom", *command, folder=tmp_path)
        assert done.returncode == 2, done.stderr
        assert done.stderr.startswith("holonom: error: cell.toml:1:6: not TOML: ")
        assert sorted(tmp_path.iterdir()) == [tmp_path / "cell.toml"]


def test_doctor_loads_nothing_heavy(tmp_path: Path) -> None:
    code = "import sys; from holonom.app.console.cli import main; main(['doctor']); print(*sys.modules)"
    loaded = set(python("-c", code, folder=tmp_path).stdout.splitlines()[-1].split())
    assert "holonom.app.about.doctor" in loaded
    assert not {"numba", "scipy", "cv2", "pydantic", "lark", "mcap"} & loaded

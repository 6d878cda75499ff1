"""Nothing from a file steers a terminal."""

from __future__ import annotations

import io
import json
import re
import shutil
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest

import holonom.app
from holonom.app.console.cli import main
from holonom.app.console.printable import one_line, printable, say_to
from holonom.app.console.progress import Progress

APP = Path(holonom.app.__file__).parent
ESCAPES = "\x1b]0;owned\x07\x1b[31m\x9b2J\x7f\x08\r\u202egnp.exe\u2066\u2028\ud800"
"""Window title, colour, clear screen by a C1 control, delete, back, return, right to left, separator, half a pair."""


def steering(text: str) -> list[str]:
    """By the Unicode database: controls, surrogates, separators and marks of direction."""
    marks = {"RLE", "LRE", "RLO", "LRO", "PDF", "RLI", "LRI", "FSI", "PDI"}
    return [
        c
        for c in text
        if (unicodedata.category(c) in ("Cc", "Cs", "Zl", "Zp") and c not in "\n\t")
        or unicodedata.bidirectional(c) in marks
    ]


def test_every_character_that_steers_is_shown() -> None:
    everything = "".join(map(chr, range(0x110000)))
    assert steering(everything)
    assert steering(printable(everything)) == []
    assert printable("lines\nand\ttabs, äß€ 漢字 🤖") == "lines\nand\ttabs, äß€ 漢字 🤖"
    assert printable("\x1b[31m\x9b\u202e") == "\\x1b[31m\\x9b\\u202e"
    assert one_line("a\nholonom: done") == "a\\nholonom: done"


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "utf-8", "cp1252"])
def test_a_terminal_that_lacks_a_character_is_told_its_number(encoding: str) -> None:
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding=encoding, newline="\n")
    say_to(stream, "√2 × ß 漢")
    assert raw.getvalue().decode(encoding) == "√2 × ß 漢\n".encode(encoding, "backslashreplace").decode(encoding)


def test_there_is_one_way_to_a_terminal() -> None:
    """Only `printable` prints; a progress bar, which is rich's, shows what went through it."""
    direct = re.compile(r"(?<!console\.)\bprint\(|\.stdout\.write|\.stderr\.write|\.print\((?!printable\()")
    printing = {path.name for path in APP.rglob("*.py") if direct.search(path.read_text("utf-8"))}
    assert printing == {"printable.py"}


def hostile_cell(folder: Path, name: str) -> Path:
    """An arm that types, in a folder of its own."""
    text = f"""
[cell]
name = {json.dumps(name, ensure_ascii=True)}
time_limit = "1s"
[[robot]]
model = "planar2r"
drives = "ideal"
program = "p.arps"
"""
    (folder / "cell.toml").write_text(text.replace("\\ud800", ""), "utf-8")
    lines = ['TYPE "\x1b]0;owned\x07\x1b[31m\x9b2J\u202egnp"', 'TYPE "[/red] [bold]"']
    (folder / "p.arps").write_text("\n".join([".PROGRAM main()", *lines, ".END", ""]), "utf-8")
    return folder / "cell.toml"


def test_a_run_sends_no_escapes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cell = hostile_cell(tmp_path, f"x\nall done: 100 %{ESCAPES}[/red]")
    for command in (["run", str(cell), "-o", str(tmp_path / "out")], ["check", str(cell)]):
        assert main(command) == 0
        said = capsys.readouterr()
        assert steering(said.out + said.err) == []
    assert main(["report", str(tmp_path / "out" / "recording.mcap"), "-o", str(tmp_path / "o2")]) == 0
    said = capsys.readouterr().out
    assert steering(said) == []
    assert said.startswith("x\\nall done: 100 %\\x1b]0;owned\\x07")
    assert main(["run", str(cell), "-o", str(tmp_path / "out"), "--json"]) == 0
    said = capsys.readouterr().out
    assert steering(said) == []
    assert json.loads(said)["cell"] == f"x\nall done: 100 %{ESCAPES}[/red]".replace("\ud800", "")


def test_errors_send_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """File names, keys, echoed lines of programs with their caret in its place, words of the command line."""
    cell = hostile_cell(tmp_path, "x")
    (tmp_path / "p.arps").write_text('.PROGRAM main()\nTYPE "\x1b[31m", blue \x1b[0m\n.END\n', "utf-8")
    for words in (["check", str(cell)], ["run", str(cell)], ["run", "no\x1b[31m.toml"], ["check", "--\x1b[31m"]):
        assert main(words) == 2
        said = capsys.readouterr().err
        assert steering(said) == []
    (tmp_path / "cell.toml").write_text(cell.read_text("utf-8").replace("drives", '"dr\\u001b[31mi\\nves"'), "utf-8")
    assert main(["check", str(cell)]) == 2
    assert "dr\\x1b[31mi\\nves" in capsys.readouterr().err
    (tmp_path / "p.arps").write_text('.PROGRAM main()\nx = "\x1b\x1b" + = 1\n.END\n', "utf-8")
    assert main(["check", str(tmp_path / "p.arps")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines[1] == '  2 | x = "␛␛" + = 1'
    assert lines[2].index("^") == lines[1].index("+ =") + 2


def test_a_name_that_is_no_text_is_no_traceback(tmp_path: Path) -> None:
    """A file called by a byte that is no UTF-8: Python holds it as half a surrogate pair, which nothing can print."""
    cell = hostile_cell(tmp_path, "x")
    odd = tmp_path / b"\xff\x1b.toml".decode("utf-8", "surrogateescape")
    shutil.copy(cell, odd)
    odd.write_text("[cell", "utf-8")
    done = subprocess.run([sys.executable, "-m", "holonom", "check", odd], capture_output=True, check=False)
    assert done.returncode == 2
    assert b"\\udcff\\x1b.toml:1" in done.stderr


def test_a_bar_takes_a_name_for_a_name(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rich's own mark-up in it is none: "[/red]" alone would end in an exception."""
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", stream)
    monkeypatch.setenv("TERM", "xterm")
    with Progress("[/red]\x1b[31m\n", 1.0, quiet=False) as progress:
        say = progress.saying(lambda text: None)
        say("[/red] \x1b]0;owned\x07")
        progress(0.5)
    shown = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", stream.getvalue())  # rich's own
    assert "[/red]" in shown
    assert "\x1b" not in shown
    assert "\\x1b]0;owned\\x07" in shown.replace("\n", "")

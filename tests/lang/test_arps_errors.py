"""What a wrong program is told: line, column, the line, a caret, what was expected, a hint."""

from __future__ import annotations

import contextlib
import re
from pathlib import Path

import numpy as np
import pytest
from arps_machine import wrap
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.errors import ProgramError
from holonom.lang import FUNCTIONS, WORDS, compile_program, load_program, read_locations

TWO = ".PROGRAM main()\n{}\n.END\n.PROGRAM other(a, b[])\n  SET p = a\n  MOVE p\n  x = b[1]\n.END\n"


def message(source: str) -> str:
    with pytest.raises(ProgramError) as caught:
        compile_program(wrap(source), "job.arps")
    return str(caught.value)


def test_the_whole_message() -> None:
    assert message("  SET part = NULL\n  MOVES prat") == (
        "job.arps:3:9: location 'prat' is never given a value\n"
        "  3 |   MOVES prat\n"
        "    |         ^^^^\n"
        "  hint: did you mean 'part'?"
    )


def test_tabs_do_not_move_the_caret() -> None:
    assert message("\t\tx = 5 +").endswith(" 2 |   x = 5 +\n    |          ^")


def test_all_wrong_names_are_reported_in_the_order_of_the_lines() -> None:
    text = message("MOVE b\nx = c\nGOTO d\nCALL e")
    assert [line.split(":")[1] for line in text.splitlines() if line.startswith("job")] == ["2", "3", "4", "5"]


@pytest.mark.parametrize(
    ("source", "place", "text", "hint"),
    [
        ("MOVESS a", "2:1", "there is no instruction 'MOVESS'", "did you mean 'MOVES'?"),
        ("x = 1\n10 OPNI", "3:4", "there is no instruction 'OPNI'", "did you mean 'OPENI'?"),
        ("x = 5 +", "2:8", "the end of the line cannot stand here; expected a value", ""),
        ("IF a = 3 THEN\nEND", "2:6", "'=' cannot stand here; expected an operator, GOTO or THEN", "with =="),
        ("IF TRUE THEN\nx = 2", "4:1", "expected ELSE, ELSEIF or END", "the IF of line 2 is not"),
        ("FOR i = 1 TO 3\nIF i THEN\nEND", "5:1", "'.END' cannot", "the FOR of line 2 is not closed; add END"),
        ("WHILE TRUE DO\nx = 1", "4:1", "'.END' cannot stand here", "the WHILE of line 2 is not closed; add END"),
        ("DO\nx = 1", "4:1", "'.END' cannot stand here", "the DO of line 2 is not closed; add UNTIL"),
        ("END", "2:1", "'END' cannot stand here", "no block that END could belong to is open"),
        ("speed = 5", "2:7", "'=' cannot stand here", "SPEED is a word of the language"),
        ("FOR to = 1 TO 3\nEND", "2:5", "'to' cannot stand here; expected a name", "TO is a word of the language"),
        ('x = "abc', "2:5", "this string does not end in its line", 'close it with "'),
        ("MOVE a@", "2:7", "'@' has no meaning here", ""),
        ("# comment", "2:1", "'#' has no meaning here", "a comment begins with ;"),
        ("SPEED 3 MPS", "2:9", "'MPS' cannot stand here", "did you mean 'MMPS'?"),
        ("x = 3 y = 4", "2:7", "'y' cannot stand here; expected an operator, ':' or the end of the line", ""),
        ("SET b = SHIFT(NULL, 1)", "2:19", "',' cannot stand here", "write SHIFT(location BY dx, dy, dz)"),
        ("x = TRANS(1)", "2:5", "expected a number, got a location", "with SET"),
        ("SET a = 5", "2:9", "expected a location, got a number", ""),
        ("SET $a = NULL", "2:5", "SET gives a location its value, not a string", "leave out SET"),
        ("#a = 1", "2:1", "a precision point is given a value with SET", "write SET"),
        ("x = 1\nMOVE x", "3:6", "'x' is a number in line 2, but a location is wanted here", ""),
        ("SET x = NULL\nx = 1", "3:1", "'x' is a location in line 2, but a number", "given a value with SET"),
        ('x = "a" + 1', "2:5", "expected a number, got a string", ""),
        ('$x = "a" + 1', "2:12", "expected a string, got a number", ""),
        ("APPRO #a, 5", "2:7", "expected a location, got a precision point", ""),
        ("APPRO NULL", "2:1", "APPRO needs distance", "write APPRO location, distance"),
        ("x = ATAN2(1)", "2:5", "ATAN2 needs x", "write ATAN2(y, x)"),
        ("BREAK 5", "2:7", "too many values for BREAK", "write BREAK"),
        ("x = SIN(1, 2)", "2:12", "too many values for SIN", "write SIN(degrees)"),
        ("SIN = 3", "2:1", "SIN is a function of the language", "choose another name"),
        ("x = sine(3)", "2:5", "there is no function 'sine'", "did you mean 'SIN'?"),
        ("a[1] = 1\nx = a(1)", "3:5", "there is no function 'a'", "written a[index]"),
        ("x = main(1)", "2:5", "there is no function 'main'", "called with CALL main"),
        ("a[1] = 1\nx = a", "3:5", "'a' is an array of 1 indices", "name[index]"),
        ("a[1] = 1\nx = a[]", "3:5", "a[] is a whole array", "one element"),
        ("CALL man", "2:6", "there is no program 'man' in this file", "did you mean 'main'?"),
        ("GOTO lop\nloop:", "2:6", "there is no label 'lop' in main", "did you mean 'loop'?"),
        ("a:\na:\nGOTO a", "3:1", "label 'a' is already there", "another name"),
        ('VLOCATE "", NULL', "2:13", "expected the name of a location variable", ""),
        ("TYPE /Q3, 4", "2:6", "there is no format /Q3", "/F8.2"),
        ("SPEED 50 MMPS MONITOR", "2:10", "SPEED MONITOR takes a per cent", ""),
        ("FOR a[1] = 1 TO 2\nEND", "2:5", "FOR counts in a variable that is no array element", ""),
        ("DECOMPOSE a = NULL", "2:11", "DECOMPOSE fills six elements of an array", "name[first]"),
        ("x = 1E301", "2:5", "1E301 is too large a number", ""),
        ("AUTO a, a", "2:9", "'a' is already a name of this program", ""),
        ("WAIT", "2:5", "the end of the line cannot stand here; expected a value", ""),
        ("x = y", "2:5", "variable 'y' is never given a value", "assign it"),
        (TWO.format("CALL other(5, v[])\nv[1] = 1"), "2:12", "'a' of other is a location, and this is a number", ""),
        (TWO.format("v = 1\nCALL other(NULL, v)"), "3:18", "'b' of other is a whole array", ""),
        (TWO.format("CALL other(NULL)"), "2:6", "other takes 2 values, not 1", "write CALL other(a, b)"),
        (TWO.format("CALL other(NULL, u[])"), "2:18", "variable 'u' is never given a value", ""),
        (".PROGRAM a(x, X)\n.END", "1:15", "parameter 'X' is there twice", ""),
        (".PROGRAM a()\n.END\n.PROGRAM A()\n.END", "3:10", "there are two programs 'A'", "another name"),
        (".PROGRAM a()\nx = 1\n", "2:6", "the end of the file cannot stand here", "ends with .END"),
        ("; .PROGRAM\nMOVE a", "2:1", "'MOVE' cannot stand here; expected .PROGRAM", "between .PROGRAM name() and"),
    ],
)
def test_message(source: str, place: str, text: str, hint: str) -> None:
    lines = message(source).splitlines()
    assert lines[0].startswith(f"job.arps:{place}: ")
    assert text in lines[0]
    assert lines[2].index("^") - lines[1].index("|") == int(place.split(":")[1]) + 1
    assert hint in (lines[3] if len(lines) > 3 else "")


def test_empty_program() -> None:
    with pytest.raises(ProgramError, match="the program is empty"):
        compile_program(" \n", "job.arps")


@pytest.mark.parametrize("expression", ["(" * 3000 + "1" + ")" * 3000, "+".join(["1"] * 3000)])
def test_expression_without_measure(expression: str) -> None:
    assert re.match(r"job\.arps:2:\d+: nested too deeply: 300 levels", message(f"x = {expression}"))


SIGNS = ["=", "==", "<", "+", "-", "*", "/", "^", "(", ")", "[", "]", ",", ":", ";", "@", "\n", "\n", "\n"]
ALPHABET = [*WORDS, *FUNCTIONS, *SIGNS, "a", "b[1]", "c[]", "$s", "#p", "1", "2.5", '"t"']


@given(st.lists(st.sampled_from(ALPHABET), max_size=30))
@settings(max_examples=300, deadline=None)
def test_any_text_compiles_or_is_a_program_error(words: list[str]) -> None:
    with contextlib.suppress(ProgramError):
        compile_program(wrap(" ".join(words)), "job.arps")


def test_unused_label_is_a_warning() -> None:
    program = compile_program(wrap("GOTO a\na: x = 1\n10 y = 1"), "job.arps")
    (warning,) = program.warnings
    assert warning.render().splitlines()[0] == "job.arps:4:1: label '10' is never used"


def test_kinds_flow_through_calls_in_both_directions() -> None:
    source = ".PROGRAM m()\nCALL f(p)\nx = p\n.END\n.PROGRAM f(q)\nCALL g(q)\n.END\n.PROGRAM g(r)\nSET r = NULL\n.END"
    assert "'q' of f is a location, and this is a number" in message(source)


def test_value_set_by_a_called_program_counts() -> None:
    compile_program(".PROGRAM m()\nCALL f(n)\nx = n\n.END\n.PROGRAM f(k)\nCALL g(k)\n.END\n.PROGRAM g(j)\nj = 1\n.END")


def test_locations_are_read_in_mm_and_degrees() -> None:
    text = "; taught\nTray.Small = 500, -200, 320, 0, 180, 0 ; first\n\n#r = 0, 90, -90, 0, 0, 0\nc[2]=1,2,3,0,0,0\n"
    found = read_locations(text, "job.loc")
    assert list(found) == ["tray.small", "#r", "c[2]"]
    assert found["tray.small"][:3, 3] == pytest.approx([0.5, -0.2, 0.32])
    assert found["tray.small"][:3, :3] == pytest.approx(np.diag([-1, 1, -1]))
    assert found["#r"] == pytest.approx(np.deg2rad([0, 90, -90, 0, 0, 0]))


@pytest.mark.parametrize(
    ("line", "column", "text"),
    [
        ("tray 1, 2", 1, "this is no location"),
        ("a = 1, 2, 3", 4, "a location has 6 values, this has 3"),
        ("a = 1, 2, x, 4, 5, 6", 11, "'x' is no number"),
        ("a = 1, 2, nan, 4, 5, 6", 11, "'nan' is no number"),
        ("a = 1, 2,, 4, 5, 6", 10, "'' is no number"),
        ("#b = 1, inf", 9, "inf is beyond 1e6 mm or degrees"),
        ("a = 1, 2, 3, 4, 5e6, 6", 17, "5e6 is beyond 1e6 mm or degrees"),
        ("2a = 1, 2, 3, 4, 5, 6", 1, "'2a' is no name of a location"),
        ("$a = 1, 2, 3, 4, 5, 6", 1, "'$a' is no name of a location"),
        ("speed = 1, 2, 3, 4, 5, 6", 1, "SPEED is a word of the language"),
        ("ok = 0, 0, 0, 0, 0, 0", 1, "'ok' is there twice"),
    ],
)
def test_wrong_location_line(line: str, column: int, text: str) -> None:
    with pytest.raises(ProgramError) as caught:
        read_locations(f"ok = 0, 0, 0, 0, 0, 0\n{line}\n", "job.loc")
    lines = str(caught.value).splitlines()
    assert lines[0] == f"job.loc:2:{column}: {text}"
    assert lines[2].index("^") - lines[1].index("|") == column + 1


def test_files(tmp_path: Path) -> None:
    job = tmp_path / "job.arps"
    with pytest.raises(ProgramError, match=r"job\.arps: cannot be read: No such file"):
        load_program(job)
    job.write_text(".PROGRAM m()\nMOVE there\n.END\n", "utf-8")
    with pytest.raises(ProgramError, match="location 'there' is never given"):
        load_program(job)
    (tmp_path / "job.loc").write_text("there = 1, 2, 3, 0, 0, 0\n", "utf-8")
    assert load_program(job).globals[0].name == "there"
    (tmp_path / "other.loc").write_text("here.too = 1, 2, 3, 0, 0, 0\n", "utf-8")
    with pytest.raises(ProgramError, match="location 'there' is never given"):
        load_program(job, tmp_path / "other.loc")
    with pytest.raises(ProgramError, match=r"none\.loc: cannot be read"):
        load_program(job, tmp_path / "none.loc")
    job.write_bytes(b"\xff\xfe")
    with pytest.raises(ProgramError, match=r"job\.arps:1: not UTF-8 text"):
        load_program(job)

"""Words of other robot languages are answered with ours or "not there yet", never with the nearest spelling."""

from __future__ import annotations

import re

import pytest
from arps_machine import wrap

from holonom.errors import ProgramError
from holonom.lang import FUNCTIONS, INSTRUCTIONS, WORDS, compile_program
from holonom.lang.words.foreign import FOREIGN

OURS = {*FUNCTIONS, *INSTRUCTIONS, *WORDS, ".PROGRAM", ".END", "SHIFT", "DO"}


def told(source: str) -> str:
    with pytest.raises(ProgramError) as caught:
        compile_program(wrap(source), "job.arps")
    return str(caught.value)


@pytest.mark.parametrize(
    ("source", "hint"),
    [
        ("REACT 1001, stop", "REACT is a word of the full ARPS and V+: not there yet"),
        ("MoveL p1, v100, fine, tool0", "MoveL is a word of RAPID: here it is MOVES"),
        ("PTP HOME", "PTP is a word of KRL: here it is MOVE"),
        ("PTP {X 10, Y 0}", "PTP is a word of KRL: here it is MOVE"),
        ("LMOVE p", "LMOVE is a word of AS: here it is MOVES"),
        ("SET p = Offs(q, 1, 2, 3)", "Offs is a word of RAPID: here it is SHIFT"),
        ("WAIT SEC 1", "SEC is a word of KRL: here it is DELAY"),
        ("$OUT[1] = TRUE", "$OUT is a word of KRL: here it is SIGNAL"),
        ("x = $VEL.CP", "$VEL.CP is a word of KRL: here it is SPEED"),
        ("ENDIF", "ENDIF is a word of RAPID and KRL: here it is END"),
        ("EXIT", "EXIT is a word of V+ and KRL: here it is GOTO, to a label behind the loop; EXIT is a word of RAPID"),
        ("CYCLE", "CYCLE is a word of AS: not there yet"),
        ("TRACE", "TRACE is a word of V+ and AS: not there yet"),
        ("FLOAT 1", "FLOAT is a word of V+ and AS: not there yet"),
        ("HOLD", "HOLD is a word of AS: not there yet"),
        ("PathAccLim TRUE, TRUE", "PathAccLim is a word of RAPID: not there yet"),
        ("SoftAct 1, 20", "SoftAct is a word of RAPID: not there yet"),
        ("EOffsSet x", "EOffsSet is a word of RAPID: not there yet"),
        ("Set do1", "SET gives a location its value: SET name = location; an output is switched on by SIGNAL"),
        ("SET corner[1]", "SET gives a location its value"),
        ("Reset do1", "RESET takes no value and switches every signal off; one output is switched off by SIGNAL -n"),
        ("VAR num x := 1", "VAR is a word of RAPID: here it is left out"),
    ],
)
def test_what_other_makers_write(source: str, hint: str) -> None:
    assert f"hint: {hint}" in told(source)


def test_a_program_of_another_language() -> None:
    with pytest.raises(ProgramError, match=r"PROC is a word of RAPID: here it is \.PROGRAM name\(\)"):
        compile_program("PROC main()\n  MoveJ p1\nENDPROC\n", "job.arps")


@pytest.mark.parametrize("word", sorted(FOREIGN))
def test_no_foreign_word_is_answered_with_a_spelling(word: str) -> None:
    if word in OURS:
        pytest.fail(f"{word} is ours")
    call = f"x = {word}(1)" if word[0] in "$" else f"{word} 1, 2" if word[0] != "#" else f"SET #p = {word}"
    text = told(call)
    assert "did you mean" not in text
    assert f"{word.split('.')[0]}" in text.split("hint: ")[1]


def test_the_answers_are_words_that_there_are() -> None:
    named = {w for of in FOREIGN.values() for ours in of.values() for w in re.findall(r"\.?[A-Z][A-Z.]+\b", ours)}
    assert named - OURS - {"IF"} == set()

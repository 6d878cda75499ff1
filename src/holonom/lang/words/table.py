"""Words with a syntax of their own, and the table of all words of ARPS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from holonom.lang.words.builtin import Builtin
from holonom.lang.words.functions import FUNCTIONS, SHIFT
from holonom.lang.words.instructions import INSTRUCTIONS
from holonom.registry import Method, NoParams, Table

__all__ = ["ARPS_WORDS", "SYNTAX_WORDS", "Word"]


@dataclass(frozen=True, slots=True)
class Word:
    """A word with a syntax of its own.

    `carries`: its token tells something, so that the parser keeps it; `begins`: an instruction may begin with it.
    """

    help: str
    carries: bool = False
    begins: bool = False


SYNTAX_WORDS: Mapping[str, Word] = {
    "ANY": Word("CASE: where no VALUE fits"),
    "BY": Word("SHIFT(location BY dx, dy, dz)"),
    "CALL": Word("run another program of the file", begins=True),
    "CASE": Word("one of several blocks, by a value", begins=True),
    "CP": Word("continuous path ON or OFF", begins=True),
    "DECOMPOSE": Word("the six numbers of a location into an array", begins=True),
    "DO": Word("repeat a block UNTIL a condition holds", begins=True),
    "ELSE": Word("IF: where no condition holds"),
    "ELSEIF": Word("IF: another condition"),
    "END": Word("end of a block"),
    "FOR": Word("repeat a block with a counter", begins=True),
    "GOTO": Word("go on at a label", begins=True),
    "IF": Word("a block where a condition holds", begins=True),
    "OF": Word("CASE value OF"),
    "RETURN": Word("back to the program that called", begins=True),
    "SET": Word("give a location a value", begins=True),
    "SHIFT": Word("a location displaced by mm"),
    "SPEED": Word("speed of the motions that follow, or of the next one", begins=True),
    "STEP": Word("FOR: what the counter grows by"),
    "THEN": Word("IF condition THEN"),
    "TO": Word("FOR: the last value"),
    "TYPE": Word("write to the terminal", begins=True),
    "UNTIL": Word("DO: the condition at which it ends"),
    "VALUE": Word("CASE: the block of some values"),
    "WAIT": Word("wait until a condition holds", begins=True),
    "WHILE": Word("repeat a block while a condition holds", begins=True),
    "ALWAYS": Word("SPEED, FINE, COARSE: for all motions that follow", carries=True),
    "AND": Word("both conditions hold", carries=True),
    "AUTO": Word("variables that each call has anew", carries=True, begins=True),
    "BAND": Word("and, bit by bit", carries=True),
    "BOR": Word("or, bit by bit", carries=True),
    "BXOR": Word("exclusive or, bit by bit", carries=True),
    "COARSE": Word("settle coarsely at the end of motions", carries=True, begins=True),
    "COM": Word("complement, bit by bit", carries=True),
    "FINE": Word("settle finely at the end of motions", carries=True, begins=True),
    "HERE": Word("where the arm was sent, into a variable or as a value", carries=True, begins=True),
    "LOCAL": Word("variables of this program only", carries=True, begins=True),
    "MMPS": Word("SPEED in mm/s", carries=True),
    "MOD": Word("rest of a division", carries=True),
    "MONITOR": Word("SPEED of everything, in per cent", carries=True),
    "NOT": Word("the condition does not hold", carries=True),
    "OFF": Word("CP OFF", carries=True),
    "ON": Word("CP ON", carries=True),
    "OR": Word("one of the conditions holds", carries=True),
    "TIMER": Word("a timer is set, or read", carries=True, begins=True),
    "WHERE": Word("where the arm is, measured, into a variable or as a value", carries=True, begins=True),
    "XOR": Word("exactly one of the conditions holds", carries=True),
}
"""By name; a new one is a line here and a rule of the grammar."""

_SOURCE = "V+ language user's guide, Adept; docs/arps.md"


def _listed() -> dict[str, Method]:
    builtins: Mapping[str, Builtin] = {**INSTRUCTIONS, **FUNCTIONS, SHIFT.name.split()[0]: SHIFT}
    words: dict[str, Word | Builtin] = {**SYNTAX_WORDS, **builtins}
    return {name: Method(word.help, partial(_itself, word), _SOURCE) for name, word in sorted(words.items())}


def _itself(word: Word | Builtin, _: NoParams) -> Word | Builtin:
    return word


ARPS_WORDS = Table("arps_words", "word of ARPS", "its `Builtin` or `Word`", _listed(), closed=True)
"""All words; the grammar is one text, so entry points add none."""

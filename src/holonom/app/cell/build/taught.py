"""Taught locations that the arm cannot go to, told from the program and its location file alone."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from holonom.arrays import Array
from holonom.errors import MotionError, ProgramError
from holonom.files import read_text
from holonom.lang import Configuration, Program
from holonom.lang.program import Operand
from holonom.machine import branch_joints
from holonom.mechanics import Arm
from holonom.model import outside
from holonom.model.joint_values import in_degrees, range_in_degrees

__all__ = ["taught_problems"]


_MOVES_THE_FRAME = {"BASE", "TOOL"}
_USES_AS_FRAME = {"FRAME", "INVERSE"}
_LOADS = {"LOAD_GLOBAL", "REF_GLOBAL", "LOAD_LOCAL", "REF_LOCAL"}
_KEEPS = {"ELEMENT", "VALUE", "SHIFT"}
"""Operations whose result is still the location that their first operand was."""
_TAKES = dict.fromkeys((*_LOADS, "CONST", "HERE", "HERE_JOINTS"), 0) | {
    "VALUE": 1,
    "UNARY": 1,
    "BINARY": 2,
    "COMPOUND": 2,
    "SHIFT": 4,
}
_SHARED = -1
_Variable = tuple[int, int]
"""A variable of the program: the number of its routine, or `_SHARED`, and its slot."""
_Sources = frozenset[_Variable]


def taught_problems(arm: Arm, home: Sequence[float], program: Program, file: Path) -> Iterator[str]:
    """Say which taught locations are out of reach or outside the joint limits, with file and line of each.

    Precision points are always looked at. A location counts unless the program uses it as a frame, an offset or a
    tool; none counts in a program that moves the base or the tool, for only a run shows where it then lies.

    Parameters
    ----------
    arm : the arm with its tool.
    home : joints (n,) from which the nearest branch is sought, rad.
    program : the compiled program, which holds the taught values.
    file : the location file.
    """
    relative, moved = _relative(program)
    lines = _lines(file)
    for slot, variable in enumerate(program.globals):
        for indices, value in variable.given:
            if value.ndim == 2 and (moved or (_SHARED, slot) in relative):
                continue
            name = variable.name + (f"[{','.join(map(str, indices))}]" if indices else "")
            problem = _problem(arm, np.asarray(home), value)
            if problem:
                yield f"{file}{lines.get(name, '')}: taught location {name!r}: {problem}"


def _problem(arm: Arm, home: Array, value: Array) -> str | None:
    """Why the arm cannot go to joints (n,) or a tool pose (4, 4), None if it can."""
    if value.ndim == 2:
        try:
            branch_joints(arm, value, home, Configuration())
        except MotionError as problem:
            return str(problem)
        return None
    if value.size != arm.n:
        return f"{value.size} joint values came; the arm has {arm.n} joints"
    limits = arm.limits
    for name, turns, *values in zip(limits.names, limits.turns, value, limits.lower, limits.upper, strict=True):
        if outside(*values):
            came, allowed = in_degrees(values[0], turns), range_in_degrees(values[1], values[2], turns)
            return f"{came} came for {name}; {allowed} is allowed"
    return None


def _lines(file: Path) -> dict[str, str]:
    """Where a location file teaches each name: ":12"."""
    if not file.is_file():
        return {}
    text = read_text(file, "locations", ProgramError)
    heads = [line.partition(";")[0].partition("=")[0] for line in text.split("\n")]
    return {re.sub(r"\s", "", head).lower(): f":{number}" for number, head in enumerate(heads, start=1)}


def _relative(program: Program) -> tuple[set[_Variable], bool]:
    """Variables whose values are used as frames, offsets or tools; whether the program moves base or tool.

    What becomes of a variable holds for all that is assigned to it or passed for it.
    """
    relative: set[_Variable] = set()
    passed: list[tuple[_Sources, _Sources]] = []
    moved = False
    for code, operand, taken in _uses(program):
        name = operand[0] if code in ("FUNCTION", "ACTION") and isinstance(operand, tuple) else None
        if code == "COMPOUND" or name in _USES_AS_FRAME:
            relative.update(*taken)
        elif code == "ACTION" and name in _MOVES_THE_FRAME:
            moved |= bool(taken)
        elif code == "ASSIGN":
            passed.append((taken[1], taken[0]))
        elif code == "CALL":
            assert isinstance(operand, int)
            passed += [(given, frozenset({(operand, slot)})) for slot, given in enumerate(taken)]
    while found := {v for given, taker in passed if taker & relative for v in given} - relative:
        relative |= found
    return relative, moved


def _uses(program: Program) -> Iterator[tuple[str, Operand, list[_Sources]]]:
    """Every operation with the variables that each of its operands comes from."""
    for number, routine in enumerate(program.routines):
        stack: list[_Sources] = []
        for code, operand, _ in routine.code:
            pops = _operands(code, operand)
            start = 0 if pops is None else len(stack) - pops
            taken = stack[start:]
            del stack[start:]
            yield code, operand, taken
            if code in _LOADS:
                assert isinstance(operand, int)
                stack.append(frozenset({(_SHARED if code.endswith("GLOBAL") else number, operand)}))
            elif pops is not None:
                stack.append(taken[0] if code in _KEEPS else frozenset())


def _operands(code: str, operand: Operand) -> int | None:
    """How many operands an operation of an expression takes, None for one that ends an instruction."""
    if code == "ELEMENT":
        assert isinstance(operand, int)
        return operand + 1
    if code == "FUNCTION":
        assert isinstance(operand, tuple)
        return int(operand[1] or 0)
    if code == "ENCODE":
        assert isinstance(operand, tuple)
        return operand.count(None)
    return _TAKES.get(code)

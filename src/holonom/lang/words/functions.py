"""The functions of the language, one line of a table each. Angles in degrees, lengths in mm."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from holonom.errors import ProgramFault
from holonom.lang import poses
from holonom.lang.machine import Array
from holonom.lang.vm.formats import shown
from holonom.lang.vm.state import Variable, Vm
from holonom.lang.words.builtin import Builtin, Kind, location, real, text, variable
from holonom.spatial import inverse

__all__ = ["FEATURES", "FUNCTIONS", "SHIFT", "TRUE", "dest", "signals_are", "where"]

TRUE, FALSE = -1.0, 0.0
_MM, _MM2 = 1e3, 1e6

FEATURES: dict[int, tuple[str, float]] = {
    1: ("TRUE when VLOCATE found a part", TRUE),
    2: ("x in the world, mm", _MM),
    3: ("y in the world, mm", _MM),
    4: ("angle about the world's z axis, degrees", 180.0 / math.pi),
    5: ("area, mm2", _MM2),
    6: ("equal-area diameter, mm", _MM),
}
"""What VFEATURE(n) gives after VLOCATE: its meaning, and the factor from SI to the unit of the language."""

_NUMBER = re.compile(r"\s*[+-]?(\d+(\.\d*)?|\.\d+)(E[+-]?\d+)?", re.IGNORECASE | re.ASCII)


def _logical(condition: bool) -> float:
    return TRUE if condition else FALSE


def _whole(value: float, what: str) -> int:
    if not value.is_integer():
        raise ProgramFault(f"{what} must be a whole number, not {shown(value)}")
    return int(value)


def _sqrt(_: Vm, x: float) -> float:
    if x < 0.0:
        raise ProgramFault(f"SQRT of a negative number: {shown(x)}")
    return math.sqrt(x)


def _atan2(_: Vm, y: float, x: float) -> float:
    return math.degrees(math.atan2(y, x))


def _defined(_: Vm, name: Variable) -> float:
    return _logical(name.defined)


def _val(_: Vm, string: str) -> float:
    match = _NUMBER.match(string)
    return float(match.group()) if match else 0.0


def _asc(_: Vm, string: str, index: float) -> float:
    position = _whole(index, "the index of ASC")
    return float(ord(string[position - 1])) if 1 <= position <= len(string) else -1.0


def _chr(_: Vm, code: float) -> str:
    number = _whole(code, "the code of $CHR")
    if not 0 <= number <= 127:
        raise ProgramFault(f"$CHR takes a code from 0 to 127, not {number}")
    return chr(number)


def _pos(_: Vm, string: str, part: str) -> float:
    return float(string.find(part) + 1)


def _sig(vm: Vm, *numbers: float) -> float:
    return _logical(signals_are(vm, numbers))


def _ppoint(vm: Vm, *values: float) -> Array:
    turns = vm.machine.turns()
    if len(values) != len(turns):
        raise ProgramFault(f"{len(values)} joint values came; this arm has {len(turns)} joints")
    return poses.precision_point(values, turns)


def _mid(_: Vm, string: str, start: float, count: float) -> str:
    first = _whole(start, "the start of $MID")
    if first < 1 or count < 0:
        came = f"{shown(start)}, {shown(count)}"
        raise ProgramFault(f"$MID starts at 1 or later and takes 0 or more characters, not {came}")
    return string[first - 1 : first - 1 + _whole(count, "the count of $MID")]


def signals_are(vm: Vm, numbers: tuple[float, ...]) -> bool:
    """Whether every signal is as its number asks: n on, -n off."""
    states = [_signal(vm, n) for n in numbers]
    return all(states)


def _signal(vm: Vm, number: float) -> bool:
    wanted = _whole(number, "a signal number")
    if wanted == 0:
        raise ProgramFault("there is no signal 0; signals count from 1, and -n asks whether signal n is off")
    return vm.machine.signal(abs(wanted)) == (wanted > 0)


def _timer(vm: Vm, number: float) -> float:
    key = _whole(number, "a TIMER number")
    if key not in vm.state.timers:
        raise ProgramFault(f"timer {key} was never started; write TIMER {key} = 0 first")
    return vm.machine.time() - vm.state.timers[key]


def _feature(vm: Vm, number: float) -> float:
    index = _whole(number, "a feature number")
    part = vm.state.part
    if index == 1:
        return _logical(part is not None)
    if part is None:
        raise ProgramFault("VFEATURE: no part was located; test VFEATURE(1) after VLOCATE first")
    if not 1 <= index <= len(part.features):
        raise ProgramFault(f"VFEATURE({index}): a part has the features 1 to {len(part.features)}")
    _, factor = FEATURES.get(index, ("", 1.0))
    return part.features[index - 1] * factor


def dest(vm: Vm) -> Array:
    """Return where the last motion ends, as a location (4, 4) of the program: commanded, never measured."""
    return _located(vm, vm.machine.destination())


def where(vm: Vm) -> Array:
    """Return where the tool is by the measured joints, as a location (4, 4) of the program."""
    return _located(vm, vm.machine.pose())


def _located(vm: Vm, T_wt: Array) -> Array:
    settings = vm.state.settings
    found: Array = inverse(settings.base) @ T_wt @ settings.tool
    return found


def _distance(_: Vm, a: Array, b: Array) -> float:
    return float(np.linalg.norm((a - b)[:3, 3])) * _MM


def _frame(_: Vm, origin: Array, on_x: Array, near_y: Array, *placed: Array) -> Array:
    return poses.frame(origin, on_x, near_y, placed[0] if placed else origin)


_ANGLES = tuple(real(n, 0.0) for n in ("x", "y", "z", "o", "a", "t"))
_X = (real("x"),)
_S = (text("$string"),)
_DEGREES = (real("degrees"),)
_PLACE = (location(),)

_NUMBERS = (
    Builtin("TRUE", (), lambda _: TRUE, "-1, the value of a condition that holds"),
    Builtin("FALSE", (), lambda _: FALSE, "0, the value of a condition that does not hold"),
    Builtin("PI", (), lambda _: math.pi, "3.14159..."),
    Builtin("ABS", _X, lambda _, x: abs(x), "absolute value"),
    Builtin("SQRT", _X, _sqrt, "square root"),
    Builtin("SQR", _X, lambda _, x: x * x, "square"),
    Builtin("SIN", _DEGREES, lambda _, a: math.sin(math.radians(a)), "sine of an angle"),
    Builtin("COS", _DEGREES, lambda _, a: math.cos(math.radians(a)), "cosine of an angle"),
    Builtin("ATAN2", (real("y"), real("x")), _atan2, "angle of the point (x, y), -180 to 180 degrees"),
    Builtin("INT", _X, lambda _, x: float(math.trunc(x)), "whole part, towards 0"),
    Builtin("FRACT", _X, lambda _, x: math.fmod(x, 1.0), "fraction, with the sign of x"),
    Builtin("MIN", _X, lambda _, *x: min(x), "smallest value", repeat=True),
    Builtin("MAX", _X, lambda _, *x: max(x), "largest value", repeat=True),
    Builtin("SIGN", _X, lambda _, x: -1.0 if x < 0.0 else 1.0, "-1 for a negative x, else 1"),
    Builtin("RANDOM", (), lambda vm: float(vm.state.random.random()), "a number from 0 up to 1"),
    Builtin("DEFINED", (variable(),), _defined, "TRUE when a variable, or an element, has a value"),
    Builtin("LEN", _S, lambda _, s: float(len(s)), "number of characters"),
    Builtin("VAL", _S, _val, "the number that a string starts with, 0 without one"),
    Builtin("ASC", (*_S, real("index", 1.0)), _asc, "code of a character, -1 past the end"),
    Builtin("POS", (*_S, text("$part")), _pos, "where $part begins in $string, from 1; 0 when nowhere"),
    Builtin("SIG", (real("signal"),), _sig, "TRUE when each signal n is on and each -n off", repeat=True),
    Builtin("TIMER", (real("timer"),), _timer, "seconds since TIMER n = 0"),
    Builtin("VFEATURE", (real("feature"),), _feature, "a measurement of the part that VLOCATE found"),
    Builtin("VPARTS", (), lambda vm: float(vm.state.parts), "how many parts the last picture showed"),
    Builtin("DISTANCE", (location("a"), location("b")), _distance, "between two locations, mm"),
    Builtin("DX", _PLACE, lambda _, a: float(a[0, 3]) * _MM, "x of a location, mm"),
    Builtin("DY", _PLACE, lambda _, a: float(a[1, 3]) * _MM, "y of a location, mm"),
    Builtin("DZ", _PLACE, lambda _, a: float(a[2, 3]) * _MM, "z of a location, mm"),
)

_LOCATIONS = (
    Builtin("TRANS", _ANGLES, lambda _, *v: poses.transformation(v), "from mm and Z-Y-Z degrees, 0 if left out"),
    Builtin("NULL", (), lambda _: np.eye(4), "the location that changes nothing"),
    Builtin("DEST", (), dest, "where the last motion ends"),
    Builtin("RX", _DEGREES, lambda _, a: poses.transformation((0, 0, 0, -90, a, 90)), "turn about x"),
    Builtin("RY", _DEGREES, lambda _, a: poses.transformation((0, 0, 0, 0, a, 0)), "turn about y"),
    Builtin("RZ", _DEGREES, lambda _, a: poses.transformation((0, 0, 0, a, 0, 0)), "turn about z"),
    Builtin("INVERSE", _PLACE, lambda _, a: inverse(a), "the inverse transformation"),
    Builtin(
        "FRAME",
        (location("origin"), location("on_x"), location("near_y"), location("at", optional=True)),
        _frame,
        "frame through three taught points, its origin at the first or, where given, the fourth",
    ),
)

_STRINGS = (
    Builtin("$CHR", (real("code"),), _chr, "the character of a code, 0 to 127"),
    Builtin("$MID", (*_S, real("start"), real("count")), _mid, "characters of a string, counted from 1"),
)

_PPOINT_HELP = "precision point from joint values in degrees, of joints that slide in mm"
_JOINTS = (Builtin("#PPOINT", (real("j1"),), _ppoint, _PPOINT_HELP, repeat=True),)

_TABLES: tuple[tuple[Kind, tuple[Builtin, ...]], ...] = (
    ("real", _NUMBERS),
    ("location", _LOCATIONS),
    ("string", _STRINGS),
    ("joints", _JOINTS),
)

# SHIFT has a word between its values: SHIFT(location BY dx, dy, dz).
SHIFT = Builtin(
    "SHIFT location BY",
    (real("dx", 0.0), real("dy", 0.0), real("dz", 0.0)),
    lambda _, place, dx, dy, dz: poses.shift(place, dx, dy, dz),
    "the location displaced by mm along the axes it is given in",
    result="location",
)

FUNCTIONS: dict[str, Builtin] = {f.name: replace(f, result=kind) for kind, table in _TABLES for f in table}
"""Functions by name: what they take, what they give, their line of help."""

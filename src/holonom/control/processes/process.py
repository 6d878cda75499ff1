"""Processes as data: lags, integrators, dead time, by kind or as numerator and denominator."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.errors import InputError, ModelError
from holonom.registry import Method, Table, check_fields, parameter

__all__ = [
    "PROCESSES",
    "IntegratingLag",
    "LagDeadTime",
    "Parts",
    "Process",
    "TwoLags",
    "kind_of",
    "make_process",
    "parts_of",
]

REAL = 1e-3  # imaginary part over size up to which a root counts as real: a triple root is known to 1e-5 only
MOST = 1e9  # of any gain and time (s), and 1/MOST the least: no process has more
ORDER = 20  # of den, at most
AT_ZERO = 1e-9  # size of a root over the largest one up to which it is an integrator


@dataclass(frozen=True, slots=True)
class Process:
    """A process `e^(-s T_H) num(s)/den(s)`.

    Attributes
    ----------
    num, den
        Coefficients by falling powers of s; den is longer: a process whose output follows its input at once, or its
        rate, is none.
    dead_time
        s.
    given
        Kind and keys that it was made of.

    Raises
    ------
    ModelError
        Numbers that are not finite; a process that is not proper, or unstable; a gain that is not positive.
    """

    num: tuple[float, ...]
    den: tuple[float, ...]
    dead_time: float
    given: Mapping[str, Any]

    def __post_init__(self) -> None:
        num, den = (np.trim_zeros(np.array(p, dtype=float), "f") for p in (self.num, self.den))
        if not (len(num) and len(den) and np.isfinite(num).all() and np.isfinite(den).all()):
            raise ModelError(
                f"process: num is {[*map(float, self.num)]}, den {[*map(float, self.den)]}; both need finite numbers, "
                "not all 0"
            )
        sizes = np.abs(np.concatenate([num[num != 0.0], den[den != 0.0]]))
        if len(den) > ORDER + 1 or sizes.max() > MOST**3 * sizes.min():
            raise ModelError(
                f"process: den has degree {len(den) - 1}, coefficients are from {sizes.min():g} to {sizes.max():g}; "
                f"up to {ORDER}, and a ratio of {MOST**3:g}, can be computed with: leave out the fastest poles"
            )
        if self.dead_time != 0.0 and not 1.0 / MOST <= self.dead_time <= MOST:
            raise ModelError(f"process: dead_time is {self.dead_time!r}; it must be 0, or {1 / MOST:g} to {MOST:g} s")
        if len(num) > len(den) or (len(num) == len(den) and len(den) > 1):
            raise ModelError(
                f"process: num is of degree {len(num) - 1}, den of {len(den) - 1}: it is not strictly proper, no real "
                "process jumps with its input; give den a higher degree (a small lag will do)"
            )
        if len(den) == 1 and self.dead_time == 0.0:
            raise ModelError(
                "process: neither lag nor integrator nor dead time: it follows its input at once, set the input"
            )
        poles = np.roots(den)
        unstable = [p for p in poles if p.real > AT_ZERO * np.abs(poles).max()]
        if unstable:
            raise ModelError(
                f"process: unstable, a pole at {_shown(unstable[0])} 1/s; rules of tuning need a stable or an "
                "integrating one: close a stabilising loop first and tune the regulator around that"
            )
        steady = num[-1] * den[np.flatnonzero(den)[-1]]
        if steady <= 0.0:
            what = "0" if steady == 0.0 else "negative"
            raise ModelError(
                f"process: num ends with {num[-1]:g}: its gain is {what}; give a positive one: exchange the sign of "
                "the input; what leaves no trace of a constant input cannot be regulated"
            )
        object.__setattr__(self, "num", tuple(map(float, num)))
        object.__setattr__(self, "den", tuple(map(float, den)))

    def response(self, s: Any) -> Any:
        """Return `P(s)` at complex frequencies (n,), rad/s; dead time exact."""
        return np.polyval(self.num, s) / np.polyval(self.den, s) * np.exp(-s * self.dead_time)


@dataclass(frozen=True, slots=True)
class Parts:
    """What a process consists of.

    Attributes
    ----------
    gain
        Of what is left without its integrators: `P -> gain/s^integrators` for slow s.
    integrators
        How many.
    lags
        Time constants of real poles, s, the largest first.
    leads
        Time constants of real zeros `1 + s lead`, s; negative on the right.
    dead_time
        s.
    swings
        Whether it has complex poles or zeros, which `lags` and `leads` do not hold.
    """

    gain: float
    integrators: int
    lags: tuple[float, ...]
    leads: tuple[float, ...]
    dead_time: float
    swings: bool


def parts_of(process: Process) -> Parts:
    """Return lags, leads, integrators, gain of a process."""
    poles, zeros = np.roots(process.den), np.roots(process.num)
    scale = np.abs(poles).max() if len(poles) else 1.0
    still = np.abs(poles) <= AT_ZERO * scale
    n = int(still.sum())
    given = process.given.get("lags") or ([process.given["lag"]] if process.given.get("lag") else None)
    moving = poles[~still]
    lags = given if given is not None else (-1.0 / p.real for p in moving if _is_real(p))
    den = process.den[: len(process.den) - n] if n else process.den
    return Parts(
        gain=process.num[-1] / den[-1],
        integrators=n,
        lags=tuple(sorted(map(float, lags), reverse=True)),
        leads=tuple(sorted((-1.0 / z.real for z in zeros if _is_real(z) and z != 0.0), reverse=True)),
        dead_time=process.dead_time,
        swings=not all(map(_is_real, [*moving, *zeros])),
    )


def _is_real(root: complex) -> bool:
    return abs(root.imag) <= REAL * abs(root)


def _shown(root: complex) -> str:
    return f"{root.real:.4g}" if _is_real(root) else f"{root.real:.4g} {root.imag:+.4g}j"


def _chain(gain: float, lags: tuple[float, ...]) -> tuple[Array, Array]:
    den: Any = np.ones(1)
    for lag in lags:
        den = np.polymul(den, [lag, 1.0])
    return np.array([gain]), den


@dataclass(frozen=True, slots=True, kw_only=True)
class _Record:
    """Fields that are checked."""

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


_GAIN = "change of the output over change of the input, both at rest"


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadTime(_Record):
    """`gain e^(-s dead_time)`."""

    gain: float = parameter(1.0, meaning=_GAIN, least=1 / MOST, most=MOST)
    dead_time: float = parameter(meaning="until the output moves", unit="s", least=1 / MOST, most=MOST, example=1.0)

    def process(self) -> tuple[Array, Array, float]:
        """Numerator, denominator, dead time."""
        return np.array([self.gain]), np.ones(1), self.dead_time


@dataclass(frozen=True, slots=True, kw_only=True)
class LagDeadTime(_Record):
    """`gain e^(-s dead_time)/(1 + s lag)`."""

    gain: float = parameter(1.0, meaning=_GAIN, least=1 / MOST, most=MOST)
    lag: float = parameter(meaning="time constant", unit="s", least=1 / MOST, most=MOST, example=1.0)
    dead_time: float = parameter(0.0, meaning="until the output moves", unit="s", least=0.0, most=MOST)

    def process(self) -> tuple[Array, Array, float]:
        """Numerator, denominator, dead time."""
        return *_chain(self.gain, (self.lag,)), self.dead_time


@dataclass(frozen=True, slots=True, kw_only=True)
class Lags(_Record):
    """`gain e^(-s dead_time)/((1 + s lags[0])(1 + s lags[1]) ...)`."""

    gain: float = parameter(1.0, meaning=_GAIN, least=1 / MOST, most=MOST)
    lags: tuple[float, ...] = parameter(
        meaning="time constants", unit="s", least=1 / MOST, most=MOST, example=(2.0, 1.0)
    )
    dead_time: float = parameter(0.0, meaning="until the output moves", unit="s", least=0.0, most=MOST)

    def __post_init__(self) -> None:
        _Record.__post_init__(self)
        if not 0 < len(self.lags) <= ORDER:
            raise ModelError(f"process: lags holds {len(self.lags)} time constants; 1 to {ORDER} are needed")

    def process(self) -> tuple[Array, Array, float]:
        """Numerator, denominator, dead time."""
        return *_chain(self.gain, self.lags), self.dead_time


@dataclass(frozen=True, slots=True, kw_only=True)
class TwoLags(Lags):
    """`gain e^(-s dead_time)/((1 + s lags[0])(1 + s lags[1]))`."""

    def __post_init__(self) -> None:
        Lags.__post_init__(self)
        if len(self.lags) != 2:
            raise ModelError(f"process: two_lags with {len(self.lags)} lags; give two, or kind = 'lags'")


@dataclass(frozen=True, slots=True, kw_only=True)
class IntegratingLag(_Record):
    """`gain e^(-s dead_time)/(s integral_time (1 + s lag))`."""

    gain: float = parameter(1.0, meaning="over integral_time: rate of the output per input", least=1 / MOST, most=MOST)
    integral_time: float = parameter(
        meaning="until the output has moved by the input", unit="s", least=1 / MOST, most=MOST, example=1.0
    )
    lag: float = parameter(0.0, meaning="time constant", unit="s", least=0.0, most=MOST, example=0.1)
    dead_time: float = parameter(0.0, meaning="until the output moves", unit="s", least=0.0, most=MOST)

    def process(self) -> tuple[Array, Array, float]:
        """Numerator, denominator, dead time."""
        num, den = _chain(self.gain, (self.lag,) if self.lag > 0.0 else ())
        return num, np.append(self.integral_time * den, 0.0), self.dead_time


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferFunction(_Record):
    """`e^(-s dead_time) num(s)/den(s)`, coefficients by falling powers of s."""

    num: tuple[float, ...] = parameter(meaning="numerator, falling powers of s", example=(1.0,))
    den: tuple[float, ...] = parameter(meaning="denominator, falling powers of s", example=(1.0, 1.0))
    dead_time: float = parameter(0.0, meaning="until the output moves", unit="s", least=0.0, most=MOST)

    def process(self) -> tuple[Array, Array, float]:
        """Numerator, denominator, dead time."""
        return np.array(self.num), np.array(self.den), self.dead_time


def _made(record: Any) -> Process:
    num, den, dead_time = record.process()
    keys = {name: list(value) if isinstance(value, tuple) else value for name, value in asdict(record).items()}
    return Process(tuple(num), tuple(den), dead_time, {"kind": kind_of(type(record)), **keys})


def kind_of(record: type[Any]) -> str:
    """Return the kind whose keys are a record's."""
    return next(name for name in PROCESSES.own if PROCESSES[name].record is record)


_SOURCE = "Astrom, Hagglund, Advanced PID Control, 2006, ch. 2; specification 04.2"

PROCESSES = Table(
    "processes",
    "kind of process",
    "a `Process`",
    {
        "dead_time": Method("nothing but dead time", _made, _SOURCE, DeadTime),
        "lag_dead_time": Method("one lag, with dead time or without", _made, _SOURCE, LagDeadTime),
        "two_lags": Method("two lags, with dead time or without", _made, _SOURCE, TwoLags),
        "lags": Method("any number of lags, with dead time or without", _made, _SOURCE, Lags),
        "integrating_lag": Method("integrator, with a lag and dead time or without", _made, _SOURCE, IntegratingLag),
        "transfer_function": Method("numerator and denominator, with dead time or without", _made, _SOURCE,
                                    TransferFunction),
    },
)  # fmt: skip


def make_process(given: Process | Mapping[str, Any]) -> Process:
    """Return a process from its kind and keys.

    Parameters
    ----------
    given
        `kind` of `PROCESSES` (not needed with `num` and `den`) and its keys; times in s. Or a process, as it is.

    Raises
    ------
    UnknownName
        No such kind or key; lists what there is.
    InputError
        A key that is missing.
    ModelError, OutOfLimits
        As `Process`; a number outside its range.
    """
    if isinstance(given, Process):
        return given
    if not isinstance(given, Mapping):
        raise InputError(f'process: {given!r} came; give a Process, or its keys, {{"kind": "lag_dead_time", "lag": 1}}')
    keys = dict(given)
    kind = keys.pop("kind", "transfer_function" if "num" in keys and "den" in keys else None)
    if not isinstance(kind, str):
        raise InputError(f"process: kind is {kind!r}; it must be one of {', '.join(PROCESSES)}")
    found: Process = PROCESSES.make(kind, keys)
    return found

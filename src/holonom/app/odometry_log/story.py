"""Whether wheels and truth tell one story, and if not, which mistake in the columns would explain it.

The motion of the base over windows, in its own frame, is compared: by the wheels with the nominal geometry, and by the
truth as it stands or read otherwise (columns swapped, signs turned, other units). Geometry that is a little wrong
changes a window by a little, whatever it does to a long path; a wrong column changes all of them by much.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.app.odometry_log.motion import moved
from holonom.app.odometry_log.table import Table
from holonom.arrays import Array
from holonom.errors import LogError
from holonom.mobile.calibration import Motion, Run, dead_reckoning, lever_of, seen_from, truth_frame

__all__ = ["check_columns", "judge_miss"]


SPAN = 0.5  # s, least length of a window
STRIDES = 8  # windows that a run should have at least
NONE = 1e-5  # a motion so much smaller than the other has no unit: one of them stood still
BEND = 0.7  # rad, that a window turns in the mean at most
STILL = 0.02  # m, of wheels and truth, below which there is nothing to compare
ASTRAY = 0.1  # share of the motion by which wheels and truth must disagree before another reading is looked for
CLEARER = 0.5  # another reading must leave less than this share of the disagreement
ALIKE, NEAR = 1.3, 0.02  # readings that leave so little more than the best one are as good
HOPELESS = 0.5  # share of the motion above which a log is refused although no reading explains it
DOUBTFUL = 0.3  # share above which it is noted
FACTOR = 1.5  # by which way and turn of wheels and truth may differ in the mean
FEW_WAYS, FEW_TURNS = 0.3, 0.1  # shares of a motion that are too small to tell a unit: noise makes way on the spot

MANY = 5  # wheels whose orders are all tried
MOST = 3  # mistakes in a message that would explain a log alike

POSITIONS = {"mm": 1e-3, "cm": 1e-2, "inch": 0.0254}
DEGREES = np.pi / 180.0


@dataclass(frozen=True, slots=True)
class _Reading:
    """One way to read a log: what is wrong (in words), how many things are, the motion it gives."""

    faults: tuple[str, ...]
    wheels: Array
    truth: Array

    def scaled(self) -> tuple[_Reading, float, float]:
        """With ways and turns of the truth scaled to those of the wheels where they differ beyond reason; factors."""
        way, turn = _factors(self.wheels, self.truth)
        return _Reading(self.faults, self.wheels, self.truth * [way, way, turn]), way, turn

    @property
    def miss(self) -> float:
        """Share of the motion by which wheels and truth disagree."""
        size = max(float(np.abs(self.wheels).sum()), float(np.abs(self.truth).sum()))
        return float(np.abs(self.wheels - self.truth).sum()) / max(size, 1e-12)


@dataclass(frozen=True, slots=True)
class _Candidate:
    reading: _Reading
    miss: float
    faults: tuple[str, ...]


def check_columns(
    table: Table, run: Run, motion: Array | Motion, wheels: Sequence[str]
) -> tuple[float, tuple[float, float, float] | None]:
    """Refuse a log in which a wrong column, sign or unit keeps wheels and truth apart; name it.

    Parameters
    ----------
    table : the run as it was read, for messages.
    run : the same in SI units, with truth.
    motion : of the nominal geometry, what `dead_reckoning` takes.
    wheels : names of the columns of the run's wheels.

    Returns
    -------
    Share of the motion by which wheels and truth disagree, for no reason that is known; where the truth's frame is
    on the base, m and rad, if it is turned so much that this explains the most.

    Raises
    ------
    LogError
    """
    view = _View(run, motion)
    plain = view.reading()
    if max(np.abs(plain.wheels).sum(), np.abs(plain.truth).sum()) < STILL:
        return 0.0, None
    if plain.miss <= ASTRAY:
        return plain.miss, None
    candidates = [_candidate(reading) for reading in (plain, *_truths(view), *_wheels(view, wheels))]
    best = min(c.miss for c in candidates)
    frame = truth_frame(run, motion)
    turned = _View(run, seen_from(motion, frame)).reading().miss
    if turned < min(CLEARER * plain.miss, ASTRAY) and ALIKE * turned + NEAR < best:
        return turned, frame
    good = [c for c in candidates if c.miss <= ALIKE * best + NEAR]
    least = min(len(c.faults) for c in good)
    if least > 0 and best < CLEARER * plain.miss:
        named = [c for c in good if len(c.faults) == least]
        _refuse(table, plain.miss, sorted(named, key=lambda c: c.miss))
    return plain.miss, None


def judge_miss(table: Table, miss: float) -> tuple[str, ...]:
    """Refuse, or note, wheels and truth that disagree by much for no reason that is known.

    Raises
    ------
    LogError
    """
    if miss > HOPELESS:
        raise LogError(
            f"{table.path}: wheels and truth disagree by {miss:.0%} of the motion, and no swapped column, sign or unit "
            "explains it: see that both are of one run, in one clock, and the geometry"
        )
    if miss < DOUBTFUL:
        return ()
    return (
        f"{table.path}: wheels and truth disagree by {miss:.0%} of the motion: slip, noise, or a geometry that is far "
        "off; look at the picture of the paths",
    )


class _View:
    """Motion over windows of one run, of any reading of it."""

    def __init__(self, run: Run, motion: Array | Motion) -> None:
        self.run, self.motion = run, motion
        self.lever = lever_of(motion)
        path = dead_reckoning(run, motion)
        self.at = _ends(run, path, self.lever)
        self.by_wheels = self._moved(path)

    def _moved(self, poses: Array) -> Array:
        return moved(poses, self.at[:-1], self.at[1:], self.lever)

    def reading(self) -> _Reading:
        return _Reading((), self.by_wheels, self.truth(self.run.truth, 2.0 * np.pi))

    def truth(self, poses: Array, period: float, *, scale: ArrayLike = (1.0, 1.0, 1.0)) -> Array:
        turned = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2], period=period)]) * np.asarray(scale)
        return self._moved(turned)

    def wheels(self, signs: Array, order: Sequence[int], steering: float | Array = 1.0) -> Array:
        run = self.run
        other = Run(run.name, run.time, run.turns[:, order] * signs, run.truth, steering * run.steering)
        return self._moved(dead_reckoning(other, self.motion))


def _ends(run: Run, path: Array, lever: float) -> NDArray[np.intp]:
    """Ends of windows: half a second, or as long as the wheels take for half a lever; not too few, nor too bent."""
    at = np.arange(len(path))
    every = np.abs(moved(path, at[:-1], at[1:], lever)).sum()
    by_time = SPAN / float(np.median(np.diff(run.time)))
    by_way = 0.5 * lever * len(path) / max(float(every), 1e-12)
    turned = float(np.abs(np.diff(path[:, 2])).mean())
    most = max(1, min((len(path) - 1) // STRIDES, int(BEND / max(turned, 1e-12))))
    return np.arange(0, len(path), int(np.clip(max(by_time, by_way), 1, most)))


def _factors(wheels: Array, truth: Array) -> tuple[float, float]:
    """By what ways and turns of the truth must be multiplied; 1 where they are near or tell nothing."""
    ways = [float(np.hypot(m[:, 0], m[:, 1]).sum()) for m in (wheels, truth)]
    turns = [float(np.abs(m[:, 2]).sum()) for m in (wheels, truth)]
    return _factor(ways, turns, FEW_WAYS), _factor(turns, ways, FEW_TURNS)


def _factor(sizes: Sequence[float], others: Sequence[float], small: float) -> float:
    told = min(sizes) > NONE * max(sizes) > NONE * STILL and any(
        size > small * other for size, other in zip(sizes, others, strict=True)
    )
    return sizes[0] / sizes[1] if told and not 1.0 / FACTOR < sizes[0] / sizes[1] < FACTOR else 1.0


def _truths(view: _View) -> Iterator[_Reading]:
    """Readings of the truth with one or two faults."""
    for k in (1, 2):
        for chosen in itertools.combinations(_FAULTS_OF_TRUTH, k):
            if len({fault.kind for fault in chosen}) == k or all(fault.kind == "sign" for fault in chosen):
                yield _read_truth(view, chosen)


@dataclass(frozen=True, slots=True)
class _Fault:
    """Of the truth's columns: how they come right, in the order swap, degrees, sign, turn."""

    kind: str
    text: str
    order: tuple[int, int, int] = (0, 1, 2)
    degrees: bool = False
    signs: tuple[float, float, float] = (1.0, 1.0, 1.0)
    turn: float = 0.0


_FAULTS_OF_TRUTH = (
    _Fault("swap", "columns {x} and {y} are swapped", (1, 0, 2)),
    _Fault("swap", "columns {x} and {theta} are swapped", (2, 1, 0)),
    _Fault("swap", "columns {y} and {theta} are swapped", (0, 2, 1)),
    _Fault("swap", "columns {x}, {y}, {theta} hold y, theta, x", (2, 0, 1)),
    _Fault("swap", "columns {x}, {y}, {theta} hold theta, x, y", (1, 2, 0)),
    _Fault("unit", "column {theta} is in degrees instead of rad", degrees=True),
    _Fault("sign", "column {x} counts the other way", signs=(-1.0, 1.0, 1.0)),
    _Fault("sign", "column {y} counts the other way", signs=(1.0, -1.0, 1.0)),
    _Fault("sign", "column {theta} counts the other way", signs=(1.0, 1.0, -1.0)),
    *(_Fault("turn", f"column {{theta}} is not the heading from x, but {a:+d} degrees off", turn=np.radians(a))
      for a in (90, -90, 180)),
)  # fmt: skip


def _read_truth(view: _View, faults: Sequence[_Fault]) -> _Reading:
    poses, scale, period = view.run.truth, np.ones(3), 2.0 * np.pi
    for fault in faults:
        poses, scale = poses[:, list(fault.order)], scale * fault.signs
        if fault.degrees:
            scale, period = scale * [1.0, 1.0, DEGREES], 360.0
    motion = view.truth(poses, period, scale=scale)
    angle = sum(fault.turn for fault in faults)
    c, s = np.cos(angle), np.sin(angle)
    turned = motion @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return _Reading(tuple(fault.text for fault in faults), view.by_wheels, turned)


def _wheels(view: _View, wheels: Sequence[str]) -> Iterator[_Reading]:
    """Readings of the wheels and of the steering: another order, a wheel that counts the other way."""
    truth, count = view.reading().truth, len(wheels)
    plain, whole = tuple(range(count)), np.ones(count)
    for order in _orders(count):
        if order != plain:
            yield _Reading((_order_text(order, wheels),), view.wheels(whole, order), truth)
    for k in range(count):
        signs = np.where(np.arange(count) == k, -1.0, 1.0)
        yield _Reading((f"column {{{wheels[k]}}} counts the other way",), view.wheels(signs, plain), truth)
    if count > 1:
        named = ", ".join(f"{{{wheel}}}" for wheel in wheels)
        yield _Reading((f"columns {named} all count the other way",), view.wheels(-whole, plain), truth)
    if view.run.steering.size:
        several = view.run.steering.shape[1] > 1
        text = "all steering columns count the other way" if several else "column {steering} counts the other way"
        yield _Reading((text,), view.wheels(whole, plain, -1.0), truth)


def _orders(count: int) -> Iterator[tuple[int, ...]]:
    """Every order of few wheels; of many those with two of them swapped."""
    plain = tuple(range(count))
    if count <= MANY:
        yield from itertools.permutations(plain)
        return
    for i, j in itertools.combinations(plain, 2):
        swapped = list(plain)
        swapped[i], swapped[j] = j, i
        yield tuple(swapped)


def _order_text(order: Sequence[int], wheels: Sequence[str]) -> str:
    wrong = ", ".join(f"{{{wheels[k]}}}" for k, at in enumerate(order) if at != k)
    return f"columns {wrong} are swapped: read in the order {', '.join(wheels[k] for k in order)} they follow the truth"


def _candidate(reading: _Reading) -> _Candidate:
    """With a fault more where ways or turns differ by a factor; turns that do not follow have none, they are noise."""
    scaled, way, turn = reading.scaled()
    turns, true = scaled.wheels[:, 2], scaled.truth[:, 2]
    noise = np.abs(turns - true).sum() > max(np.abs(turns).sum(), np.abs(true).sum())
    if way == turn == 1.0 or (turn != 1.0 and noise):
        return _Candidate(reading, reading.miss, reading.faults)
    return _Candidate(scaled, scaled.miss, (*reading.faults, _unit(way, turn)))


def _unit(way: float, turn: float) -> str:
    """What may be wrong where ways and turns of the truth must be multiplied by so much to be those of the wheels."""
    if way != 1.0 and turn != 1.0 and 1.0 / FACTOR < way / turn < FACTOR:
        return (f"by its wheels the base moves and turns {way:.4g} times what the truth says: see diameters, encoder, "
                "gear, and whether wheels are in ticks, rad, or running counts")  # fmt: skip
    told = []
    if way != 1.0:
        told.append(f"by its wheels the base gets {way:.4g} times as far as by the truth: {_length(way)}")
    if turn != 1.0:
        told.append(f"by its wheels the base turns {turn:.4g} times what the truth says: {_angle(turn)}")
    return "; ".join(told)


def _length(way: float) -> str:
    for ratio, what, other in ((way, "columns {x}, {y}", "geometry or wheels"),
                               (1.0 / way, "geometry or wheels", "columns {x}, {y}")):  # fmt: skip
        for name, factor in POSITIONS.items():
            if 1.0 / 1.2 < ratio / factor < 1.2:
                return f"{what} in {name} instead of m ({other} may be wrong as well)"
    return "the unit of columns {x}, {y}, or of the geometry altogether"


def _angle(turn: float) -> str:
    if 1.0 / 1.2 < turn / DEGREES < 1.2:
        return "column {theta} in degrees instead of rad"
    for name, factor in POSITIONS.items():
        if 1.0 / 1.2 < turn / factor < 1.2:
            return f"the distance between the wheels in {name} instead of m, or column {{theta}} in another unit"
    return "the distance between the wheels, or the unit of column {theta}"


def _refuse(table: Table, miss: float, named: Sequence[_Candidate]) -> NoReturn:
    """Say which columns are wrong, or which of several mistakes it is."""
    places = {name: f"{table.place(name)} ({name})" for name in table.names}
    texts = list(dict.fromkeys(" and ".join(c.faults).format_map(places) for c in named))[:MOST]
    raise LogError(
        f"{table.path}:{table.lines[0]}: {', or '.join(texts)}; as they stand wheels and truth disagree by {miss:.0%} "
        f"of the motion, read so by {named[0].miss:.0%}: put it right in the log or in its description"
    )

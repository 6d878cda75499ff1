"""Forward model of a whole base: the twist that fits its rolling and sliding rows best; traced, or on floats.

A wheel that rolls driven and must not slide fixes both components of its contact's velocity, whatever its heading:
its share u u^T + n n^T of the normal matrix is constant. Only wheels that steer and are not driven make it vary.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.equations.base_models import Axle, Layout
from holonom.mobile.equations.wheels import ROUNDING, Row, summed, unit
from holonom.numeric.small import solve_symmetric3
from holonom.trace import Number, absolute, less, select

__all__ = ["DETERMINED", "always_determined", "twist_of_speeds"]

DETERMINED = 1e-9
"""Determinant of the normal matrix, over about the largest that it could have, below which no twist is determined."""


def twist_of_speeds(layout: Layout, speeds: Row, axles: Sequence[Axle]) -> tuple[Row, Number]:
    """Forward model: the twist that fits rolling and sliding rows best (least squares in m/s, w scaled by the radius).

    Also how well it is determined: determinant of the normal matrix over the cube of a third of its usual trace.
    """
    normal, varying = _constant_share(layout), _varying(layout)
    for i in varying:
        normal = _with(normal, _sliding(layout, layout.wheels[i], axles[i]))
    solution, determinant = solve_symmetric3(normal, _right(layout, speeds, axles))
    return [solution[0], solution[1], solution[2] / layout.radius], determinant * _usual_trace(layout) ** -3


def always_determined(layout: Layout) -> bool:
    """Whether the twist is determined at any steering: the constant share of the normal matrix is enough."""
    _, determinant = solve_symmetric3(_constant_share(layout), [0.0, 0.0, 0.0])
    return less(DETERMINED, determinant * _usual_trace(layout) ** -3) is True


def _right(layout: Layout, speeds: Row, axles: Sequence[Axle]) -> Row:
    """Right side: driven rows times their rim speeds, as forces at the contacts and their moment over the radius."""
    values = iter(speeds)
    fx: Row = []
    fy: Row = []
    moment: Row = []
    for wheel, axle in zip(layout.wheels, axles, strict=True):
        for row in KINDS[wheel.kind].rolling(wheel, *axle) if wheel.driven else []:
            rim = next(values) * wheel.radius
            fx.append(row[0] * rim)
            fy.append(row[1] * rim)
            steered = wheel.kind == "steered"
            moment += [wheel.x * fy[-1], -wheel.y * fx[-1]] if steered else [row[2] * rim]
    return [summed(fx), summed(fy), summed(moment) * (1.0 / layout.radius)]


def _constant_share(layout: Layout) -> list[Row]:
    """Normal matrix of all rows but those of `_varying`; entries that are 0 but for rounding are 0."""
    normal: list[Row] = [[0.0, 0.0, 0.0] for _ in range(3)]
    varying = _varying(layout)
    for i, wheel in enumerate(layout.wheels):
        if i not in varying:
            s, c = unit(wheel.axle)
            rolling = KINDS[wheel.kind].rolling(wheel, s, c) if wheel.driven else []
            normal = _with(normal, [*_scaled(layout, rolling), *_sliding(layout, wheel, (s, c))])
    least = ROUNDING * _usual_trace(layout)
    return [[select(less(absolute(n), least), 0.0, n) for n in line] for line in normal]


def _varying(layout: Layout) -> list[int]:
    return [i for group in layout.groups for i in group if not layout.wheels[i].driven]


def _sliding(layout: Layout, wheel: Wheel, axle: Axle) -> list[Row]:
    return _scaled(layout, KINDS[wheel.kind].sliding(wheel, *axle))


def _scaled(layout: Layout, rows: Iterable[Row]) -> list[Row]:
    return [[row[0], row[1], row[2] * (1.0 / layout.radius)] for row in rows]


def _with(normal: Sequence[Row], rows: Iterable[Row]) -> list[Row]:
    """The normal matrix with the squares of more rows."""
    found = [list(line) for line in normal]
    for row in rows:
        found = [[n + row[i] * row[j] for j, n in enumerate(line)] for i, line in enumerate(found)]
    return found


def _usual_trace(layout: Layout) -> float:
    """A third of the trace of the normal matrix if each row is a unit vector with a moment of l / radius."""
    rows = [
        (w, len(KINDS[w.kind].rolling(w, 0.0, 1.0)) * w.driven + len(KINDS[w.kind].sliding(w, 0.0, 1.0)))
        for w in layout.wheels
    ]
    return sum(n * (1.0 + (w.l / layout.radius) ** 2) for w, n in rows) / 3.0

"""Forward model of a whole base: it keeps the sliding rows and fits the rolling rows best; traced, or on floats.

A constraint is no measurement: wheels that must not slide say in which directions the base may move, motors how fast.
Fixed wheels first: the twists that drag none of them are a subspace, P its projector. In it the rows of the wheels
that steer and drive are fitted by least squares: such a module measures the whole velocity of its contact, so its share
u u^T + n n^T of the normal matrix is constant whatever its heading. Wheels that steer and are not driven only lead. So
few that some motion is left at any angles narrow the subspace, by Gram and Schmidt. More of them, such as the front
wheels of a car, leave one only where their axles meet: the fitted twist v is turned to where they lead, by one step of
inverse iteration with A = sum of their sliding rows squared, `d ~ (A + e 1)^-1 v` (Golub & Van Loan, Matrix
Computations, 7.6.1), which drags none of them if they do meet, and as little as can be where not. Then d is made as
long as the rolling rows have it. Of a driven castor only the rolling row counts, at its angle.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.equations.base_models import Axle, Layout, rolling_rows, speed_along
from holonom.mobile.equations.wheels import ROUNDING, Row, summed, unit
from holonom.numeric.small import solve_symmetric3
from holonom.trace import Number, absolute, less, maximum, select

__all__ = ["DETERMINED", "always_determined", "twist_of_speeds"]

SOFT = 1e-11
"""Added to the sum of squared sliding rows, over its usual size: axles that all coincide leave two directions open."""
RANK = 1e-7
"""Singular value of the fixed wheels' sliding rows below which they leave a motion free."""
DETERMINED = 1e-9
"""Determinant of the normal matrix, over about the largest that it could have, below which no twist is determined."""


def twist_of_speeds(layout: Layout, speeds: Row, axles: Sequence[Axle]) -> tuple[Row, Number]:
    """Forward model: the twist that keeps all sliding rows and fits the rolling rows best (w scaled by the radius).

    Also how well it is determined: determinant of the normal matrix over the cube of a third of its usual trace.
    """
    P, right = _projector(layout), _right(layout, speeds, axles)
    normal, varying = _with(_constant_share(layout), _swung(layout, P, axles)), _varying(layout)
    if varying and len(varying) < round(sum(float(P[k][k]) for k in range(3))):
        Q = _narrowed(P, [row for i in varying for row in _sliding(layout, layout.wheels[i], axles[i])])
        v, determinant = solve_symmetric3(_between(layout, Q, normal), _times(Q, right))
        return [v[0], v[1], v[2] / layout.radius], determinant * _usual_trace(layout) ** -3
    for i in varying:
        normal = _with(normal, _projected(P, _sliding(layout, layout.wheels[i], axles[i])))
    v, determinant = solve_symmetric3(normal, _times(P, right))
    if varying:
        A: list[Row] = _outside(layout, P)
        for i in varying:
            A = _with(A, _projected(P, _sliding(layout, layout.wheels[i], axles[i])))
        d = _times(P, _turned(A, v, SOFT * _usual_trace(layout)))
        v = _lengthened(layout, d, right, axles)
    return [v[0], v[1], v[2] / layout.radius], determinant * _usual_trace(layout) ** -3


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
    """Normal matrix of all rows but those of `_varying`, in the subspace of the fixed wheels and 1 outside of it.

    Entries that are 0 but for rounding are 0.
    """
    P, varying = _projector(layout), _varying(layout)
    normal: list[Row] = _outside(layout, P)
    for i, wheel in enumerate(layout.wheels):
        if i not in varying:
            s, c = unit(wheel.axle)
            rolls = wheel.driven and wheel.kind != "castor"
            rolling = KINDS[wheel.kind].rolling(wheel, s, c) if rolls else []
            sliding = _sliding(layout, wheel, (s, c)) if wheel.kind == "steered" else []
            normal = _with(normal, _projected(P, [*_scaled(layout, rolling), *sliding]))
    least = ROUNDING * _usual_trace(layout)
    return [[select(less(absolute(n), least), 0.0, n) for n in line] for line in normal]


def _swung(layout: Layout, P: Sequence[Row], axles: Sequence[Axle]) -> list[Row]:
    """Rolling rows of driven castors, in the subspace of the fixed wheels: of one direction each, which turns."""
    castors = [(w, axle) for w, axle in zip(layout.wheels, axles, strict=True) if w.powered_castor]
    return [row for w, axle in castors for row in _projected(P, _scaled(layout, KINDS[w.kind].rolling(w, *axle)))]


def _projector(layout: Layout) -> list[Row]:
    """P (3, 3): twists, w scaled, to the nearest that drag no fixed wheel. Constant."""
    rows = [row for w in layout.wheels if w.kind != "steered" for row in _sliding(layout, w, unit(w.axle))]
    P = np.eye(3)
    if rows:
        _, s, Vt = np.linalg.svd(np.array(rows, dtype=float))
        seen = Vt[: int(np.count_nonzero(s > RANK))]
        P = P - seen.T @ seen
    P[np.abs(P) < ROUNDING] = 0.0
    return [[float(p) for p in line] for line in P]


def _outside(layout: Layout, P: Sequence[Row]) -> list[Row]:
    """Usual size times what P leaves out: it keeps a matrix regular that has nothing there."""
    usual = _usual_trace(layout)
    return [[usual * ((1.0 if i == j else 0.0) - P[i][j]) for j in range(3)] for i in range(3)]


def _narrowed(P: Sequence[Row], rows: Iterable[Row]) -> list[Row]:
    """The projector on twists that those rows do not see either; rows without anything new count for nothing."""
    Q = [list(line) for line in P]
    for row in rows:
        seen = _times(Q, row)
        square = _sum_of(seen, seen)
        part = select(less(square, RANK * RANK), 0.0, 1.0) / maximum(square, RANK * RANK)
        Q = [[q - part * seen[i] * seen[j] for j, q in enumerate(line)] for i, line in enumerate(Q)]
    return Q


def _between(layout: Layout, Q: Sequence[Row], normal: Sequence[Row]) -> list[Row]:
    """Normal matrix within a projector, and 1 outside of it."""
    half = [[_sum_of(line, [n[j] for n in normal]) for j in range(3)] for line in Q]
    outside = _outside(layout, Q)
    return [[_sum_of(half[i], Q[j]) + outside[i][j] for j in range(3)] for i in range(3)]


def _times(P: Sequence[Row], x: Row) -> Row:
    return [_sum_of(line, x) for line in P]


def _sum_of(line: Row, x: Row) -> Number:
    """Sum of products, without those that are 0 in a constant line."""
    terms = [a * b for a, b in zip(line, x, strict=True) if not (isinstance(a, float) and a == 0.0)]
    return summed(terms) if terms else 0.0


def _projected(P: Sequence[Row], rows: Iterable[Row]) -> list[Row]:
    return [_times(P, row) for row in rows]


def _turned(A: Sequence[Row], v: Row, soft: float) -> Row:
    """The direction (A + soft)^-1 v: a twist of any length that A sees as little as can be."""
    softened = [[a + soft if i == j else a for j, a in enumerate(line)] for i, line in enumerate(A)]
    d, _ = solve_symmetric3(softened, v)
    return [x * soft for x in d]


def _lengthened(layout: Layout, d: Row, right: Row, axles: Sequence[Axle]) -> Row:
    """The twist along d (w scaled) that fits the rolling rows best: `d (D d . m) / |D d|^2`."""
    twist: Row = [d[0], d[1], d[2] * (1.0 / layout.radius)]
    along = [speed_along(w, row, twist) for w, row in rolling_rows(layout, axles)]
    square = summed([a * a for a in along])
    part = _sum_of(d, right) / maximum(square, 1e-300)
    return [part * x for x in d]


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

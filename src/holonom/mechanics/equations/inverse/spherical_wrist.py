"""Inverse of a 6-joint arm whose last three axes meet: the wrist centre gives q1..q3, the rest of the turn q4..q6.

Pieper 1968; Siciliano 2.12; Elias & Wen 2022. T_06 = E1 ... E6 M, G = T_06 M^-1 = (R, p); c the wrist centre at home,
which the wrist leaves in place: E1 E2 E3 c = G c. Then R4 R5 R6 = (R1 R2 R3)^T R.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.mechanics.equations.inverse.regional import Regional
from holonom.mechanics.equations.inverse.subproblems import (
    Branch,
    Screw,
    Truth,
    Value,
    reverse,
    rotated,
    turn_onto,
    turns_to_level,
    unrotated,
)
from holonom.mechanics.equations.vectors import Pose, Vector, add, cross, dot, matvec, sub
from holonom.trace import Number

__all__ = ["across", "sine_square", "spherical_wrist"]


def spherical_wrist(screws: Sequence[Screw], regional: Regional, G: Pose) -> list[Branch]:
    """Those of the first joints, three or two, each with the wrist's two."""
    R, p = G
    arm, wrist = screws[:-3], screws[-3:]
    centre = wrist[0].p
    h6, x6 = wrist[2].h, across(wrist[2].h)
    u, x = matvec(R, h6), matvec(R, x6)
    branches = []
    for reached in regional(arm, centre, add(matvec(R, centre), p)):
        u36, x36 = (unrotated(list(arm), reached.values, v) for v in (u, x))
        for values, free in _wrist(wrist, x6, u36, x36):
            branches.append(Branch([*reached.values, *values], reached.free | free))
    return branches


def _wrist(wrist: Sequence[Screw], x6: Vector, u: Vector, x: Vector) -> list[tuple[list[Value], Truth]]:
    """Both solutions of R4 R5 R6 = R_36 from u = R_36 h6 and x = R_36 x6; q5 beyond the straight wrist first."""
    (h4, h5, h6), (rest4, rest5, rest6) = [s.h for s in wrist], [s.rest for s in wrist]
    turns, _ = turns_to_level(h5, h6, h4, dot(h4, u), rest5, sine_square=sine_square(h4, h5, h6, u))
    found: list[tuple[list[Value], Truth]] = []
    for q5 in turns:
        q4, free = turn_onto(h4, rotated(h5, q5, h6), u, rest4)
        back = rotated(h5, reverse(q5), rotated(h4, reverse(q4), x))
        q6, _ = turn_onto(h6, x6, back, rest6)
        found.append(([q4, q5, q6], free))
    return found


def sine_square(h4: Vector, h5: Vector, h6: Vector, u: Vector) -> Number | None:
    """A^2 + B^2 - D^2 of h4 . R5 h6 = h4 . u where the wrist can stretch or fold; exact there, without cancellation."""
    a, b = np.array(h6, dtype=float), np.array(h4, dtype=float)
    axis = np.array(h5, dtype=float)
    level = float(axis @ a) * float(axis @ b)
    rho = float(np.hypot(a @ b - level, b @ np.cross(axis, a)))
    stretches, folds = abs(rho + level - 1.0) < 1e-12, abs(rho - level - 1.0) < 1e-12
    if stretches and folds:
        w = cross(h4, u)
        return dot(w, w)
    if stretches:
        w = sub(u, h4)
        return 0.5 * dot(w, w) * (rho - level + dot(h4, u))
    if folds:
        w = add(u, h4)
        return 0.5 * dot(w, w) * (rho + level - dot(h4, u))
    return None


def across(h: Vector) -> tuple[float, float, float]:
    """A unit vector across h, a coordinate axis if there is one."""
    k = int(np.argmin(np.abs(np.array(h, dtype=float))))
    e = np.eye(3)[k] - np.array(h, dtype=float) * float(h[k])
    x, y, z = (float(v) for v in e / np.linalg.norm(e))
    return x, y, z

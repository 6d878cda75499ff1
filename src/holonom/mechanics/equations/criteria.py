"""What a redundant arm is to prefer among the joint vectors that reach a pose: functions to be maximised.

A criterion is `f(model, q, preferred) -> number`, over floats or traced scalars (Siciliano et al., Robotics, 3.5.1).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from holonom.mechanics.equations.kinematics import jacobian
from holonom.mechanics.equations.vectors import Vector, dot
from holonom.model import ArmModel
from holonom.trace import Number, maximum, sqrt

__all__ = ["CRITERIA", "Criterion", "distance_from_limits", "manipulability", "nearness"]

Criterion = Callable[[ArmModel, Vector, Vector], Number]


def distance_from_limits(model: ArmModel, q: Vector, preferred: Vector) -> Number:
    """-1/2 sum ((q - middle) / range)^2 over the joints that have limits (eq. 3.58 without the 1/n)."""
    del preferred
    total: Number = 0.0
    for i, value in zip(model.independent, q, strict=True):
        limits = model.limits(i)
        span = limits.upper - limits.lower
        if math.isfinite(span):
            off = (value - (limits.lower + 0.5 * span)) * (1.0 / span)
            total = total - 0.5 * off * off
    return total


def manipulability(model: ArmModel, q: Vector, preferred: Vector) -> Number:
    """Yoshikawa's sqrt(det J J^T), of J^T J where there are fewer than six joints (eq. 3.56)."""
    del preferred
    n = len(q)
    entries = jacobian(model, q, "world")
    rows = [entries[n * i : n * i + n] for i in range(6)]
    if n < 6:
        rows = [list(column) for column in zip(*rows, strict=True)]
    A = [[dot(a, b) for b in rows] for a in rows]
    determinant: Number = 1.0
    for j, row in enumerate(A):
        pivot = maximum(row[j], 1e-12)
        determinant = determinant * pivot
        for i in range(j + 1, len(A)):
            ratio = row[i] / pivot
            for k in range(i, len(A)):  # symmetric: the upper triangle is enough
                A[i][k] = A[i][k] - ratio * row[k]
    return sqrt(determinant)


def nearness(model: ArmModel, q: Vector, preferred: Vector) -> Number:
    """-1/2 |q - preferred|^2."""
    del model
    total: Number = 0.0
    for value, wanted in zip(q, preferred, strict=True):
        total = total - 0.5 * (value - wanted) * (value - wanted)
    return total


CRITERIA: Mapping[str, Criterion] = {
    "limits": distance_from_limits,
    "manipulability": manipulability,
    "posture": nearness,
}

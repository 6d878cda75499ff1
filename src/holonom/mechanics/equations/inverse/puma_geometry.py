"""The lengths of arms built like the Puma 560 (Paul & Zhang 1986; Corke).

Standard DH with alpha = (90, 0, -90, 90, -90, 0) deg, a1 = a4 = a5 = a6 = 0, d2 + d3 the lateral shoulder offset,
any a2, a3, d1, d4, d6. Nothing assumes a3 = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from holonom.model import ArmModel

__all__ = ["PumaGeometry", "puma_geometry"]


class PumaGeometry(NamedTuple):
    """Lengths (m) of the table above."""

    d1: float
    a2: float
    a3: float
    d3: float
    d4: float
    d6: float


def puma_geometry(model: ArmModel) -> PumaGeometry | None:
    """Return the lengths if the arm is built like a Puma, else None."""
    if len(model.joints) != 6 or not all(j.turns for j in model.joints):
        return None
    after = np.array([j.after for j in model.joints])
    before = np.array([j.before for j in model.joints])
    quarter, none = np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0])  # third row of Rot(x, 90 deg), Rot(x, 0)
    turns = [quarter, none, -quarter, quarter, -quarter, none]
    shape = np.array_equal(before, np.tile(np.eye(4), (6, 1, 1))) and all(
        np.allclose(T[2, :3], turn, atol=1e-12) and np.allclose(T[:3, 0], [1.0, 0.0, 0.0], atol=1e-12)
        for T, turn in zip(after, turns, strict=True)
    )
    a, d = after[:, 0, 3], after[:, 2, 3]
    if not shape or np.any(a[[0, 3, 4, 5]]) or d[4] or a[1] <= 0.0 or d[3] <= 0.0:
        return None
    return PumaGeometry(
        d1=float(d[0]), a2=float(a[1]), a3=float(a[2]), d3=float(d[1] + d[2]), d4=float(d[3]), d6=float(d[5]),
    )  # fmt: skip

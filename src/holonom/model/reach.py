"""How far an arm reaches: the one length scale that solvers, drawings and first programs take."""

from __future__ import annotations

import math

from holonom.model.arm import ArmModel, Transform

__all__ = ["STROKE", "reach"]

STROKE = 1.0
"""What a sliding joint counts at most, m: its limits may be placeholders, and are no length scale."""


def reach(model: ArmModel) -> float:
    """Sum of the lengths between base and tool and of the strokes, each `STROKE` at most, m; 1 where it is 0."""
    total, i = _length(model.tool), model.tool_joint
    while i >= 0:
        joint = model.joints[i]
        total += _length(joint.before) + _length(joint.after)
        if not joint.turns:
            total += min(max(abs(joint.limits.lower), abs(joint.limits.upper)), STROKE)
        i = model.parent(i)
    return total or 1.0


def _length(T: Transform) -> float:
    return math.dist([row[3] for row in T[:3]], (0.0, 0.0, 0.0))

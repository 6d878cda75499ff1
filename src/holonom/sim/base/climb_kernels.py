"""Wheels at the edges of steps, compiled: each centre rises on the arc about an edge, as on a slope under that wheel.

A wheel of radius r whose centre is a distance d before an edge touches it from `d = sqrt(2 r h - h^2)` on, and rises by
`sqrt(r^2 - d^2)`; its load W pushes it back by `W tan(alpha)`, `tan(alpha) = d/sqrt(r^2 - d^2)` (alpha between the
vertical and the line from edge to centre). That work is what the load gains in height: nothing is lost at the edge, as
it would be in a blow. Edges not below the radius stop a wheel, from either side.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.trace.code.compiled import select
from holonom.trace.code.loops import loop
from holonom.trace.code.simd import packed, total

__all__ = ["climb"]

FLAGS = {"contract"}
ONSET = 2e-4  # m of way on which the push of an edge comes on
STOP = 150.0  # rad/s of the stop at a high edge, critically damped
Records = NDArray[np.void]


@loop(error_model="numpy", fastmath=FLAGS)
def climb(steps: Records, body: Any, state: Any, wheels: Records, states: Records) -> None:
    """Set the push of all edges on the base, at its centre of mass along its axes: N, N, N m."""
    state.push_x = state.push_y = state.push_turn = 0.0
    for k in range(len(steps)):
        step = steps[k]
        nx = step.cosine * state.cosine + step.sine * state.sine  # the way up, along the axes of base_link
        ny = step.sine * state.cosine - step.cosine * state.sine
        before = step.cosine * (step.x - state.x) + step.sine * (step.y - state.y)
        if abs(before) > wheels[0].reach[0] + wheels[0].largest[0]:
            continue
        for i in range(len(wheels)):
            wheel, own = packed(wheels[i]), packed(states[i])
            push = _push(wheel, own, state, before - nx * wheel.x - ny * wheel.y, step.height, nx, ny, body.mass)
            state.push_x -= total(nx * push)
            state.push_y -= total(ny * push)
            state.push_turn -= total((wheel.x * ny - wheel.y * nx) * push)


@loop(error_model="numpy", fastmath=FLAGS, forceinline=True)
def _push(wheel: Any, own: Any, state: Any, d: Any, height: float, nx: float, ny: float, mass: float) -> Any:
    """Push (N) of an edge that is a distance d (m) ahead of a wheel, against the way up."""
    r = wheel.radius
    reach = math.sqrt(max(height * (2.0 * r - height), 0.0))
    slope = d / math.sqrt(max(r * r - d * d, 1e-6 * r * r + 1e-12))
    touches = select(d > 0.0, min(max((reach - d) / ONSET, 0.0), 1.0), 0.0)
    deep = max(r - abs(d), 0.0)
    way = select(d > 0.0, 1.0, -1.0)
    speed = nx * (state.vx - state.w * wheel.y) + ny * (state.vy + state.w * wheel.x)
    stop = max(mass * STOP * (STOP * deep + 2.0 * way * speed), 0.0)
    high = way * select(deep > 0.0, stop, 0.0)
    return select(height < r, own.load * slope * touches, high)

"""What the replay shows of a mobile base: body, wheels of any kind, the path to drive, patches of the floor."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

from holonom.app.cell.build.base import deck_height
from holonom.app.cell.model.world import Patch, StepTable
from holonom.app.job import BaseJob
from holonom.app.recording.scope import Scope
from holonom.app.report import Box, Label, Shape, Tube
from holonom.app.report.attachments import EDGE, step_corners, step_name
from holonom.app.rig.wheel_frames import framed_wheels
from holonom.arrays import Array
from holonom.mobile import Wheel, WheelBase, footprint
from holonom.sim import Step
from holonom.spatial import pose

__all__ = ["patch_shapes", "path_shapes", "reach_of", "shapes_of_base", "step_shapes"]

BODY, DECK, RUBBER, METAL, MARK = "#33415c", "#eef1f5", "#1f2937", "#aab4c3", "#d9480f"
WHEEL_WIDTH = 0.45
"""Width of a drawn wheel over its radius."""
LONG = 1.25
"""Length over width of what a base covers, from which its body is drawn as a box."""
BESIDE = 0.3  # m beyond an edge, of its name
DOTS = 120
"""Dots of a drawn path at most."""


def shapes_of_base(job: BaseJob) -> list[Shape]:
    """Shapes of a base in its frame "base_link", in those of its turning wheels, "wheel_1", and castors, "castor_1".

    A body that balances leans in a frame of its own, "body".
    """
    scope = Scope(job.name, ())
    base, body = job.base, scope.frame("base_link")
    shapes = _body(base, scope.frame("body") if base.balances else body)
    framed = framed_wheels(base)
    for number, (_, wheel) in enumerate(framed, 1):
        shapes += _tyre(scope.frame(f"wheel_{number}"), wheel, np.eye(4))
    castor = 0
    for wheel in base.wheels:
        if wheel in [known for _, known in framed]:
            continue
        if wheel.kind == "castor":
            castor += 1
            shapes += _castor(scope.frame(f"castor_{castor}"), wheel)
        else:
            shapes += _FIXED.get(wheel.kind, _still)(body, wheel)
    return shapes


def path_shapes(points: Array) -> list[Shape]:
    """A path (N, 2) dotted on the floor."""
    return [
        Tube("world", (x, y, -0.0015), (x, y, -0.0005), 0.006, "#7c8b9d")
        for x, y in points[:: max(1, len(points) // DOTS)]
    ]


def patch_shapes(patch: Patch) -> list[Shape]:
    """A patch of the floor with its name."""
    x, y = patch.centre
    top = -0.0012
    label = Label("world", pose((x, y, top + 6e-4)), patch.name, 0.06, "#3b6d8f")
    if patch.radius is not None:
        return [Tube("world", (x, y, -0.006), (x, y, top), patch.radius, "#bfe3f5"), label]
    assert patch.size is not None
    T = pose((x, y, top - 0.003))
    T[:3, :3] = Rotation.from_euler("z", patch.angle).as_matrix()
    return [Box("world", T, (*patch.size, 0.006), "#bfe3f5"), label]


def step_shapes(step: StepTable, length: float) -> list[Shape]:
    """The edge of a step with its height, drawn on the floor: bases in the replay stay level with it."""
    edge = Step(step.position, step.height, step.rise)
    middle = step_corners(edge, length).mean(axis=0)
    T = pose((float(middle[0]), float(middle[1]), -0.0025))
    T[:3, :3] = Rotation.from_euler("z", step.rise).as_matrix()
    c, s = math.cos(step.rise), math.sin(step.rise)
    beside = pose((float(middle[0]) + BESIDE * c, float(middle[1]) + BESIDE * s, 4e-4))
    return [Box("world", T, (EDGE, length, 0.004), "#8b7355"), Label("world", beside, step_name(edge), 0.06, "#6b5637")]


def reach_of(base: WheelBase) -> float:
    """Distance of what is drawn of a base from the origin of its base_link at most, m."""
    x, y, rim = _rim(base)
    return math.hypot(x, y) + 1.12 * rim


def _rim(base: WheelBase) -> tuple[float, float, float]:
    """Middle of the wheels and distance of the farthest one from there; of a single ball twice its radius, m."""
    places = np.array([(wheel.x, wheel.y) for wheel in base.wheels])
    x, y = (float(v) for v in 0.5 * (places.min(axis=0) + places.max(axis=0)))
    return x, y, max(float(np.hypot(*(places - (x, y)).T).max()), 2.0 * base.wheels[0].radius)


def _body(base: WheelBase, frame: str) -> list[Shape]:
    """A body above and between the wheels, with a mark at its front; its deck is as high as the frame "top"."""
    size = np.ptp(footprint(base), axis=0)
    return _box_body(base, frame) if size[0] > LONG * size[1] else _drum(base, frame)


def _box_body(base: WheelBase, frame: str) -> list[Shape]:
    """Of a base that is longer than wide, such as a car: no wider than what it covers of the floor."""
    corners, top, r = footprint(base), deck_height(base), max(wheel.radius for wheel in base.wheels)
    (x, y), (length, width) = 0.5 * (corners.min(axis=0) + corners.max(axis=0)), np.ptp(corners, axis=0)
    inner = max(width - 3.2 * r, 0.3 * r)  # between the wheels
    low, deck, plate = 0.5 * r, top - 0.55 * r, top - 0.15 * r
    return [
        Box(frame, pose((x, y, 0.5 * (low + deck))), (0.9 * length, inner, deck - low), BODY),
        Box(frame, pose((x, y, 0.5 * (deck + plate))), (length, width, plate - deck), BODY),
        Box(frame, pose((x, y, 0.5 * (plate + top))), (0.97 * length, 0.92 * width, top - plate), DECK),
        Box(frame, pose((x + 0.32 * length, y, top + 0.04 * r)), (0.28 * length, 0.14 * width, 0.1 * r), MARK),
    ]


def _drum(base: WheelBase, frame: str) -> list[Shape]:
    """Of a base about as long as wide."""
    (x, y, rim), top = _rim(base), deck_height(base)
    r = max(wheel.radius for wheel in base.wheels)
    on_ball = any(wheel.kind == "ball" or (wheel.kind == "spherical" and wheel.driven) for wheel in base.wheels)
    castors = [2.2 * wheel.radius for wheel in base.wheels if wheel.kind == "castor"]
    low = 1.6 * r if on_ball else min(max(0.35 * r, *castors, 0.0), top - 0.8 * r)
    return [
        Tube(frame, (x, y, low), (x, y, top - 0.4 * r), 0.72 * rim, BODY),
        Tube(frame, (x, y, top - 0.5 * r), (x, y, top - 0.15 * r), 1.12 * rim, BODY),
        Tube(frame, (x, y, top - 0.15 * r), (x, y, top), 1.06 * rim, DECK),
        Box(frame, pose((x + 0.62 * rim, y, top + 0.04 * r)), (0.62 * rim, 0.12 * rim, 0.1 * r), MARK),
    ]


def _tyre(frame: str, wheel: Wheel, T: Array) -> list[Shape]:
    """A wheel about the y axis of T (4, 4) in a frame, with a hub and a mark on both faces that shows its turning."""
    r, half = wheel.radius, 0.5 * WHEEL_WIDTH * wheel.radius
    face = half + 0.03 * r

    def bar(start: tuple[float, float, float], end: tuple[float, float, float], radius: float, colour: str) -> Shape:
        a, b = (T[:3, :3] @ np.array(p) + T[:3, 3] for p in (start, end))
        return Tube(frame, tuple(a.tolist()), tuple(b.tolist()), radius, colour)

    return [
        bar((0, -half, 0), (0, half, 0), r, RUBBER),
        bar((0, -face, 0), (0, face, 0), 0.62 * r, METAL),
        bar((0, -face - 0.02 * r, 0.4 * r), (0, face + 0.02 * r, 0.4 * r), 0.14 * r, MARK),
    ]


def _at_rest(wheel: Wheel) -> Array:
    """T (4, 4) in base_link of a wheel at rest; y along the axle."""
    c, s = math.cos(wheel.heading), math.sin(wheel.heading)
    T = pose((wheel.x, wheel.y, wheel.radius))
    T[:3, :3] = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    return T


def _still(frame: str, wheel: Wheel) -> list[Shape]:
    """A wheel that is drawn without turning."""
    return _tyre(frame, wheel, _at_rest(wheel))


def _castor(frame: str, wheel: Wheel) -> list[Shape]:
    """A castor in a frame at its pivot on the floor, x towards its wheel, which the report lets trail."""
    r = wheel.radius
    fork = Tube(frame, (0.0, 0.0, 2.05 * r), (0.0, 0.0, 2.4 * r), 0.25 * r, METAL)
    return [*_tyre(frame, wheel, pose((wheel.castor_offset, 0.0, r))), fork]


def _steered(frame: str, wheel: Wheel) -> list[Shape]:
    """A steered wheel at rest, under its steering column."""
    return [*_tyre(frame, wheel, _at_rest(wheel)), _column(frame, wheel, 2.6 * wheel.radius)]


def _column(frame: str, wheel: Wheel, height: float) -> Shape:
    r = wheel.radius
    return Tube(frame, (wheel.x, wheel.y, 2.05 * r), (wheel.x, wheel.y, height), 0.25 * r, METAL)


def _ball(frame: str, wheel: Wheel) -> list[Shape]:
    x, y, r = wheel.x, wheel.y, wheel.radius
    return [Tube(frame, (x, y, r - 1e-4), (x, y, r + 1e-4), r, RUBBER, rounded=True)]


_FIXED = {"steered": _steered, "spherical": _ball, "ball": _ball}

"""A base from above, by what its recording says of it: wheels, support polygon, and where it stood on its way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from holonom.app.recording import Recording
from holonom.app.report.drawing.robot_map import MapRobot, RobotOutline, WheelOutline
from holonom.app.report.findings.facts import RobotFacts
from holonom.arrays import Array
from holonom.errors import HolonomError, ModelError
from holonom.mobile import WheelBase, centre_of_twist, contact_points, footprint, static_margin, support_polygon

__all__ = ["base_of", "castors_along", "margin_of", "outline_of", "stations"]

PAD = 0.08
"""Skin around the wheels, over the base's radius."""
MOST = 5000
"""Poses that are looked through along a path."""
APART = 2.0
"""Between two places at which a base is drawn, over its radius."""
REACH = 8.0
"""How far off a centre of rotation is drawn, over the base's radius."""
STILL = 0.02
"""rad/s below which a base does not turn."""


def base_of(robot: RobotFacts) -> WheelBase | None:
    """The base as its recording tells it; None of what is no base."""
    facts = robot.base
    if facts is None:
        return None
    return WheelBase(
        facts.wheels, name=robot.model, radius=facts.radius, alpha=facts.alpha, mass=facts.mass, com=facts.com,
        com_height=facts.com_height,
    )  # fmt: skip


def outline_of(base: WheelBase, castors: Array | None = None, steering: Array | None = None) -> RobotOutline:
    """Return its outline; `castors` and `steering` (k,) are rad that its castors and steered wheels have turned."""
    none = np.zeros(len(base.wheels))
    angles = {
        "castor": iter(none if castors is None else castors),
        "steered": iter(none if steering is None else steering),
    }
    turned = [float(next(angles[wheel.kind])) if wheel.kind in angles else 0.0 for wheel in base.wheels]
    wheels = [
        WheelOutline(
            wheel.name, (float(place[0]), float(place[1])), wheel.heading + angle, wheel.radius, wheel.driven,
            wheel.kind in ("spherical", "ball"), (wheel.x, wheel.y) if wheel.kind == "castor" else None,
        )
        for wheel, place, angle in zip(base.wheels, contact_points(base, castors), turned, strict=True)
    ]  # fmt: skip
    com = (float(base.com[0]), float(base.com[1])) if base.mass is not None else None
    return RobotOutline(footprint(base, pad=PAD * base.radius), tuple(wheels), _support(base, castors), com)


def margin_of(base: WheelBase) -> float | None:
    """Distance (m) of the centre of mass from the support polygon's edge; None where that has no area."""
    try:
        return float(static_margin(base))
    except ModelError:
        return None


def stations(base: WheelBase, recording: Recording, time: Array, pose: Array, *, most: int = 6) -> list[MapRobot]:
    """The base at its start, its end and a few places between, as far apart along its path (N, 3) as it goes.

    `time` (N,) are the times of its poses; where its twist was recorded it has its centre of rotation.
    """
    some = np.unique(np.linspace(0, len(time) - 1, min(len(time), MOST)).astype(int))
    time, pose = time[some], pose[some]
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(pose[:, :2], axis=0).T))])
    count = min(most, 1 + int(way[-1] / (APART * base.radius)))
    far = count > 1
    at = np.searchsorted(way, np.linspace(0.0, way[-1], count)).clip(0, len(time) - 1) if far else [len(time) - 1]
    castors = castors_along(base, pose)
    twists = [_twist(recording, float(time[k])) for k in at]
    names = [f"{time[k]:.1f} s" for k in at]
    if far:
        names[0], names[-1] = "start", f"end, {time[-1]:.1f} s"
    return [
        MapRobot(outline_of(base, castors[k], _steering(base, twist)), pose[k], name, _centre(base, twist, pose[k]))
        for k, name, twist in zip(at, names, twists, strict=True)
    ]


def castors_along(base: WheelBase, pose: Array) -> Array:
    """Angles (N, castors), rad, to which castors trail along a path of poses (N, 3): each is drawn after its pivot."""
    trailing = [wheel for wheel in base.wheels if wheel.kind == "castor"]
    turned = np.zeros((len(pose), len(trailing)))
    for column, wheel in enumerate(trailing):
        c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
        pivot = pose[:, :2] + np.stack([c * wheel.x - s * wheel.y, s * wheel.x + c * wheel.y], axis=1)
        heading = wheel.heading + float(pose[0, 2])
        for k in range(len(pose)):
            if k:
                arm = abs(wheel.castor_offset) * np.array([np.cos(heading), np.sin(heading)])
                back = np.sign(wheel.castor_offset) * arm + pivot[k - 1] - pivot[k]
                heading = float(np.arctan2(*(np.sign(wheel.castor_offset) * back)[::-1]))
            turned[k, column] = heading - wheel.heading - pose[k, 2]
    return turned


def _twist(recording: Recording, time: float) -> Array | None:
    """Its twist (3,) at a time: the true one, else the one that it believed in; None where neither was recorded."""
    track = recording.true_base if len(recording.true_base.time) else recording.base
    if not len(track.time) or track.twist.shape[1:] != (3,):
        return None
    twist: Array = track.twist[min(int(np.searchsorted(track.time, time)), len(track.time) - 1)]
    return twist


def _steering(base: WheelBase, twist: Array | None) -> Array | None:
    """Angles (k,) of its steered wheels that put their axles through the centre of rotation; None: as at rest."""
    if twist is None or not base.steered or not np.any(np.abs(twist) > STILL):
        return None
    try:
        return base.steering(twist)
    except HolonomError:  # a twist that it cannot have
        return None


def _centre(base: WheelBase, twist: Array | None, pose: Array) -> tuple[float, float] | None:
    """Centre of rotation in the world; None where it is out of reach, at infinity, or no twist is known."""
    if twist is None or abs(twist[2]) < STILL:
        return None
    x, y = (float(v) for v in centre_of_twist(twist).point)
    if not np.hypot(x, y) <= REACH * base.radius:
        return None
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return float(pose[0] + c * x - s * y), float(pose[1] + s * x + c * y)


def _support(base: WheelBase, castors: Sequence[float] | Array | None) -> Array | None:
    try:
        return support_polygon(base, castors)
    except HolonomError:  # it has to balance
        return None

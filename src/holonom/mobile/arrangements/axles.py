"""Bases with axles: differential drives, tricycles, bicycles and cars; base_link at the middle of the fixed axle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import finite, vectors
from holonom.errors import InputError, ModelError, OutOfLimits
from holonom.mobile.arrangements.common import CORNERS, Body, body_of, corners
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.base.wheel_set import positive

__all__ = ["ackermann", "ackermann_steering", "bicycle", "differential", "dual_ackermann", "tricycle"]


def differential(
    track: float, wheel_radius: float | Sequence[float], *, castor: tuple[float, float] | None = None,
    castor_radius: float | None = None, castor_offset: float | None = None, **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Two driven wheels on one axle, "left" and "right", and a castor.

    Parameters
    ----------
    track : distance between the wheels' contact points.
    wheel_radius : of both, or (left, right) where they are not equal.
    castor : place (x, y) of the castor's pivot; None: a track behind the axle.
    castor_radius, castor_offset : None: a third of the wheels' mean radius, each.
    """
    positive("differential", "track", track)
    radii = np.atleast_1d(finite("wheel_radius", wheel_radius))
    if radii.shape not in ((1,), (2,)):
        raise ModelError(f"differential has {radii.size} wheel radii; state one, or (left, right)")
    radii = np.broadcast_to(radii, (2,))
    third = float(radii.mean()) / 3.0
    x, y = vectors("castor", castor, 2).tolist() if castor is not None else (-track, 0.0)
    wheels = [
        Wheel.at("fixed", 0.0, 0.5 * track, radius=float(radii[0]), driven=True, name="left"),
        Wheel.at("fixed", 0.0, -0.5 * track, radius=float(radii[1]), driven=True, name="right"),
        Wheel.at(
            "castor", x, y, math.pi, radius=third if castor_radius is None else castor_radius,
            castor_offset=third if castor_offset is None else castor_offset, name="castor",
        ),
    ]  # fmt: skip
    return body_of("differential", wheels, body)


def tricycle(
    wheelbase: float, track: float, wheel_radius: float, *, max_steering: float | None = math.pi / 2,
    **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """A front wheel that steers and drives ("front"), two free ones on the rear axle ("rear left", "rear right")."""
    positive("tricycle", "wheelbase", wheelbase)
    positive("tricycle", "track", track)
    wheels = [
        Wheel.at(
            "steered", wheelbase, 0.0, radius=wheel_radius, driven=True, max_steering=max_steering, name="front"
        ),
        Wheel.at("fixed", 0.0, 0.5 * track, radius=wheel_radius, name="rear left"),
        Wheel.at("fixed", 0.0, -0.5 * track, radius=wheel_radius, name="rear right"),
    ]  # fmt: skip
    return body_of("tricycle", wheels, body)


def ackermann(
    wheelbase: float, track: float, wheel_radius: float, *, rear_track: float | None = None,
    front_wheel_radius: float | None = None, max_steering: float | None = math.pi / 2, **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """A car: rear wheels driven, front wheels steered about one centre (their angles: `ackermann_steering`).

    Names "front left", "front right", "rear left", "rear right".

    Parameters
    ----------
    wheelbase : distance of the axles.
    track : of the front wheels, and of the rear ones unless those have their own.
    rear_track, front_wheel_radius : where rear and front wheels have their own.
    """
    positive("ackermann", "wheelbase", wheelbase)
    front = 0.5 * positive("ackermann", "track", track)
    rear = front if rear_track is None else 0.5 * positive("ackermann", "rear_track", rear_track)
    ahead = wheel_radius if front_wheel_radius is None else front_wheel_radius
    wheels = [
        *(
            Wheel.at("steered", wheelbase, y, radius=ahead, max_steering=max_steering, name=f"front {side}")
            for side, y in (("left", front), ("right", -front))
        ),
        *(
            Wheel.at("fixed", 0.0, y, radius=wheel_radius, driven=True, name=f"rear {side}")
            for side, y in (("left", rear), ("right", -rear))
        ),
    ]
    return body_of("ackermann", wheels, body)


def bicycle(
    wheelbase: float, wheel_radius: float, *, max_steering: float | None = math.pi / 2, **body: Unpack[Body]
) -> WheelBase:
    """A steered wheel "front" and a driven one "rear"; something holds it upright."""
    positive("bicycle", "wheelbase", wheelbase)
    wheels = [
        Wheel.at("steered", wheelbase, 0.0, radius=wheel_radius, max_steering=max_steering, name="front"),
        Wheel.at("fixed", 0.0, 0.0, radius=wheel_radius, driven=True, name="rear"),
    ]
    return body_of("bicycle", wheels, body)


def dual_ackermann(
    wheelbase: float, track: float, wheel_radius: float, *, max_steering: float | None = math.pi / 4,
    **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Four driven wheels, front and rear ones steered; base_link in the middle."""
    positive("dual_ackermann", "wheelbase", wheelbase)
    positive("dual_ackermann", "track", track)
    wheels = [
        Wheel.at("steered", x, y, radius=wheel_radius, driven=True, max_steering=max_steering, name=name)
        for (x, y), name in zip(corners(wheelbase, track), CORNERS, strict=True)
    ]
    return body_of("dual_ackermann", wheels, body)


def ackermann_steering(base: WheelBase, bicycle: ArrayLike) -> np.ndarray:
    """Steering (..., k) of a car from the angle of the wheel that a bicycle would have at the middle of its front axle.

    Parameters
    ----------
    base : one with fixed wheels on an axle through the origin of base_link, like `ackermann`.
    bicycle : (...) rad, between -pi/2 and pi/2 and neither of them; positive turns left. Where the centre comes to lie
        between the rear wheels, from atan(2 wheelbase / track) on, the inner front wheel takes its other half turn.

    Raises
    ------
    OutOfLimits
        An angle that no bicycle could roll at, or at which a wheel exceeds its `max_steering`.
    InputError
        A base that does not steer.
    """
    angle = finite("bicycle", bicycle)
    if np.abs(angle).max(initial=0.0) >= 0.5 * math.pi:
        worst = angle.flat[int(np.abs(angle).argmax())]
        raise OutOfLimits(f"bicycle is {worst:.6g} rad; an angle between -pi/2 and pi/2 (1.5708) is needed")
    if not base.steered:
        raise InputError(f"base {base.name!r} has no steered wheel; a bicycle's angle says nothing about it")
    wheelbase = float(np.mean([base.wheels[i].x for g in base.layout.groups for i in g]))
    turn = np.sin(angle) / wheelbase
    return base.steering(np.stack([np.cos(angle), np.zeros_like(angle), turn], axis=-1))

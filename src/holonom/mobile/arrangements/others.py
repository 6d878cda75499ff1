"""Bases whose wheels must slip, balance or climb: skid steer, the inverted pendulum, six wheels on rockers."""

from __future__ import annotations

import math
from typing import Unpack

from holonom.mobile.arrangements.common import CORNERS, Body, body_of, corners, count_of
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.base.wheel_set import positive

__all__ = ["rocker6", "segway", "skid_steer"]


def skid_steer(
    wheelbase: float, track: float, wheel_radius: float, *, axles: int = 2, effective_track: float | None = None,
    centre: float = 0.0, **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Fixed driven wheels on several axles, or tracks (many axles): it turns as they slip across.

    base_link lies in the middle. With two axles names "front left", "front right", "rear left", "rear right", with
    more "left 1", "right 1" from the front.

    Parameters
    ----------
    wheelbase : distance of the first axle from the last.
    track : distance of left and right wheels.
    axles : how many, from 2.
    effective_track : distance of the centres of rotation of the left and the right wheels, what odometry takes; None:
        half as much again as the track, a usual figure, until it is calibrated.
    centre : how far ahead of the middle those centres lie.

    Notes
    -----
    Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots (IROS 2007).
    """
    positive("skid_steer", "wheelbase", wheelbase)
    half = 0.5 * positive("skid_steer", "track", track)
    wide = 1.5 * track if effective_track is None else positive("skid_steer", "effective_track", effective_track)
    count = count_of("skid_steer", axles)
    names = CORNERS if count == 2 else [f"{side} {k + 1}" for k in range(count) for side in ("left", "right")]
    places = [(wheelbase * (0.5 - k / (count - 1)), sign) for k in range(count) for sign in (1.0, -1.0)]
    wheels = [
        Wheel.at(
            "skid", x, sign * half, radius=wheel_radius, driven=True, acts_at=(centre, 0.5 * sign * wide), name=name
        )
        for (x, sign), name in zip(places, names, strict=True)
    ]
    return body_of("skid_steer", wheels, body)


def segway(track: float, wheel_radius: float, **body: Unpack[Body]) -> WheelBase:
    """An inverted pendulum on two driven wheels, "left" and "right", whose body balances about their axle.

    Its centre of mass lies three wheel radii high unless `com_height` says otherwise.
    """
    half = 0.5 * positive("segway", "track", track)
    wheels = [
        Wheel.at("fixed", 0.0, y, radius=wheel_radius, driven=True, name=name)
        for name, y in (("left", half), ("right", -half))
    ]
    return body_of("segway", wheels, {"com_height": 3.0 * wheel_radius, **body}, balances=True)


def rocker6(
    wheelbase: float, track: float, wheel_radius: float, *, max_steering: float | None = math.pi / 3,
    **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Six driven wheels on rockers and bogies, the corners steered: a rover. base_link amid the middle wheels.

    On each side the front wheel and the bogie's pivot hang on a rocker, which turns about the body at the middle of the
    base; the bogie carries middle and rear wheel alike; a differential makes both rockers push equally.

    Parameters
    ----------
    wheelbase : distance of front and rear wheels; the middle ones stand halfway.
    track : distance of left and right wheels.
    """
    positive("rocker6", "wheelbase", wheelbase)
    positive("rocker6", "track", track)
    steered = {
        name: Wheel.at("steered", x, y, radius=wheel_radius, driven=True, max_steering=max_steering, name=name)
        for (x, y), name in zip(corners(wheelbase, track), CORNERS, strict=True)
    }
    middle = [
        Wheel.at("fixed", 0.0, 0.5 * sign * track, radius=wheel_radius, driven=True, name=f"middle {side}")
        for side, sign in (("left", 1.0), ("right", -1.0))
    ]
    front, rear = list(steered.values())[:2], list(steered.values())[2:]
    return body_of("rocker6", [*front, *middle, *rear], body, suspension="rocker_bogie")

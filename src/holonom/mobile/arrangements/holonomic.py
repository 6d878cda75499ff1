"""Bases that go any way at once: omni, mecanum, swerve, synchro, a ball; base_link in the middle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import finite, vectors
from holonom.errors import ModelError, ShapeError
from holonom.mobile.arrangements.common import CORNERS, Body, body_of, corners, count_of, evenly
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.base.wheel_set import positive

__all__ = ["mecanum", "omni", "sphere", "swerve", "synchro"]


def synchro(radius: float, wheel_radius: float, *, n: int = 3, **body: Unpack[Body]) -> WheelBase:
    """n wheels on a circle, steered together and driven: it goes anywhere and never turns. One angle, "steering"."""
    positive("synchro", "radius", radius)
    names = [f"wheel {k + 1}" for k in range(count_of("synchro", n))]
    wheels = [
        Wheel.at(
            "steered", radius * math.cos(phi), radius * math.sin(phi), radius=wheel_radius, driven=True, name=name
        )
        for name, phi in zip(names, evenly(n, 0.0), strict=True)
    ]  # fmt: skip
    return body_of("synchro", wheels, body, steering_groups={"steering": names})


def omni(
    angles: ArrayLike | None = None, *, radius: float, wheel_radius: float, n: int | None = None,
    roller_angle: float = 0.0, **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Omni wheels on a circle, each rolling counter-clockwise around it: rows (-sin phi_i, cos phi_i, 1) of D.

    Parameters
    ----------
    angles : phi_i of the motor axes, counter-clockwise from x.
    n : instead of angles: so many, evenly from 360/(2n) deg (so that x lies midway between two wheels).
    radius : R, distance of the wheels from the middle.
    """
    positive("omni", "radius", radius)
    if (angles is None) == (n is None):
        raise ModelError("omni takes either angles= (one per wheel, rad) or n= (so many, evenly); state one of them")
    given = evenly(count_of("omni", n), 0.5) if n is not None else angles
    assert given is not None
    phis = np.atleast_1d(finite("angles", given))
    if phis.ndim != 1:
        raise ShapeError(f"angles has shape {phis.shape}; (n,) is needed, one angle per wheel")
    wheels = [
        Wheel.at(
            "swedish", radius * math.cos(phi), radius * math.sin(phi), phi + math.pi / 2, radius=wheel_radius,
            roller_angle=roller_angle, driven=True,
        )
        for phi in phis.tolist()
    ]  # fmt: skip
    return body_of("omni", wheels, body, radius=radius)


def mecanum(wheelbase: float, track: float, wheel_radius: float, **body: Unpack[Body]) -> WheelBase:
    """Four wheels with rollers at 45 deg that form an X seen from above.

    Order "front left", "front right", "rear left", "rear right". With L half of wheelbase plus track the rims run at
    vx - vy - L w, vx + vy + L w, vx + vy - L w, vx - vy + L w, in m/s.

    Parameters
    ----------
    wheelbase, track : distances between the contact points, along x and along y (whole, not half).
    """
    positive("mecanum", "wheelbase", wheelbase)
    positive("mecanum", "track", track)
    places = [(*place, name) for place, name in zip(corners(wheelbase, track), CORNERS, strict=True)]
    wheels = [
        Wheel.at(
            "swedish", x, y, radius=wheel_radius, roller_angle=math.copysign(math.pi / 4, -x * y), driven=True,
            name=name,
        )
        for x, y, name in places
    ]  # fmt: skip
    return body_of("mecanum", wheels, body)


def swerve(
    positions: ArrayLike | None = None, *, wheelbase: float | None = None, track: float | None = None,
    wheel_radius: float, names: Sequence[str] | None = None, **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """Wheels that steer and drive one by one.

    Parameters
    ----------
    positions : (n, 2) of the wheels; or instead
    wheelbase, track : distances of four wheels along x and y, in the order "front left", "front right", "rear left",
        "rear right".
    """
    stated = [x is not None for x in (positions, wheelbase, track)]
    if stated not in ([True, False, False], [False, True, True]):
        raise ModelError("swerve takes either positions= (n, 2) or wheelbase= and track= (m); state one of them")
    if positions is None:
        assert wheelbase is not None
        assert track is not None
        positive("swerve", "wheelbase", wheelbase)
        positive("swerve", "track", track)
        places, called = np.array(corners(wheelbase, track)), list(names or CORNERS)
    else:
        places = vectors("positions", positions, 2).reshape(-1, 2)
        called = list(names or (f"module {k + 1}" for k in range(len(places))))
    if len(called) != len(places):
        raise ModelError(f"swerve has {len(places)} wheels and {len(called)} names; state one for each")
    wheels = [
        Wheel.at("steered", float(x), float(y), radius=wheel_radius, driven=True, name=name)
        for (x, y), name in zip(places, called, strict=True)
    ]
    return body_of("swerve", wheels, body)


def sphere(wheel_radius: float, **body: Unpack[Body]) -> WheelBase:
    """A body on a ball that is driven about two axes, "ball along" x and "ball across" (y); it is held upright.

    It goes any way and does not turn: the floor's friction holds the ball against spinning.
    """
    ball = Wheel.at("ball", 0.0, 0.0, radius=wheel_radius, driven=True, name="ball")
    return body_of("sphere", [ball], body)

"""Bases as they are built: presets, one function each; all lengths in m, angles in rad.

base_link lies where the arrangement is symmetric: at the middle of the driven axle of a differential drive, of the rear
axle of tricycle and car, at the middle of the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TypedDict, Unpack

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import finite, vectors
from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.base.wheel_set import positive

__all__ = [
    "Body", "ackermann", "ackermann_steering", "differential", "mecanum", "omni",
    "sphere", "swerve", "synchro", "tricycle",
]  # fmt: skip


class Body(TypedDict, total=False):
    """What a base is beside its wheels, handed on to `WheelBase`: every preset takes these by name."""

    name: str
    alpha: float
    mass: float | None
    com: Sequence[float]
    com_height: float


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
    return _base("differential", wheels, body)


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
    return _base("tricycle", wheels, body)


def ackermann(
    wheelbase: float, track: float, wheel_radius: float, *, max_steering: float | None = math.pi / 2,
    **body: Unpack[Body],
) -> WheelBase:  # fmt: skip
    """A car: rear wheels driven, front wheels steered about one centre (their angles: `ackermann_steering`).

    Names "front left", "front right", "rear left", "rear right".
    """
    positive("ackermann", "wheelbase", wheelbase)
    positive("ackermann", "track", track)
    half = 0.5 * track
    wheels = [
        *(
            Wheel.at("steered", wheelbase, y, radius=wheel_radius, max_steering=max_steering, name=f"front {side}")
            for side, y in (("left", half), ("right", -half))
        ),
        *(
            Wheel.at("fixed", 0.0, y, radius=wheel_radius, driven=True, name=f"rear {side}")
            for side, y in (("left", half), ("right", -half))
        ),
    ]
    return _base("ackermann", wheels, body)


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


def synchro(radius: float, wheel_radius: float, *, n: int = 3, **body: Unpack[Body]) -> WheelBase:
    """n wheels on a circle, steered together and driven: it goes anywhere and never turns. One angle, "steering"."""
    positive("synchro", "radius", radius)
    names = [f"wheel {k + 1}" for k in range(_count("synchro", n))]
    wheels = [
        Wheel.at(
            "steered", radius * math.cos(phi), radius * math.sin(phi), radius=wheel_radius, driven=True, name=name
        )
        for name, phi in zip(names, _even(n, 0.0), strict=True)
    ]  # fmt: skip
    return _base("synchro", wheels, body, steering_groups={"steering": names})


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
    given = _even(_count("omni", n), 0.5) if n is not None else angles
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
    return _base("omni", wheels, body, radius=radius)


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
    corners = [(*place, name) for place, name in zip(_corners(wheelbase, track), _CORNERS, strict=True)]
    wheels = [
        Wheel.at(
            "swedish", x, y, radius=wheel_radius, roller_angle=math.copysign(math.pi / 4, -x * y), driven=True,
            name=name,
        )
        for x, y, name in corners
    ]  # fmt: skip
    return _base("mecanum", wheels, body)


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
        places, called = np.array(_corners(wheelbase, track)), list(names or _CORNERS)
    else:
        places = vectors("positions", positions, 2).reshape(-1, 2)
        called = list(names or (f"module {k + 1}" for k in range(len(places))))
    if len(called) != len(places):
        raise ModelError(f"swerve has {len(places)} wheels and {len(called)} names; state one for each")
    wheels = [
        Wheel.at("steered", float(x), float(y), radius=wheel_radius, driven=True, name=name)
        for (x, y), name in zip(places, called, strict=True)
    ]
    return _base("swerve", wheels, body)


def sphere(wheel_radius: float, **body: Unpack[Body]) -> WheelBase:
    """A robot on a single ball that three drives turn: "ball along" x, "ball across" (y) and "ball spin"."""
    return _base("sphere", [Wheel.at("spherical", 0.0, 0.0, radius=wheel_radius, driven=True, name="ball")], body)


_CORNERS = ("front left", "front right", "rear left", "rear right")


def _base(
    kind: str, wheels: Sequence[Wheel], body: Body, *, radius: float | None = None,
    steering_groups: Mapping[str, Sequence[str]] | None = None,
) -> WheelBase:  # fmt: skip
    stated: Body = {"name": kind, **body}
    return WheelBase(wheels, radius=radius, steering_groups=steering_groups, **stated)


def _corners(wheelbase: float, track: float) -> list[tuple[float, float]]:
    return [(sx * wheelbase / 2, sy * track / 2) for sx in (1.0, -1.0) for sy in (1.0, -1.0)]


def _even(n: int, start: float) -> np.ndarray:
    return 2.0 * math.pi * (np.arange(n) + start) / n


def _count(kind: str, n: int) -> int:
    if not isinstance(n, (int, np.integer)) or n < 2:
        raise ModelError(f"{kind} has n = {n} wheels; a whole number from 2 is needed")
    return int(n)

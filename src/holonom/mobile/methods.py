"""Tables of mobile bases: arrangements of wheels, localisers, detectors of slip."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import partial
from typing import Any

from holonom.errors import ModelError
from holonom.mobile.arrangements import (
    ackermann,
    bicycle,
    differential,
    dual_ackermann,
    mecanum,
    omni,
    rocker6,
    segway,
    skid_steer,
    sphere,
    swerve,
    synchro,
    tricycle,
)
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.slip import SlipSettings
from holonom.mobile.odometry.integrate import RULES, integrate
from holonom.registry import OWN, Method, Table, parameter

__all__ = ["ARRANGEMENTS", "LOCALISERS", "SLIP_DETECTORS", "DeadReckoning", "Preset", "arrangement"]


def _length(meaning: str, example: float) -> Any:
    return parameter(meaning=meaning, unit="m", above=0.0, example=example)


def _wheel_radius() -> Any:
    return _length("of the driven wheels", 0.05)


@dataclass(frozen=True, slots=True)
class Differential:
    """Params of `differential`."""

    track: float = _length("distance between the wheels' contact points", 0.3)
    wheel_radius: float = _wheel_radius()
    castor: tuple[float, float] | None = parameter(None, meaning="its pivot; a track behind the axle", unit="m")
    castor_radius: float | None = parameter(None, meaning="a third of the wheels' unless given", unit="m", above=0.0)
    castor_offset: float | None = parameter(None, meaning="a third of the wheels' unless given", unit="m", above=0.0)


@dataclass(frozen=True, slots=True)
class Steered:
    """Params of `tricycle` and `ackermann`."""

    wheelbase: float = _length("distance of the axles", 1.0)
    track: float = _length("distance of left and right wheels", 0.6)
    wheel_radius: float = _wheel_radius()
    max_steering: float = parameter(math.pi / 2, meaning="largest angle of a steered wheel", unit="rad", above=0.0)


@dataclass(frozen=True, slots=True)
class Car(Steered):
    """Params of `ackermann`."""

    rear_track: float | None = parameter(
        None, meaning="of the rear wheels; the front ones' unless given", unit="m", above=0.0
    )
    front_wheel_radius: float | None = parameter(
        None, meaning="of the front wheels, where they have their own", unit="m", above=0.0
    )


@dataclass(frozen=True, slots=True)
class Bicycle:
    """Params of `bicycle`."""

    wheelbase: float = _length("distance of the axles", 1.0)
    wheel_radius: float = _wheel_radius()
    max_steering: float = parameter(math.pi / 2, meaning="largest angle of the front wheel", unit="rad", above=0.0)


@dataclass(frozen=True, slots=True)
class BothAxles:
    """Params of `dual_ackermann`."""

    wheelbase: float = _length("distance of the axles", 0.5)
    track: float = _length("distance of left and right wheels", 0.4)
    wheel_radius: float = _wheel_radius()
    max_steering: float = parameter(math.pi / 4, meaning="largest angle of a wheel", unit="rad", above=0.0)


@dataclass(frozen=True, slots=True)
class SkidSteer:
    """Params of `skid_steer`."""

    wheelbase: float = _length("distance of the first axle from the last", 0.3)
    track: float = _length("distance of left and right wheels", 0.3)
    wheel_radius: float = _wheel_radius()
    axles: int = parameter(2, meaning="how many axles; tracks have many", least=2, most=16)
    effective_track: float | None = parameter(
        None, meaning="distance of the centres about which left and right wheels turn; 1.5 tracks unless given",
        unit="m", above=0.0,
    )  # fmt: skip
    centre: float = parameter(0.0, meaning="how far ahead of the middle those centres lie", unit="m")


@dataclass(frozen=True, slots=True)
class Segway:
    """Params of `segway`."""

    track: float = _length("distance of the wheels", 0.4)
    wheel_radius: float = _length("of the wheels", 0.1)


@dataclass(frozen=True, slots=True)
class Rocker6:
    """Params of `rocker6`."""

    wheelbase: float = _length("distance of front and rear wheels", 0.8)
    track: float = _length("distance of left and right wheels", 0.6)
    wheel_radius: float = _wheel_radius()
    max_steering: float = parameter(math.pi / 3, meaning="largest angle of a corner wheel", unit="rad", above=0.0)


@dataclass(frozen=True, slots=True)
class Synchro:
    """Params of `synchro`."""

    radius: float = _length("distance of the wheels from the middle", 0.2)
    wheel_radius: float = _wheel_radius()
    n: int = parameter(3, meaning="number of wheels", least=2)


@dataclass(frozen=True, slots=True)
class Omni:
    """Params of `omni`: `angles` or `n`, one of the two."""

    radius: float = _length("distance of the wheels from the middle", 0.2)
    wheel_radius: float = _wheel_radius()
    angles: tuple[float, ...] | None = parameter(
        None, meaning="where each motor axis points, counter-clockwise from x", unit="rad"
    )
    n: int | None = parameter(None, meaning="so many wheels, evenly", least=2, example=3)
    roller_angle: float = parameter(0.0, meaning="between roller and wheel axle, less a quarter turn", unit="rad")


@dataclass(frozen=True, slots=True)
class Mecanum:
    """Params of `mecanum`."""

    wheelbase: float = _length("distance of front and rear axle", 0.4)
    track: float = _length("distance of left and right wheels", 0.3)
    wheel_radius: float = _wheel_radius()


@dataclass(frozen=True, slots=True)
class Swerve:
    """Params of `swerve`: `positions`, or `wheelbase` and `track`."""

    wheel_radius: float = _wheel_radius()
    positions: tuple[tuple[float, float], ...] | None = parameter(None, meaning="x and y of each wheel", unit="m")
    wheelbase: float | None = parameter(None, meaning="of four wheels, along x", unit="m", above=0.0, example=0.4)
    track: float | None = parameter(None, meaning="of four wheels, along y", unit="m", above=0.0, example=0.3)


@dataclass(frozen=True, slots=True)
class Sphere:
    """Params of `sphere`."""

    wheel_radius: float = _wheel_radius()


@dataclass(frozen=True, slots=True)
class Preset:
    """Makes a base by a function whose keywords are the fields of the params record."""

    function: Callable[..., WheelBase]

    def __call__(self, params: Any) -> WheelBase:
        """Return the base; what is None in the record is left to the function."""
        stated = {field.name: getattr(params, field.name) for field in fields(params)}
        return self.function(**{name: value for name, value in stated.items() if value is not None})


_SIEGWART = "Siegwart, Nourbakhsh, Introduction to Autonomous Mobile Robots"

ARRANGEMENTS = Table(
    "arrangements",
    "arrangement of wheels",
    "the `WheelBase`",
    {
        "differential": Method(
            "two driven wheels on one axle and a castor", Preset(differential), f"{_SIEGWART}, 3.2", Differential
        ),
        "tricycle": Method("a front wheel that steers and drives", Preset(tricycle), f"{_SIEGWART}, 3.3", Steered),
        "bicycle": Method(
            "a driven wheel and a steered one, held upright", Preset(bicycle), f"{_SIEGWART}, 3.2", Bicycle
        ),
        "ackermann": Method("a car: rear wheels driven, front ones steered", Preset(ackermann), _SIEGWART, Car),
        "dual_ackermann": Method(
            "front and rear wheels driven and steered", Preset(dual_ackermann), _SIEGWART, BothAxles
        ),
        "synchro": Method("wheels steered together: never turns", Preset(synchro), f"{_SIEGWART}, 3.3", Synchro),
        "omni": Method(
            "omni wheels on a circle",
            Preset(omni),
            "Rojas, Foerster, Holonomic Control of a robot with an omnidirectional drive",
            Omni,
        ),
        "mecanum": Method("four wheels with rollers at 45 deg", Preset(mecanum), "Ilon, US patent 3876255", Mecanum),
        "swerve": Method("wheels that steer and drive one by one", Preset(swerve), f"{_SIEGWART}, 3.3", Swerve),
        "skid_steer": Method(
            "fixed wheels on several axles, or tracks: they slip in turning",
            Preset(skid_steer),
            "Mandow et al., Experimental kinematics for wheeled skid-steer mobile robots (IROS 2007)",
            SkidSteer,
        ),
        "sphere": Method("a ball driven about two axes", Preset(sphere), f"{_SIEGWART}, 3.2", Sphere),
        "segway": Method(
            "two wheels that balance their body",
            Preset(segway),
            "Grasser et al., JOE: a mobile, inverted pendulum (IEEE Trans. Ind. Electron. 49, 2002)",
            Segway,
        ),
        "rocker6": Method("six wheels on rockers and bogies", Preset(rocker6), "Bickler, US patent 4840394", Rocker6),
    },
)


def arrangement(kind: str) -> Callable[..., WheelBase]:
    """Return the function of an arrangement, which takes the numbers of the body too.

    Raises
    ------
    UnknownName
    ModelError
        An arrangement of another package that has no such function.
    """
    make = ARRANGEMENTS[kind].make
    if not isinstance(make, Preset):
        raise ModelError(f"arrangement {kind!r} is made of its params only; use ARRANGEMENTS.make({kind!r}, params)")
    return make.function


@dataclass(frozen=True, slots=True)
class DeadReckoning:
    """Params of dead reckoning."""

    rule: str = parameter("midpoint", meaning="of integration", choices=RULES)


LOCALISERS = Table(
    "localisers",
    "localiser",
    "a function of increments (N, 3) and `start=` that gives poses (N, 3)",
    {
        "dead_reckoning": Method(
            "wheel increments added up", lambda p: partial(integrate, rule=p.rule), f"{_SIEGWART}, 5.2.4", DeadReckoning
        ),
    },
)

SLIP_DETECTORS = Table(
    "slip_detectors",
    "detector of slip",
    "its settings, of which `slip_params` makes those of the compiled step",
    {
        "residuals": Method(
            "rim speeds that no twist explains, against gyro and accelerations",
            lambda settings: settings,
            f"{OWN}; specification 06.2",
            SlipSettings,
        ),
    },
)

"""The table of planners: from a start and a goal to a sampled joint trajectory."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from math import inf
from typing import Any

from holonom.mechanics.motion.joint import plan_joint
from holonom.mechanics.motion.line import plan_line
from holonom.mechanics.motion.path import plan_path
from holonom.mechanics.motion.profile import PROFILES
from holonom.mechanics.motion.retime import retime
from holonom.mechanics.motion.trajectory import Trajectory
from holonom.mechanics.motion.transfer import plan_transfer
from holonom.registry import Method, Table, parameter

__all__ = ["PLANNERS", "JointPlan", "LinePlan", "PathPlan", "RetimePlan", "TransferPlan"]

_BOOK = "Biagiotti, Melchiorri, Trajectory Planning for Automatic Machines and Robots"


def _dt() -> Any:
    return parameter(1e-3, meaning="time between samples", unit="s", above=0.0)


def _profile() -> Any:
    return parameter("scurve", meaning="time law", choices=PROFILES)


@dataclass(frozen=True, slots=True)
class JointPlan:
    """Params of `plan_joint`."""

    speed: float = parameter(1.0, meaning="part of the joints' speeds", above=0.0, most=1.0)
    acceleration: float = parameter(1.0, meaning="part of the joints' accelerations", above=0.0, most=1.0)
    jerk: float = parameter(inf, meaning="of every joint", unit="rad/s3 or m/s3", above=0.0, most=inf)
    dt: float = _dt()
    profile: str = _profile()


@dataclass(frozen=True, slots=True)
class LinePlan:
    """Params of `plan_line`."""

    speed: float = parameter(meaning="of the tool point", unit="m/s", above=0.0, example=0.25)
    rotation_speed: float = parameter(meaning="of the tool", unit="rad/s", above=0.0, example=1.0)
    acceleration: float = parameter(meaning="of the tool point", unit="m/s2", above=0.0, example=1.0)
    rotation_acceleration: float = parameter(meaning="of the tool", unit="rad/s2", above=0.0, example=4.0)
    dt: float = _dt()
    profile: str = _profile()


@dataclass(frozen=True, slots=True)
class PathPlan:
    """Params of `plan_path`."""

    speed: float = parameter(meaning="of the tool point", unit="m/s", above=0.0, example=0.25)
    rotation_speed: float = parameter(meaning="of the tool", unit="rad/s", above=0.0, example=1.0)
    acceleration: float = parameter(meaning="of the tool point", unit="m/s2", above=0.0, example=1.0)
    rotation_acceleration: float = parameter(meaning="of the tool", unit="rad/s2", above=0.0, example=4.0)
    blend: bool = parameter(True, meaning="fly by between segments")
    dt: float = _dt()
    profile: str = _profile()


@dataclass(frozen=True, slots=True)
class RetimePlan:
    """Params of `retime`."""

    dt: float = _dt()
    grid: int = parameter(2000, meaning="points at which the path's speed is planned", least=10)


@dataclass(frozen=True, slots=True)
class TransferPlan:
    """Params of `plan_transfer`."""

    jerk: float = parameter(meaning="of every joint", unit="rad/s3 or m/s3", above=0.0, example=100.0)
    dt: float = _dt()


def _bound(planner: Callable[..., Trajectory]) -> Callable[[Any], Callable[..., Trajectory]]:
    """Return a `make` that binds a planner's keywords to a params record."""
    return lambda params: partial(planner, **asdict(params))


PLANNERS = Table(
    "planners",
    "planner",
    "the planner with its params bound, which takes what is left: arm, start, goal, limits",
    {
        "joint": Method("point to point, all joints arrive together", _bound(plan_joint), f"{_BOOK}, ch. 3", JointPlan),
        "line": Method(
            "straight line of the tool, orientation by slerp",
            _bound(plan_line),
            "Paul, Robot Manipulators, ch. 5; Shoemake, SIGGRAPH 1985",
            LinePlan,
        ),
        "path": Method(
            "lines, arcs and splines of the tool, fly-by between them", _bound(plan_path), f"{_BOOK}, ch. 8", PathPlan
        ),
        "retime": Method(
            "least time along a joint path under limits of speed, acceleration and torque",
            _bound(retime),
            "Pham, Pham, A New Approach to Time-Optimal Path Parameterization, T-RO 2018",
            RetimePlan,
        ),
        "transfer": Method(
            "least time between moving states, jerk limited",
            _bound(plan_transfer),
            "Berscheid, Kroeger, Jerk-limited Real-time Trajectory Generation with Arbitrary Target States, RSS 2021",
            TransferPlan,
        ),
    },
)

"""What moves the joints or wheels of a robot: `drives`, and what it may move at most: `limits`, `levels`."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, Strict

from holonom.app.fields.quantities import Fraction, OneOf, Quantity, Section, Text
from holonom.errors import CellError, InputError
from holonom.machine.levels import INTERPOLATIONS, Levels

__all__ = [
    "ArmLimits",
    "BaseLimits",
    "BaseParts",
    "JointDrive",
    "LevelsTable",
    "SteeringTable",
    "WheelDrive",
    "levels_of",
]


class WheelDrive(Section):
    """Motor, gear and encoder of each wheel, all alike."""

    resistance: Annotated[float, Quantity("resistance", "1mohm", "1000ohm")]
    """armature"""
    inductance: Annotated[float, Quantity("inductance", "0.1uH", "10H")]
    """armature"""
    torque_constant: Annotated[float, Quantity("torque constant", "0.01mNm/A", "100Nm/A")]
    """of the motor; its back-emf constant is the same in V s/rad"""
    rotor_inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "10kgm2")]
    """of the motor"""
    no_load_current: Annotated[float, Quantity("current", "0mA", "100A")] = 0.0
    """current of the free motor: its friction"""
    supply: Annotated[float, Quantity("voltage", "1V", "1000V")]
    """voltage of the battery"""
    max_current: Annotated[float, Quantity("current", "1mA", "10000A")]
    """limit of the power stage"""
    gear_ratio: Annotated[float, Quantity("number", 0.1, 1000.0)] = 1.0
    """motor turns per wheel turn"""
    gear_efficiency: Annotated[float, Quantity("number", 0.1, 1.0)] = 1.0
    """part of the motor's power that arrives at the wheel"""
    counts_per_turn: Annotated[int, Strict(), Field(ge=4, le=10_000_000)]
    """encoder counts per turn of the motor, after decoding"""
    wheel_inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "100kgm2")]
    """of a wheel about its axle"""


class SteeringTable(Section):
    """Motors that steer the wheels of a base, all alike."""

    max_rate: Annotated[float, Quantity("angular speed", "1deg/s", "36000deg/s")] = 6.0
    """greatest turning speed of a wheel about its vertical axis"""
    max_torque: Annotated[float, Quantity("torque", "1mNm", "100000Nm")] = 20.0
    """greatest torque on it"""
    lag: Annotated[float, Quantity("time", "1ms", "10s")] = 0.02
    """time constant with which it follows an angle"""
    backlash: Annotated[float, Quantity("angle", "0deg", "30deg")] = 0.0
    """play between motor and wheel"""
    inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "100kgm2")] = 2e-3
    """of wheel and motor about the vertical axis"""
    counts_per_turn: Annotated[int, Strict(), Field(ge=4, le=10_000_000)] = 8192
    """encoder counts per turn of the wheel"""


class JointDrive(Section):
    """Motor, gear and encoder of a joint, or of all of them."""

    joint: Text | None = None
    """the joint; all of the arm's unless given"""
    resistance: Annotated[float, Quantity("resistance", "1mohm", "1000ohm")]
    """armature"""
    inductance: Annotated[float, Quantity("inductance", "0.1uH", "10H")]
    """armature"""
    torque_constant: Annotated[float, Quantity("torque constant", "0.01mNm/A", "100Nm/A")]
    """of the motor; its back-emf constant is the same in V s/rad"""
    rotor_inertia: Annotated[float, Quantity("inertia", "0.001gcm2", "10kgm2")]
    """of the motor"""
    supply: Annotated[float, Quantity("voltage", "1V", "1000V")]
    """voltage that the power stage has"""
    max_current: Annotated[float, Quantity("current", "1mA", "10000A")]
    """limit of the power stage"""
    gear_ratio: Annotated[float, Quantity("number", -1e6, 1e6)]
    """motor turns (rad) per turn (rad) or travel (m) of the joint; negative where they turn against each other"""
    counts_per_turn: Annotated[int, Strict(), Field(ge=4, le=10_000_000)]
    """encoder counts per turn of the motor, after decoding"""


class ArmLimits(Section):
    """What the cell allows an arm."""

    joint_speed: Fraction = 1.0
    """fraction of the joints' greatest speeds that the program's 100 % means"""
    joint_acceleration: Fraction = 1.0
    """fraction of the joints' greatest accelerations"""
    line_speed: Annotated[float, Quantity("speed", "1mm/s", "10m/s")] = 0.5
    """tool speed on straight lines that the program's 100 % means"""
    line_acceleration: Annotated[float, Quantity("acceleration", "1mm/s2", "100m/s2")] = 2.0
    """tool acceleration on straight lines"""
    rotation_speed: Annotated[float, Quantity("angular speed", "0.1deg/s", "3600deg/s")] = 2.0
    """greatest turning speed of the tool on straight lines"""
    rotation_acceleration: Annotated[float, Quantity("angular acceleration", "0.1deg/s2", "100000deg/s2")] = 8.0
    """greatest angular acceleration of the tool on straight lines"""
    following_error: Annotated[float, Quantity("angle", "0.001deg", "90deg")] = 0.1
    """tracking error of a joint that turns at which the run stops"""
    slide_error: Annotated[float, Quantity("length", "0.01mm", "1m")] = 0.02
    """tracking error of a joint that slides at which the run stops"""
    contact_force: Annotated[float, Quantity("force", "1N", "100kN")] = 150.0
    """force of the tool on a surface above which the run stops"""
    settle_time: Annotated[float, Quantity("time", "100ms", "60min")] = 5.0
    """how long a program waits for the arm to come to rest after its motions before the run stops"""


class BaseLimits(Section):
    """What the cell allows a base. A path has to keep to speed, acceleration, turn_rate and turn_acceleration."""

    speed: Annotated[float, Quantity("speed", "1mm/s", "20m/s")] = 2.0
    """greatest speed along x and along y"""
    acceleration: Annotated[float, Quantity("acceleration", "1mm/s2", "100m/s2")] = 2.0
    """greatest acceleration along x and along y"""
    jerk: Annotated[float, Quantity("jerk", "1mm/s3", "1000000m/s3")] = 20.0
    """greatest jerk along x and along y"""
    turn_rate: Annotated[float, Quantity("angular speed", "0.1deg/s", "3600deg/s")] = 6.0
    """greatest turning speed"""
    turn_acceleration: Annotated[float, Quantity("angular acceleration", "0.1deg/s2", "100000deg/s2")] = 20.0
    """greatest angular acceleration"""
    turn_jerk: Annotated[float, Quantity("angular jerk", "0.1deg/s3", "1000000rad/s3")] = 200.0
    """greatest angular jerk"""
    side_speed: Annotated[float | None, Quantity("speed", "1mm/s", "20m/s")] = None
    """greatest speed along y, where it is another one"""
    side_acceleration: Annotated[float | None, Quantity("acceleration", "1mm/s2", "100m/s2")] = None
    """greatest acceleration along y, where it is another one"""
    side_jerk: Annotated[float | None, Quantity("jerk", "1mm/s3", "1000000m/s3")] = None
    """greatest jerk along y, where it is another one"""
    dead_band: Annotated[float, Quantity("speed", "0mm/s", "1m/s")] = 0.0
    """speed below which, and below `turn_dead_band`, velocities are rest"""
    turn_dead_band: Annotated[float, Quantity("angular speed", "0deg/s", "360deg/s")] = 0.0
    """turning speed below which, and below `dead_band`, velocities are rest"""
    timeout: Annotated[float, Quantity("time", "20ms", "1440min")] = 0.2
    """time after which velocities that are not asked for again are no longer followed"""


class BaseParts(Section):
    """What a base's controller does about slip and dead motors."""

    slip_detection: Annotated[bool, Strict()] = True
    """find the wheel that slips, and leave it out of the velocity estimate"""
    traction_control: Annotated[bool, Strict()] = True
    """cut the force of a wheel that slips"""
    dead_motor_compensation: Annotated[bool, Strict()] = True
    """find a dead motor, and drive with the others"""


class LevelsTable(Section):
    """Periods of the controller's levels."""

    supervisor: Annotated[float, Quantity("time", "0.5ms", "10s")] = 1e-3
    """between two points of a path"""
    model: Annotated[float, Quantity("time", "0.5ms", "1s")] = 1e-3
    """of the law that knows the dynamics"""
    servo: Annotated[float, Quantity("time", "0.5ms", "1s")] = 1e-3
    """of the position loops"""
    delay: Annotated[float, Quantity("time", "0ms", "1s")] = 0.0
    """that the law takes to compute"""
    interpolation: Annotated[str, OneOf(INTERPOLATIONS)] = "linear"
    """between the points of a path"""


def levels_of(table: LevelsTable | None, place: str) -> Levels:
    """Return the levels of a robot's controller: what its cell states at `place`, else what is usual.

    Raises
    ------
    CellError
        Periods that do not fit each other.
    """
    try:
        return Levels(**(table or LevelsTable.model_construct()).model_dump())
    except InputError as problem:
        raise CellError(f"{place}: {problem}") from None

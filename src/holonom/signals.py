"""Signals: the records that cross the borders between layers, and the one table of how each is said outside.

A record is plain data in SI units, without behaviour. `TOPICS` says of every field of a record on which topic it
goes, as which ROS type, and what it is: *measured* by a sensor, *commanded* by a controller, *estimated* from
measurements, or the *truth*, which only a simulation knows. Recorder, reader, documentation and bridges go by this
table; a signal more is a record and a row here.

Names of topics: where ROS convention itself fixes the kind, its name (`/joint_states`, `/odom`, `/imu`, `/tf`,
`/rosout`, and `/signals/<number>` of a program); everything else is `/<kind>/<name>`.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array

__all__ = [
    "TOPICS",
    "BaseCommand",
    "BaseState",
    "BaseTruth",
    "DriveState",
    "DriveTruth",
    "EncoderCounts",
    "Event",
    "FixedFrames",
    "FramePoses",
    "FrameTree",
    "Inertial",
    "JointCommand",
    "JointState",
    "JointTruth",
    "Kind",
    "Marker",
    "Markers",
    "Photograph",
    "Reading",
    "Record",
    "RobotDescription",
    "Signal",
    "Sink",
    "Steering",
    "Topic",
    "WheelContact",
    "WheelLoad",
]


@dataclass(frozen=True, slots=True)
class Record:
    """What every record has: its time, s."""

    time: float


@dataclass(frozen=True, slots=True)
class JointState(Record):
    """What the sensors of the joints say, each (n,).

    Position (rad or m) and velocity by the encoders; effort (N m or N): what the motors give at the measured currents,
    torque constant times gear ratio times current.
    """

    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class JointCommand(Record):
    """Reference of the joint servos: position, velocity, acceleration, each (n,)."""

    position: Array
    velocity: Array
    acceleration: Array


@dataclass(frozen=True, slots=True)
class JointTruth(Record):
    """True joint positions (rad or m), velocities and torques behind the gear (N m or N), each (n,)."""

    position: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, slots=True)
class EncoderCounts(Record):
    """Counts of the axes' encoders since the start, (n,) integers, turns counted on."""

    count: NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class DriveState(Record):
    """Motor side of the axes: measured armature current (A) and commanded voltage (V), each (n,)."""

    current: Array
    voltage: Array


@dataclass(frozen=True, slots=True)
class DriveTruth(Record):
    """True armature currents (A), (n,)."""

    current: Array


@dataclass(frozen=True, slots=True)
class BaseState(Record):
    """Where a mobile base believes to be.

    Pose (3,): x, y, theta of base_link in odom; its `covariance` (3, 3); twist (3,): vx, vy, w in base_link.
    """

    pose: Array
    twist: Array
    covariance: Array


@dataclass(frozen=True, slots=True)
class BaseCommand(Record):
    """Reference of a mobile base: pose (3,) in odom and twist (3,) in base_link."""

    pose: Array
    twist: Array


@dataclass(frozen=True, slots=True)
class BaseTruth(Record):
    """True pose (3,) of base_link in the world and twist (3,) in base_link."""

    pose: Array
    twist: Array


@dataclass(frozen=True, slots=True)
class Inertial(Record):
    """What a gyro and accelerometers on base_link measure: turning rate (rad/s) about z, acceleration (2,) m/s2."""

    rate: float
    acceleration: Array


@dataclass(frozen=True, slots=True)
class WheelContact(Record):
    """Wheels on the ground, each (n,).

    Driving force (N) and slip, the rim's speed over the ground (m/s), both true; the measured rim speed that no twist
    explains (m/s), an estimate.
    """

    force: Array
    slip: Array
    residual: Array


@dataclass(frozen=True, slots=True)
class WheelLoad(Record):
    """True loads of all wheels that stand on the ground, (n,) N: driven wheels, then the others."""

    load: Array


@dataclass(frozen=True, slots=True)
class Pitch(Record):
    """A body that balances, (1,) rad forwards each: how it leans, and how its controller believes it to."""

    angle: Array
    seen: Array


@dataclass(frozen=True, slots=True)
class Steering(Record):
    """Steered wheels, (k,) rad against their rest each: angles by their encoders, angles asked of their motors."""

    angle: Array
    asked: Array


@dataclass(frozen=True, slots=True)
class FramePoses(Record):
    """True world poses of named frames: `poses` (k, 4, 4), T_wx for x in `names`."""

    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, slots=True)
class FrameTree(Record):
    """Frames as the controller believes them, each in its parent: `poses` (k, 4, 4), T_px for each parent and name."""

    parents: tuple[str, ...]
    names: tuple[str, ...]
    poses: Array


@dataclass(frozen=True, slots=True)
class FixedFrames(FrameTree):
    """Frames that never move in their parents."""


@dataclass(frozen=True, slots=True)
class RobotDescription(Record):
    """A robot as URDF; its links are called as frames are, its joints as those of the joint states."""

    text: str


@dataclass(frozen=True, slots=True)
class Photograph(Record):
    """What a camera took: an image file, and its format ("png")."""

    data: bytes
    format: str


@dataclass(frozen=True, slots=True)
class Marker:
    """A thing to look at, that moves with a frame: a "cylinder" or "cube" of a size (m), its middle at T_fm (4, 4)."""

    frame: str
    shape: str
    pose: Array
    size: tuple[float, float, float]
    colour: tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class Markers(Record):
    """Things to look at, named by their frames."""

    markers: tuple[Marker, ...]


@dataclass(frozen=True, slots=True)
class Reading(Record):
    """What a sensor of a cell measures: its name, and numbers (k,) in its own units."""

    sensor: str
    values: Array


@dataclass(frozen=True, slots=True)
class Signal(Record):
    """A digital signal that changed."""

    number: int
    on: bool


@dataclass(frozen=True, slots=True)
class Event(Record):
    """A line in the log. `level`: "debug", "info", "warning" or "error"; `line` of the program in the file `file`."""

    level: str
    source: str
    text: str
    line: int = 0
    file: str = ""


class Kind(StrEnum):
    """Where a signal comes from; `STATED`: from the cell. Words of the log are none of these: `LOG`."""

    MEASURED = "measured"
    COMMANDED = "commanded"
    ESTIMATED = "estimated"
    TRUTH = "truth"
    STATED = "stated"
    LOG = "log"


@dataclass(frozen=True, slots=True)
class Topic:
    """One row of the table: a signal, and how it is said outside.

    Attributes
    ----------
    name
        Topic of a robot that is alone; fields of the record may stand in braces. Of several robots each has its own:
        `/<robot>/...`.
    record, fields
        The type of the record, and those of its fields that the message holds, in this order.
    type
        ROS 2 message type.
    kind, units, frame, meaning
        What it is: units of the fields in their order, joined by commas; frame that numbers are given in, or "".
    shared
        One topic for all robots; frames are then called `<robot>/<frame>`, and sources of events `<robot>.<source>`.
    kept
        Whether it is said once, for whoever listens later, too.
    """

    name: str
    record: type[Record]
    fields: tuple[str, ...]
    type: str
    kind: Kind
    units: str
    frame: str
    meaning: str
    shared: bool = False
    kept: bool = False


_STATE = ("position", "velocity", "effort")
_JOINTS, _NUMBERS, _COUNTS = "sensor_msgs/JointState", "std_msgs/Float64MultiArray", "std_msgs/Int64MultiArray"
_ODOMETRY, _FRAMES, _POSE = "nav_msgs/Odometry", "tf2_msgs/TFMessage", "geometry_msgs/PoseStamped"
_JOINT_UNITS, _BASE_UNITS = "rad, rad/s, N m", "m and rad, m/s and rad/s"
_MEASURED, _COMMANDED, _ESTIMATED, _TRUTH = Kind.MEASURED, Kind.COMMANDED, Kind.ESTIMATED, Kind.TRUTH

TOPICS: tuple[Topic, ...] = (
    Topic(
        "/joint_states", JointState, _STATE, _JOINTS, _MEASURED, _JOINT_UNITS, "",
        "joints by their encoders; torque of the motors at the measured currents",
    ),
    Topic(
        "/commanded/joint_states", JointCommand, ("position", "velocity"), _JOINTS, _COMMANDED, "rad, rad/s", "",
        "references of the joint servos",
    ),
    Topic(
        "/truth/joint_states", JointTruth, _STATE, _JOINTS, _TRUTH, _JOINT_UNITS, "",
        "joints as they are; torque behind the gear",
    ),
    Topic(
        "/measured/encoder_counts", EncoderCounts, ("count",), _COUNTS, _MEASURED, "counts", "",
        "encoder counts since the start, axis by axis",
    ),
    Topic(
        "/measured/motor_current", DriveState, ("current",), _NUMBERS, _MEASURED, "A", "",
        "armature currents by their shunts, axis by axis",
    ),
    Topic(
        "/commanded/motor_voltage", DriveState, ("voltage",), _NUMBERS, _COMMANDED, "V", "",
        "voltages asked of the power stages, axis by axis",
    ),
    Topic(
        "/truth/motor_current", DriveTruth, ("current",), _NUMBERS, _TRUTH, "A", "",
        "armature currents as they are, axis by axis",
    ),
    Topic(
        "/odom", BaseState, ("pose", "twist", "covariance"), _ODOMETRY, _ESTIMATED,
        f"{_BASE_UNITS}, their squares", "odom",
        "where a mobile base believes to be, how sure it is, and its twist",
    ),
    Topic(
        "/commanded/odom", BaseCommand, ("pose", "twist"), _ODOMETRY, _COMMANDED, _BASE_UNITS, "odom",
        "where a mobile base should be, and its twist",
    ),
    Topic(
        "/truth/odom", BaseTruth, ("pose", "twist"), _ODOMETRY, _TRUTH, _BASE_UNITS, "world",
        "where a mobile base is, and its twist",
    ),
    Topic(
        "/imu", Inertial, ("rate", "acceleration"), "sensor_msgs/Imu", _MEASURED, "rad/s, m/s^2", "base_link",
        "turning rate and acceleration",
    ),
    Topic(
        "/truth/wheel_force", WheelContact, ("force",), _NUMBERS, _TRUTH, "N", "",
        "driving force of each wheel on the base",
    ),
    Topic(
        "/truth/wheel_slip", WheelContact, ("slip",), _NUMBERS, _TRUTH, "m/s", "",
        "speed of each rim over the ground",
    ),
    Topic(
        "/truth/wheel_load", WheelLoad, ("load",), _NUMBERS, _TRUTH, "N", "",
        "what each wheel bears: the driven ones, then the others",
    ),
    Topic(
        "/truth/pitch", Pitch, ("angle",), _NUMBERS, _TRUTH, "rad", "",
        "how far a body that balances leans forwards",
    ),
    Topic(
        "/estimated/pitch", Pitch, ("seen",), _NUMBERS, _ESTIMATED, "rad", "",
        "how far its controller believes it to lean",
    ),
    Topic(
        "/measured/steering", Steering, ("angle",), _NUMBERS, _MEASURED, "rad", "",
        "angle of each steered wheel against its rest",
    ),
    Topic(
        "/commanded/steering", Steering, ("asked",), _NUMBERS, _COMMANDED, "rad", "",
        "angle asked of each steering motor",
    ),
    Topic(
        "/estimated/wheel_residual", WheelContact, ("residual",), _NUMBERS, _ESTIMATED, "m/s", "",
        "measured rim speed that no twist explains",
    ),
    Topic(
        "/tf", FrameTree, ("parents", "names", "poses"), _FRAMES, _ESTIMATED, "m", "each frame's parent",
        "frames as the controller believes them (REP 105)", shared=True,
    ),
    Topic(
        "/truth/tf", FramePoses, ("names", "poses"), _FRAMES, _TRUTH, "m", "world",
        "every frame as it is", shared=True,
    ),
    Topic(
        "/tf_static", FixedFrames, ("parents", "names", "poses"), _FRAMES, Kind.STATED, "m", "each frame's parent",
        "frames that do not move in their parents: where arms, surfaces and trays stand", shared=True, kept=True,
    ),
    Topic(
        "/robot_description", RobotDescription, ("text",), "std_msgs/String", Kind.STATED, "", "",
        "an arm as URDF; its links are the frames, its joints those of `/joint_states`", kept=True,
    ),
    Topic(
        "/measured/photograph", Photograph, ("data", "format"), "sensor_msgs/CompressedImage", _MEASURED, "", "world",
        "what the camera took", shared=True, kept=True,
    ),
    Topic(
        "/truth/parts", Markers, ("markers",), "visualization_msgs/MarkerArray", _TRUTH, "m", "each part's frame",
        "parts and obstacles as they are; they move with their frames", shared=True, kept=True,
    ),
    Topic(
        "/truth/tool_pose", FramePoses, ("poses",), _POSE, _TRUTH, "m", "world", "the tool's frame as it is",
    ),
    Topic(
        "/measured/sensors/{sensor}", Reading, ("values",), _NUMBERS, _MEASURED, "its own", "",
        "what a sensor of the cell measures",
    ),
    Topic(
        "/signals/{number}", Signal, ("on",), "std_msgs/Bool", _COMMANDED, "", "",
        "a digital signal: its state at the start, and each time it changes",
    ),
    Topic(
        "/rosout", Event, ("level", "source", "text", "line", "file"), "rcl_interfaces/Log", Kind.LOG, "", "",
        "events, with program file and line", shared=True,
    ),
)  # fmt: skip
"""Every signal there is."""


class Sink(Protocol):
    """Takes records as they come: the recorder, the studio, a test."""

    def put(self, record: Record) -> None:
        """Take one record; `record.time` never decreases within one kind."""

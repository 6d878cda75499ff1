"""Topics: how each record is said outside, and what its numbers are."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from holonom.signals.records import (
    BaseCommand,
    BaseState,
    BaseTruth,
    DriveState,
    DriveTruth,
    EncoderCounts,
    Event,
    FixedFrames,
    FramePoses,
    FrameTree,
    Inertial,
    JointCommand,
    JointState,
    JointTruth,
    Markers,
    Photograph,
    Pitch,
    Reading,
    Record,
    RobotDescription,
    Signal,
    Steering,
    WheelContact,
    WheelLoad,
)

__all__ = ["TOPICS", "Kind", "Topic"]


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

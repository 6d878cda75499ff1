"""Signals: the records that cross the borders between layers, and the one table of how each is said outside.

A record is plain data in SI units, without behaviour. `TOPICS` says of every field of a record on which topic it
goes, as which ROS type, and what it is: *measured* by a sensor, *commanded* by a controller, *estimated* from
measurements, or the *truth*, which only a simulation knows. Recorder, reader, documentation and bridges go by this
table; a signal more is a record and a row here.

Names of topics: where ROS convention itself fixes the kind, its name (`/joint_states`, `/odom`, `/imu`, `/tf`,
`/rosout`, and `/signals/<number>` of a program); everything else is `/<kind>/<name>`.
"""

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
    Marker,
    Markers,
    Photograph,
    Pitch,
    Reading,
    Record,
    RobotDescription,
    Signal,
    Sink,
    Steering,
    WheelContact,
    WheelLoad,
)
from holonom.signals.topics import TOPICS, Kind, Topic

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
    "Pitch",
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

"""Recordings: what a run says while it runs, as an MCAP file of ROS 2 messages.

Writing
    `Recorder`: a `signals.Sink`; a context manager that leaves a valid file on every way out, and one that can be read
    if there is no way out.
Reading
    `read_recording`: the file as arrays, a `Recording` of `JointTrack`, `DriveTrack`, `CountTrack`, `BaseTrack`,
    `ContactTrack`, `InertialTrack` and `FrameTrack`, or any topic of the table as a `Track`; `read_robots` gives that
    of each robot in the file.
Inside
    `cdr` (the byte layout of a message), `messages` (which message has which layout), `codecs` (which fields of a
    record go where in it), `schemas` (the texts of the message definitions), `scope` (names of several robots),
    `growing` (the file in writing), `pieces` and `decoded` (the file in reading).

Topics are those of `signals.TOPICS`, all stamped with simulated time, each there from its first message on;
`topics_table` lists them.
"""

from holonom.app.recording.format.missing import Missing
from holonom.app.recording.listing import topics_table
from holonom.app.recording.reader import read_recording, read_robots
from holonom.app.recording.recorder import EPOCH, Recorder
from holonom.app.recording.recording import COMPLETE, CUT_OFF, Recording
from holonom.app.recording.tracks import (
    BaseTrack,
    ContactTrack,
    CountTrack,
    DriveTrack,
    FrameTrack,
    InertialTrack,
    JointTrack,
    Track,
)

__all__ = [
    "COMPLETE",
    "CUT_OFF",
    "EPOCH",
    "BaseTrack",
    "ContactTrack",
    "CountTrack",
    "DriveTrack",
    "FrameTrack",
    "InertialTrack",
    "JointTrack",
    "Missing",
    "Recorder",
    "Recording",
    "Track",
    "read_recording",
    "read_robots",
    "topics_table",
]

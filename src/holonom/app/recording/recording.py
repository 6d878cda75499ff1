"""A recording as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording.format.missing import Missing
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
from holonom.signals import Event, Signal

__all__ = ["COMPLETE", "CUT_OFF", "Recording"]

COMPLETE, CUT_OFF = "complete", "cut off"
"""How a file ends: as it was closed, or in the middle, as a killed run leaves it."""


@dataclass(frozen=True, slots=True)
class Recording:
    """All that a run recorded of one robot; tracks have their own times, and are empty (N = 0) where nothing came.

    Attributes
    ----------
    tracks
        Every topic by its name in `signals.TOPICS`, without the robot's. The properties are the usual ones, named.
    frames
        True frames in the world by name, those of this robot without its name.
    tree
        Frames as the controller believed them, in their parents, by (parent, name).
    signals, events
        In order of time.
    joint_names
        Without the robot's.
    robot, robots
        Which one this is of; all that are in the file, "" for one that is alone.
    attachments, metadata
        Files and words that came with it, by name.
    ended
        `COMPLETE` or `CUT_OFF`.
    missing
        Stretches that could not be read, in the order of the file.
    """

    tracks: Mapping[str, Track] = field(default_factory=dict)
    frames: Mapping[str, FrameTrack] = field(default_factory=dict)
    tree: Mapping[tuple[str, str], FrameTrack] = field(default_factory=dict)
    signals: tuple[Signal, ...] = ()
    events: tuple[Event, ...] = ()
    joint_names: tuple[str, ...] = ()
    robot: str = ""
    robots: tuple[str, ...] = ()
    attachments: Mapping[str, bytes] = field(default_factory=dict)
    metadata: Mapping[str, Mapping[str, str]] = field(default_factory=dict)
    ended: str = COMPLETE
    missing: tuple[Missing, ...] = ()

    @property
    def joints(self) -> JointTrack:
        """What the sensors of the joints said."""
        return self._joints("/joint_states")

    @property
    def true_joints(self) -> JointTrack:
        """Joints as they were."""
        return self._joints("/truth/joint_states")

    @property
    def reference(self) -> JointTrack:
        """References of the joints, without efforts."""
        return self._joints("/commanded/joint_states")

    @property
    def counts(self) -> CountTrack:
        """Encoder counts."""
        time, count = self._together((0,), count="/measured/encoder_counts")
        return CountTrack(time, count.astype(np.int64))

    @property
    def drives(self) -> DriveTrack:
        """Motors: measured currents, true ones where none were measured, and voltages."""
        measured = "/measured/motor_current"
        current = measured if measured in self.tracks else "/truth/motor_current"
        return DriveTrack(*self._together((0,), current=current, voltage="/commanded/motor_voltage"))

    @property
    def base(self) -> BaseTrack:
        """Where a base believed to be."""
        return self._base("/odom")

    @property
    def base_reference(self) -> BaseTrack:
        """Where a base should have been."""
        return self._base("/commanded/odom")

    @property
    def true_base(self) -> BaseTrack:
        """Where a base was."""
        return self._base("/truth/odom")

    @property
    def contacts(self) -> ContactTrack:
        """Wheels on the ground."""
        topics = {"force": "/truth/wheel_force", "slip": "/truth/wheel_slip", "residual": "/estimated/wheel_residual"}
        return ContactTrack(*self._together((0,), **topics))

    @property
    def inertial(self) -> InertialTrack:
        """Gyro and accelerometers."""
        time, rate = self._together((), rate="/imu")
        return InertialTrack(time, rate, self._together((2,), acceleration="/imu")[1])

    @property
    def tool(self) -> FrameTrack:
        """The tool's true frame."""
        time, poses = self._together((7,), poses="/truth/tool_pose")
        return FrameTrack(time, poses[:, :3], poses[:, 3:])

    def end(self) -> float:
        """Time of the last record, s; 0 for an empty recording."""
        last = [float(track.time[-1]) for track in self.tracks.values() if len(track.time)]
        last += [signal.time for signal in self.signals[-1:]]
        last += [event.time for event in self.events[-1:]]
        return max(last, default=0.0)

    def _together(self, shape: tuple[int, ...], **topics: str) -> tuple[NDArray[Any], ...]:
        """Times and one field of each topic, as far as all were recorded; rows of a shape where nothing was."""
        found = [self.tracks[topic] for topic in topics.values() if topic in self.tracks]
        if len(found) < len(topics):
            return np.empty(0), *(np.empty((0, *shape)) for _ in topics)
        count = min(len(track.time) for track in found)
        fields = (track.fields[name][:count] for name, track in zip(topics, found, strict=True))
        return found[0].time[:count], *fields

    def _joints(self, topic: str) -> JointTrack:
        track = self.tracks.get(topic)
        if track is None:
            empty = np.empty((0, 0))
            return JointTrack(np.empty(0), empty, empty, empty)
        none = np.empty((len(track.time), 0))
        return JointTrack(track.time, *(track.fields.get(name, none) for name in ("position", "velocity", "effort")))

    def _base(self, topic: str) -> BaseTrack:
        track = self.tracks.get(topic)
        if track is None:
            return BaseTrack(np.empty(0), np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3, 3)))
        none = np.zeros((len(track.time), 3, 3))
        return BaseTrack(track.time, track.fields["pose"], track.fields["twist"], track.fields.get("covariance", none))

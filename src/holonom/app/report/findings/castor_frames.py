"""Frames of castors, which nobody measures: each trails behind its pivot wherever its base went."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from holonom.app.recording import FrameTrack
from holonom.app.report.findings.base_outline import base_of, castors_along
from holonom.app.report.findings.facts import RobotFacts
from holonom.arrays import Array

__all__ = ["castor_frames"]

MOST = 20_000
"""Poses of a castor; one of a long run has fewer per second than its base."""


def castor_frames(frames: Mapping[str, FrameTrack], robots: Sequence[RobotFacts]) -> dict[str, FrameTrack]:
    """Frames "castor_1" and so on of the free castors of every base, by their full names, as a scene has them.

    The origin is the pivot on the floor, x the way from there to where the castor touches it, or rolls.
    """
    found: dict[str, FrameTrack] = {}
    for robot in robots:
        prefix = f"{robot.name}/" if robot.name else ""
        track, base = frames.get(f"{prefix}base_link"), base_of(robot)
        if track is None or base is None or not len(track.time):
            continue
        castors = [wheel for wheel in base.wheels if wheel.kind == "castor"]
        some = np.unique(np.linspace(0, len(track.time) - 1, min(len(track.time), MOST)).astype(int))
        pose = _planar(track)[some]
        turned = castors_along(base, pose)
        for number, k in enumerate((k for k, wheel in enumerate(castors) if not wheel.driven), 1):
            wheel = castors[k]
            c, s = np.cos(pose[:, 2]), np.sin(pose[:, 2])
            place = pose[:, :2] + np.stack([c * wheel.x - s * wheel.y, s * wheel.x + c * wheel.y], axis=1)
            half = 0.5 * (pose[:, 2] + wheel.heading + turned[:, k])
            flat = np.zeros(len(some))
            found[f"{prefix}castor_{number}"] = FrameTrack(
                track.time[some],
                np.column_stack([place, flat]),
                np.stack([flat, flat, np.sin(half), np.cos(half)], axis=1),
            )
    return found


def _planar(track: FrameTrack) -> Array:
    """Poses (N, 3) x, y, theta of a frame that stays level."""
    turned = 2.0 * np.arctan2(track.quaternion[:, 2], track.quaternion[:, 3])
    return np.column_stack([track.position[:, :2], turned])

"""True poses in the plane from the messages in which they come: odometry, poses, transforms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from holonom.app.recording.format.cdr import CdrReader
from holonom.arrays import Array
from holonom.errors import LogError

__all__ = ["TRUTHS", "Stamped", "poses_of"]

BODIES = ("base_link", "base_footprint", "base")
"""Frames of a base, of which the first that a file has is taken."""


class Stamped(NamedTuple):
    """A pose (x, y, theta) of a frame in its parent at a time, s; both frames "" where a message does not name them."""

    time: float
    parent: str
    frame: str
    pose: tuple[float, float, float]


def poses_of(kind: str, messages: Sequence[bytes], frame: str | None, place: str) -> tuple[Array, Array]:
    """Times (N,), s, in order, and poses (N, 3) of a base.

    Parameters
    ----------
    kind, messages
        One of `TRUTHS`, and the messages.
    frame
        Of transforms, which; the base's own name or the only one unless given.
    place
        Of the file, for messages.

    Raises
    ------
    LogError
        Transforms of several frames, none of them named; a frame that is none of them.
    """
    found = [pose for data in messages for pose in TRUTHS[kind](CdrReader(data))]
    if kind in (TF, TRANSFORM):
        chosen = _chosen(list(dict.fromkeys(pose.frame for pose in found)), frame, place)
        found = [pose for pose in found if pose.frame == chosen]
        parents = list(dict.fromkeys(pose.parent for pose in found))
        if len(parents) > 1:
            raise LogError(f"{place}: {chosen} is given in {', '.join(parents)}; record one of them")
    rows = np.array([[pose.time, *pose.pose] for pose in sorted(found, key=lambda pose: pose.time)])
    rows = rows[np.concatenate([np.diff(rows[:, 0]) > 0.0, [True]])] if len(rows) else rows.reshape(0, 4)
    return rows[:, 0], rows[:, 1:]


def _chosen(frames: Sequence[str], frame: str | None, place: str) -> str:
    wanted = [frame] if frame is not None else [*BODIES, *(frames if len(frames) == 1 else ())]
    for name in wanted:
        if name in frames:
            return str(name)
    asked = f"no transform of frame {frame!r}" if frame is not None else "transforms of several frames"
    raise LogError(f"{place}: {asked}; there is {', '.join(frames) or 'none'}: name one as frame in [mcap]")


def _plane(reader: CdrReader) -> tuple[float, float, float]:
    """Place and quaternion, seven doubles, in the plane."""
    px, py, _, x, y, z, w = reader.doubles(7)
    return float(px), float(py), float(np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def _pose(reader: CdrReader) -> list[Stamped]:
    time, parent = reader.stamp() / 1e9, reader.text()
    return [Stamped(time, parent, "", _plane(reader))]


def _named(reader: CdrReader) -> list[Stamped]:
    time, parent, frame = reader.stamp() / 1e9, reader.text(), reader.text()
    return [Stamped(time, parent, frame, _plane(reader))]


def _several(reader: CdrReader) -> list[Stamped]:
    return [pose for _ in range(reader.uint32()) for pose in _named(reader)]


TF, TRANSFORM = "tf2_msgs/TFMessage", "geometry_msgs/TransformStamped"
TRUTHS: Mapping[str, Callable[[CdrReader], list[Stamped]]] = {
    "nav_msgs/Odometry": _named,
    "geometry_msgs/PoseStamped": _pose,
    "geometry_msgs/PoseWithCovarianceStamped": _pose,
    TRANSFORM: _named,
    TF: _several,
}
"""Types of messages that tell a pose, the first of which that a file has is taken."""

"""How the fields of a record become a message of each ROS type, and messages arrays again."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from holonom.app.recording.format.cdr import ENCAPSULATION, CdrReader, CdrWriter, Layout
from holonom.app.recording.format.messages import (
    BASE,
    WORLD,
    JointMessage,
    array_layout,
    array_size,
    image_message,
    inertial_layout,
    inertial_plane,
    inertial_values,
    joint_layout,
    joint_message,
    log_message,
    marker_message,
    odometry_frames,
    odometry_layout,
    odometry_plane,
    odometry_values,
    pose_layout,
    pose_rows,
    stamped_frame,
    transform_frames,
    transform_layout,
)
from holonom.app.recording.format.topic_messages import Messages
from holonom.app.recording.scope import Scope
from holonom.app.recording.tracks import Track
from holonom.arrays import Array
from holonom.signals import Pitch, Reading, Steering, Topic, WheelLoad

__all__ = ["CODECS", "Codec", "Encode", "groups_of", "transform_groups"]

OWN_LENGTH = (Pitch, Reading, Steering, WheelLoad)
"""Records of as many numbers as they have, not one for each joint."""
Encode = Callable[[int, Any], bytes | None]
"""Time (ns) and record to a message; None where the record says nothing of it."""


class Group(NamedTuple):
    """Messages of one layout: what fixes it, their times (N,) in s and their open doubles (N, k)."""

    kind: Any
    time: Array
    values: Array


class Codec(NamedTuple):
    """Of one ROS type: `encoder(topic, scope)` makes the function that packs; `decode` gives the arrays."""

    encoder: Callable[[Topic, Scope], Encode]
    decode: Callable[[Topic, Messages], Track]


def groups_of(given: Messages, kind_of: Callable[[bytes], Any], layout_of: Callable[[Any], Layout]) -> list[Group]:
    """Messages of a topic, sorted by layout; within one layout in the order of the file."""
    times, sizes = given.seconds(), given.lengths()
    groups = []
    for size in dict.fromkeys(sizes.tolist()):
        at = np.flatnonzero(sizes == size)
        rows = given.rows(at, size)[:, len(ENCAPSULATION) :]
        while len(at):
            kind = kind_of(given.message(int(at[0])))
            layout = layout_of(kind)
            same = layout.matches(rows)
            if not same[0]:
                raise ValueError("its bytes are others than its counts say")
            groups.append(Group(kind, times[at[same]], layout.unpack(rows[same])))
            at, rows = at[~same], rows[~same]
    return groups


def transform_groups(given: Messages) -> list[Group]:
    """Groups of tf2_msgs/TFMessage; what fixes one is its (parent, child)s."""
    return groups_of(given, transform_frames, transform_layout)


def _joints(topic: Topic, scope: Scope) -> Encode:
    names, fields = tuple(map(scope.dotted, scope.joints)), topic.fields
    layout = joint_layout(JointMessage(names, len(fields)))
    return lambda now, record: layout.pack(
        now, np.concatenate([getattr(record, field) for field in fields], dtype=np.float64)
    )


def _joint_track(topic: Topic, given: Messages) -> Track:
    kind, time, values = groups_of(given, joint_message, joint_layout)[0]
    ends = np.cumsum((0, *kind.filled()))
    parts = {field: values[:, ends[i] : ends[i + 1]] for i, field in enumerate(("position", "velocity", "effort"))}
    return Track(time, {field: parts[field] for field in topic.fields if parts[field].shape[1]}, kind.names)


def _axes(topic: Topic, scope: Scope) -> Encode:
    (field,) = topic.fields
    if topic.record in OWN_LENGTH:
        layouts = lru_cache(array_layout)
        return lambda now, record: layouts(len(getattr(record, field))).pack(
            now, np.asarray(getattr(record, field), dtype=np.float64)
        )
    layout = array_layout(len(scope.joints))
    return lambda now, record: layout.pack(now, np.asarray(getattr(record, field), dtype=np.float64))


def _counts(topic: Topic, scope: Scope) -> Encode:
    layout, (field,) = array_layout(len(scope.joints)), topic.fields
    return lambda now, record: layout.pack(now, np.asarray(getattr(record, field), dtype=np.int64))


def _axes_track(topic: Topic, given: Messages) -> Track:
    group = groups_of(given, array_size, array_layout)[0]
    return Track(group.time, {topic.fields[0]: group.values})


def _count_track(topic: Topic, given: Messages) -> Track:
    track = _axes_track(topic, given)
    return replace(track, fields={topic.fields[0]: track.fields[topic.fields[0]].view(np.int64)})


def _number(topic: Topic, scope: Scope) -> Encode:
    layout, (field,) = CdrWriter().doubles(1).layout(), topic.fields
    return lambda now, record: layout.pack(now, np.array(float(getattr(record, field))))


def _number_track(topic: Topic, given: Messages) -> Track:
    group = groups_of(given, lambda message: None, lambda kind: CdrWriter().doubles(1).layout())[0]
    return Track(group.time, {topic.fields[0]: group.values[:, 0]})


def _odometry(topic: Topic, scope: Scope) -> Encode:
    layout = odometry_layout((scope.frame(topic.frame), scope.frame(BASE)))
    unknown = np.zeros((3, 3))
    return lambda now, record: layout.pack(
        now, odometry_values(record.pose, record.twist, getattr(record, "covariance", unknown))
    )


def _odometry_track(topic: Topic, given: Messages) -> Track:
    group = groups_of(given, odometry_frames, odometry_layout)[0]
    fields = dict(zip(("pose", "twist", "covariance"), odometry_plane(group.values), strict=True))
    return Track(group.time, {field: fields[field] for field in topic.fields})


def _inertial(topic: Topic, scope: Scope) -> Encode:
    layout = inertial_layout(scope.frame(BASE))
    return lambda now, record: layout.pack(now, inertial_values(record.rate, record.acceleration))


def _inertial_track(topic: Topic, given: Messages) -> Track:
    group = groups_of(given, stamped_frame, inertial_layout)[0]
    return Track(group.time, dict(zip(topic.fields, inertial_plane(group.values), strict=True)))


def _transforms(topic: Topic, scope: Scope) -> Encode:
    layout_of = lru_cache(maxsize=64)(_transform_layout)

    def encode(now: int, record: Any) -> bytes:
        layout = layout_of(scope, getattr(record, "parents", ()), record.names)
        return layout.pack(now, pose_rows(record.poses))

    return encode


def _transform_layout(scope: Scope, parents: Sequence[str], names: Sequence[str]) -> Layout:
    parents = parents or (WORLD,) * len(names)
    return transform_layout([(scope.frame(a), scope.frame(b)) for a, b in zip(parents, names, strict=True)])


def _transform_track(topic: Topic, given: Messages) -> Track:
    return Track(np.unique(np.concatenate([group.time for group in transform_groups(given)])), {})


def _pose(topic: Topic, scope: Scope) -> Encode:
    layout = pose_layout()

    def encode(now: int, record: Any) -> bytes | None:
        if scope.tool not in record.names:
            return None
        k = record.names.index(scope.tool)
        return layout.pack(now, pose_rows(record.poses[k : k + 1]))

    return encode


def _pose_track(topic: Topic, given: Messages) -> Track:
    group = groups_of(given, stamped_frame, pose_layout)[0]
    return Track(group.time, {topic.fields[0]: group.values})


def _flag(topic: Topic, scope: Scope) -> Encode:
    (field,) = topic.fields
    return lambda now, record: CdrWriter().byte(getattr(record, field)).message()


def _flag_track(topic: Topic, given: Messages) -> Track:
    on = np.array([message[len(ENCAPSULATION)] != 0 for message in given])
    return Track(given.seconds(), {topic.fields[0]: on})


def _string(topic: Topic, scope: Scope) -> Encode:
    (field,) = topic.fields
    return lambda now, record: CdrWriter().text(getattr(record, field)).message()


def _string_track(topic: Topic, given: Messages) -> Track:
    texts = [CdrReader(message).text() for message in given]
    return Track(given.seconds(), {topic.fields[0]: np.array(texts, dtype=object)})


def _image(topic: Topic, scope: Scope) -> Encode:
    return lambda now, record: image_message(now, topic.frame, record)


def _markers(topic: Topic, scope: Scope) -> Encode:
    return lambda now, record: marker_message(now, record.markers)


def _log(topic: Topic, scope: Scope) -> Encode:
    return lambda now, event: log_message(now, replace(event, source=scope.dotted(event.source)))


def _times(topic: Topic, given: Messages) -> Track:
    """When they came; what is in them is read elsewhere, or not at all."""
    return Track(given.seconds(), {})


CODECS: Mapping[str, Codec] = {
    "geometry_msgs/PoseStamped": Codec(_pose, _pose_track),
    "nav_msgs/Odometry": Codec(_odometry, _odometry_track),
    "rcl_interfaces/Log": Codec(_log, _times),
    "sensor_msgs/CompressedImage": Codec(_image, _times),
    "sensor_msgs/Imu": Codec(_inertial, _inertial_track),
    "sensor_msgs/JointState": Codec(_joints, _joint_track),
    "std_msgs/Bool": Codec(_flag, _flag_track),
    "std_msgs/Float64": Codec(_number, _number_track),
    "std_msgs/Float64MultiArray": Codec(_axes, _axes_track),
    "std_msgs/Int64MultiArray": Codec(_counts, _count_track),
    "std_msgs/String": Codec(_string, _string_track),
    "tf2_msgs/TFMessage": Codec(_transforms, _transform_track),
    "visualization_msgs/MarkerArray": Codec(_markers, _times),
}
"""What a topic's type is written and read by."""

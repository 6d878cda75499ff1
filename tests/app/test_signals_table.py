"""The one table of signals: what it says is what is recorded; a signal more is one row; several robots in a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from holonom import signals
from holonom.app.recording import Recorder, read_recording, topics_table
from holonom.app.recording.format.messages import (
    JointMessage,
    array_layout,
    joint_layout,
    odometry_layout,
    odometry_values,
    pose_layout,
    pose_rows,
    transform_layout,
)
from holonom.errors import OutOfLimits, UnknownName
from holonom.signals import (
    TOPICS,
    BaseState,
    BaseTruth,
    EncoderCounts,
    Event,
    FramePoses,
    FrameTree,
    JointState,
    Kind,
    Record,
    Signal,
    Topic,
)

PAGE = Path(__file__).resolve().parents[2] / "docs" / "signals.md"
CONVENTIONAL = {"/joint_states": "measured", "/imu": "measured", "/odom": "estimated", "/tf": "estimated"}
CONVENTIONAL |= {"/tf_static": "stated", "/robot_description": "stated"}
HUGE = 2**53 + 1  # no double holds it


def decoded(path: Path) -> dict[str, list]:
    out: dict[str, list] = {}
    with path.open("rb") as stream:
        for _, channel, _, message in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            out.setdefault(channel.topic, []).append(message)
    return out


def channels(path: Path) -> dict:
    with path.open("rb") as stream:
        return {channel.topic: channel for channel in make_reader(stream).get_summary().channels.values()}


def test_a_name_says_the_kind() -> None:
    for topic in TOPICS:
        first = topic.name.split("/")[1]
        if topic.name in CONVENTIONAL:
            assert topic.kind == CONVENTIONAL[topic.name]
        elif first not in ("rosout", "signals"):
            assert first == topic.kind, topic.name
    assert len({topic.name for topic in TOPICS}) == len(TOPICS)


def test_every_record_has_a_row_and_every_row_its_fields() -> None:
    records = {kind for kind in vars(signals).values() if isinstance(kind, type) and issubclass(kind, Record)}
    assert {topic.record for topic in TOPICS} == records - {Record}
    for topic in TOPICS:
        assert set(topic.fields) <= set(topic.record.__dataclass_fields__), topic.name


def test_the_page_is_the_table() -> None:
    assert topics_table() in PAGE.read_text("utf-8")


@dataclass(frozen=True, slots=True)
class Battery(Record):
    voltage: float


@dataclass(frozen=True, slots=True)
class Temperature(Record):
    value: np.ndarray


MORE = (
    Topic("/measured/battery", Battery, ("voltage",), "std_msgs/Float64", Kind.MEASURED, "V", "", "of the supply"),
    Topic(
        "/measured/temperature", Temperature, ("value",), "std_msgs/Float64MultiArray", Kind.MEASURED, "°C", "",
        "of the windings",
    ),
)  # fmt: skip


def test_a_signal_more_is_one_row(tmp_path: Path) -> None:
    table = (*TOPICS, *MORE)
    with Recorder(tmp_path / "r.mcap", ("a", "b"), topics=table) as recorder:
        for k in range(5):
            recorder.put(Battery(0.1 * k, 24.0 - k))
            recorder.put(Temperature(0.1 * k, np.array([20.0 + k, 30.0])))
    read = read_recording(tmp_path / "r.mcap", topics=table)
    assert read.tracks["/measured/battery"].fields["voltage"].tolist() == [24.0, 23.0, 22.0, 21.0, 20.0]
    assert read.tracks["/measured/temperature"].fields["value"][:, 0].tolist() == [20.0, 21.0, 22.0, 23.0, 24.0]
    assert [message.data for message in decoded(tmp_path / "r.mcap")["/measured/battery"]] == [24, 23, 22, 21, 20]
    said = channels(tmp_path / "r.mcap")["/measured/battery"].metadata
    assert said == {"kind": "measured", "units": "V", "frame": "", "meaning": "of the supply", "robot": ""}
    with Recorder(tmp_path / "s.mcap", ("a", "b")) as recorder, pytest.raises(UnknownName, match="Battery"):
        recorder.put(Battery(0.0, 1.0))


def test_counts_are_whole_numbers(tmp_path: Path) -> None:
    with Recorder(tmp_path / "r.mcap", ("a", "b")) as recorder:
        recorder.put(EncoderCounts(0.0, np.array([HUGE, -3])))
    assert read_recording(tmp_path / "r.mcap").counts.count.tolist() == [[HUGE, -3]]
    assert list(decoded(tmp_path / "r.mcap")["/measured/encoder_counts"][0].data) == [HUGE, -3]


def test_estimate_and_truth_have_their_own_frames(tmp_path: Path) -> None:
    pose, twist = np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.2, 0.3])
    with Recorder(tmp_path / "r.mcap") as recorder:
        recorder.put(BaseState(0.0, pose, twist, np.eye(3)))
        recorder.put(BaseTruth(0.0, pose + 1.0, twist))
        recorder.put(FrameTree(0.0, ("map", "odom"), ("odom", "base_link"), np.tile(np.eye(4), (2, 1, 1))))
    topics, read = decoded(tmp_path / "r.mcap"), read_recording(tmp_path / "r.mcap")
    assert topics["/odom"][0].header.frame_id == "odom"
    assert topics["/truth/odom"][0].header.frame_id == "world"
    pairs = [(t.header.frame_id, t.child_frame_id) for t in topics["/tf"][0].transforms]
    assert pairs == [("map", "odom"), ("odom", "base_link")]
    assert np.allclose(read.true_base.pose, [pose + 1.0])
    assert set(read.tree) == {("map", "odom"), ("odom", "base_link")}


def test_two_robots_in_one_file(tmp_path: Path) -> None:
    path, still = tmp_path / "r.mcap", np.zeros(2)
    with Recorder(path, ("j1", "j2"), robot="left") as recorder:
        right = recorder.scoped("right", ("j1",))
        for k in range(3):
            recorder.put(JointState(0.1 * k, still + k, still, still))
            right.put(JointState(0.1 * k, still[:1] - k, still[:1], still[:1]))
            right.put(FramePoses(0.1 * k, ("tool",), np.eye(4)[None]))
            recorder.put(FramePoses(0.1 * k, ("tool",), 2.0 * np.eye(4)[None] - np.diag([1.0, 1.0, 1.0, 1.0])))
        recorder.put(Event(0.2, "info", "program", "done"))
        right.put(Signal(0.2, 3, True))
    topics = decoded(path)
    assert tuple(topics["/left/joint_states"][0].name) == ("left.j1", "left.j2")
    assert {t.child_frame_id for m in topics["/truth/tf"] for t in m.transforms} == {"left/tool", "right/tool"}
    assert topics["/rosout"][0].name == "left.program"
    left, other = read_recording(path), read_recording(path, robot="right")
    assert (left.robot, left.robots, left.joint_names) == ("left", ("left", "right"), ("j1", "j2"))
    assert left.joints.position[:, 0].tolist() == [0.0, 1.0, 2.0]
    assert other.joints.position[:, 0].tolist() == [0.0, -1.0, -2.0]
    assert set(left.frames) == {"tool", "right/tool"}
    assert left.events[0].source == "program"
    assert (len(left.signals), other.signals[1:]) == (0, (Signal(0.2, 3, True),))
    assert len(other.tool.time) == 3
    with pytest.raises(UnknownName, match="middle"):
        read_recording(path, robot="middle")
    for name in ("truth", "a/b", "a.b", "signals"):
        with pytest.raises(OutOfLimits, match="a robot is called"):
            Recorder(tmp_path / "s.mcap", robot=name)


def test_a_signal_states_its_value_from_the_start(tmp_path: Path) -> None:
    still = np.zeros(1)
    with Recorder(tmp_path / "r.mcap", ("a",)) as recorder:
        recorder.put(JointState(0.5, still, still, still))
        for record in (Signal(0.5, 1, False), Signal(2.0, 1, True), Signal(3.0, 2, True), Signal(4.0, 2, False)):
            recorder.put(record)
    read = read_recording(tmp_path / "r.mcap").signals
    assert [(s.time, s.on) for s in read if s.number == 1] == [(0.5, False), (2.0, True)]
    assert [(s.time, s.on) for s in read if s.number == 2] == [(0.5, False), (3.0, True), (4.0, False)]


def write_old(path: Path) -> None:
    """A recording as it was before channels said what they are."""
    joints, numbers = joint_layout(JointMessage(("a",), 2)), array_layout(1)
    frames, odometry = transform_layout([("world", "tool")]), odometry_layout()
    pose = np.array([1.0, 2.0, 3.0, 0.0, 0.0, 0.0, 1.0])
    place = odometry_values(np.array([1.0, 2.0, 0.5]), np.zeros(3), np.zeros((3, 3)))
    messages = {
        "/joint_reference": ("sensor_msgs/JointState", joints.pack(0, np.array([0.1, 0.2]))),
        "/motor_current": ("std_msgs/Float64MultiArray", numbers.pack(0, np.array([3.0]))),
        "/motor_voltage": ("std_msgs/Float64MultiArray", numbers.pack(0, np.array([4.0]))),
        "/tf": ("tf2_msgs/TFMessage", frames.pack(0, pose)),
        "/tool_pose": ("geometry_msgs/PoseStamped", pose_layout().pack(0, pose)),
        "/base_reference": ("nav_msgs/Odometry", odometry.pack(0, place)),
        "/wheel_force": ("std_msgs/Float64MultiArray", numbers.pack(0, np.array([5.0]))),
        "/wheel_slip": ("std_msgs/Float64MultiArray", numbers.pack(0, np.array([6.0]))),
        "/wheel_residual": ("std_msgs/Float64MultiArray", numbers.pack(0, np.array([7.0]))),
    }
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2", "holonom")
        for topic, (kind, data) in messages.items():
            schema = writer.register_schema(kind, "ros2msg", b"")
            channel = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channel, 0, data, 0)
        writer.finish()


def test_former_names_are_read(tmp_path: Path) -> None:
    write_old(tmp_path / "r.mcap")
    read = read_recording(tmp_path / "r.mcap")
    assert (read.reference.position[0, 0], read.reference.velocity[0, 0]) == (0.1, 0.2)
    assert (read.drives.current[0, 0], read.drives.voltage[0, 0]) == (3.0, 4.0)
    contacts = read.contacts
    assert (contacts.force[0, 0], contacts.slip[0, 0], contacts.residual[0, 0]) == (5.0, 6.0, 7.0)
    assert read.frames["tool"].position.tolist() == read.tool.position.tolist() == [[1.0, 2.0, 3.0]]
    assert not read.tree
    assert np.allclose(read.base_reference.pose, [[1.0, 2.0, 0.5]])


def test_quaternions_are_those_of_scipy() -> None:
    turns = Rotation.concatenate(
        [Rotation.random(300, random_state=1), Rotation.from_rotvec(np.pi * np.eye(3)), Rotation.identity(1)]
    )
    poses = np.tile(np.eye(4), (len(turns), 1, 1))
    poses[:, :3, :3] = turns.as_matrix()
    found = pose_rows(poses)[:, 3:]
    assert np.allclose(np.abs((found * turns.as_quat()).sum(axis=1)), 1.0, atol=1e-14)
    assert (found[:, 3] >= 0.0).all()
    assert np.allclose(found[:300], turns.as_quat(canonical=True)[:300], atol=1e-14)

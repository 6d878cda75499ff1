"""The one table of signals: what it says is what is recorded; a signal more is one row; several robots in a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from holonom import signals
from holonom.app.recording import Recorder, read_recording, topics_table
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
    assert (len(left.signals), other.signals) == (0, (Signal(0.2, 3, True),))
    assert len(other.tool.time) == 3
    with pytest.raises(UnknownName, match="middle"):
        read_recording(path, robot="middle")
    for name in ("truth", "a/b", "a.b", "signals"):
        with pytest.raises(OutOfLimits, match="a robot is called"):
            Recorder(tmp_path / "s.mcap", robot=name)

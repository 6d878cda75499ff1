"""The recording: a peer decoder reads the values that went in; our reader gives them back to the bit."""

from __future__ import annotations

import hashlib
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from holonom.app.recording import EPOCH, Recorder, read_recording
from holonom.app.recording.format.cdr import CdrReader, CdrWriter
from holonom.app.recording.format.schemas import schema_text
from holonom.errors import InputError, OutputError, ShapeError
from holonom.signals import DriveState, Event, FramePoses, JointCommand, JointState, Signal

JOINTS = ("waist", "shoulder", "elbow")
FRAMES = ("link1", "tool", "coin_01", "a frame with ü")


def records(ticks: int = 40) -> list:
    rng = np.random.default_rng(7)
    out = []
    for k in range(ticks):
        t, v = 0.01 * k, rng.normal(size=(8, 3))
        poses = np.tile(np.eye(4), (len(FRAMES), 1, 1))
        poses[:, :3, :3] = Rotation.random(len(FRAMES), random_state=k).as_matrix()
        poses[:, :3, 3] = rng.normal(size=(len(FRAMES), 3))
        out += [JointState(t, v[0], v[1], v[2]), JointCommand(t, v[3], v[4], v[5]), DriveState(t, v[6], v[7])]
        out.append(FramePoses(t, FRAMES, poses))
        if k % 10 == 0:
            out += [Event(t, "warning", "sort.arps", f"coin {k}", k), Signal(t, 5, k % 20 == 0)]
    return out


def write(path: Path, given: list) -> Path:
    with Recorder(path, JOINTS) as recorder:
        for record in given:
            recorder.put(record)
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    given = records()
    return given, write(tmp_path_factory.mktemp("recording") / "recording.mcap", given)


def of(given: list, kind: type) -> list:
    return [record for record in given if isinstance(record, kind)]


def decoded(path: Path) -> dict[str, list]:
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        out: dict[str, list] = {}
        for _, channel, raw, message in reader.iter_decoded_messages():
            out.setdefault(channel.topic, []).append((raw.log_time, message))
    return out


def nanoseconds(stamp) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


def test_peer_decodes_joint_states_and_references(run):
    given, path = run
    topics = decoded(path)
    for topic, kind in (("/joint_states", JointState), ("/commanded/joint_states", JointCommand)):
        for record, (log_time, message) in zip(of(given, kind), topics[topic], strict=True):
            assert tuple(message.name) == JOINTS
            assert nanoseconds(message.header.stamp) == log_time == EPOCH + round(record.time * 1e9)
            assert np.array_equal(message.position, record.position)
            assert np.array_equal(message.velocity, record.velocity)
            if isinstance(record, JointState):
                assert np.array_equal(message.effort, record.effort)
            else:
                assert len(message.effort) == 0


def test_peer_decodes_motors_signals_and_log(run):
    given, path = run
    topics = decoded(path)
    drives = of(given, DriveState)
    for name, topic in (("current", "/measured/motor_current"), ("voltage", "/commanded/motor_voltage")):
        for record, (_, message) in zip(drives, topics[topic], strict=True):
            assert np.array_equal(message.data, getattr(record, name))
            assert [(d.label, d.size, d.stride) for d in message.layout.dim] == [("axis", 3, 3)]
    assert [m.data for _, m in topics["/signals/5"]] == [s.on for s in of(given, Signal)]
    for event, (_, message) in zip(of(given, Event), topics["/rosout"], strict=True):
        assert (message.level, message.name, message.line) == (30, event.source, event.line)
        assert message.msg.startswith(event.text)
        assert (f"line {event.line}" in message.msg) == (event.line > 0)


def test_peer_decodes_frames_and_tool(run):
    given, path = run
    topics = decoded(path)
    for record, (_, message), (_, tool) in zip(
        of(given, FramePoses), topics["/truth/tf"], topics["/truth/tool_pose"], strict=True
    ):
        assert tuple(t.child_frame_id for t in message.transforms) == FRAMES
        assert {t.header.frame_id for t in message.transforms} == {"world"}
        for i, transform in enumerate(message.transforms):
            p, r = transform.transform.translation, transform.transform.rotation
            assert np.array_equal([p.x, p.y, p.z], record.poses[i, :3, 3])
            R = Rotation.from_quat([r.x, r.y, r.z, r.w]).as_matrix()
            assert np.allclose(R, record.poses[i, :3, :3], rtol=0, atol=1e-14)
        p = tool.pose.position
        assert np.array_equal([p.x, p.y, p.z], record.poses[FRAMES.index("tool"), :3, 3])


def test_reader_gives_back_what_went_in(run):
    given, path = run
    recording = read_recording(path)
    assert recording.joint_names == JOINTS
    for track, kind in ((recording.joints, JointState), (recording.reference, JointCommand)):
        assert np.array_equal(track.time, [round(r.time, 9) for r in of(given, kind)])
        assert np.array_equal(track.position, [r.position for r in of(given, kind)])
        assert np.array_equal(track.velocity, [r.velocity for r in of(given, kind)])
    assert np.array_equal(recording.joints.effort, [r.effort for r in of(given, JointState)])
    assert np.array_equal(recording.drives.current, [r.current for r in of(given, DriveState)])
    assert np.array_equal(recording.drives.voltage, [r.voltage for r in of(given, DriveState)])
    for i, name in enumerate(FRAMES):
        poses = np.array([r.poses[i] for r in of(given, FramePoses)])
        assert np.allclose(recording.frames[name].poses(), poses, rtol=0, atol=1e-14)
    assert np.array_equal(recording.tool.position, recording.frames["tool"].position)
    assert list(recording.events) == [
        Event(round(e.time, 9), e.level, e.source, e.text, e.line) for e in of(given, Event)
    ]
    assert [(s.number, s.on) for s in recording.signals] == [(s.number, s.on) for s in of(given, Signal)]
    assert recording.end() == pytest.approx(0.39)


def test_same_records_same_bytes(run, tmp_path):
    given, path = run
    assert write(tmp_path / "again.mcap", given).read_bytes() == path.read_bytes()
    changed = write(tmp_path / "changed.mcap", given[:-1])
    assert changed.read_bytes() != path.read_bytes()


def test_profile_encodings_and_schemas(run):
    with run[1].open("rb") as stream:
        reader = make_reader(stream)
        assert reader.get_header().profile == "ros2"
        summary = reader.get_summary()
    types = {c.topic: summary.schemas[c.schema_id].name for c in summary.channels.values()}
    assert types == {
        "/joint_states": "sensor_msgs/msg/JointState",
        "/commanded/joint_states": "sensor_msgs/msg/JointState",
        "/measured/motor_current": "std_msgs/msg/Float64MultiArray",
        "/commanded/motor_voltage": "std_msgs/msg/Float64MultiArray",
        "/truth/tf": "tf2_msgs/msg/TFMessage",
        "/truth/tool_pose": "geometry_msgs/msg/PoseStamped",
        "/rosout": "rcl_interfaces/msg/Log",
        "/signals/5": "std_msgs/msg/Bool",
    }
    assert {c.message_encoding for c in summary.channels.values()} == {"cdr"}
    assert {s.encoding for s in summary.schemas.values()} == {"ros2msg"}


def test_error_leaves_a_valid_file(tmp_path):
    def fail() -> None:
        with Recorder(tmp_path / "r.mcap", JOINTS) as recorder:
            for record in records(5):
                recorder.put(record)
            raise RuntimeError("a coin out of reach")

    with pytest.raises(RuntimeError, match="out of reach"):
        fail()
    assert len(decoded(tmp_path / "r.mcap")["/joint_states"]) == 5
    assert len(read_recording(tmp_path / "r.mcap").joints.time) == 5


def test_empty_recording_reads_as_empty(tmp_path):
    recording = read_recording(write(tmp_path / "r.mcap", []))
    assert recording.end() == 0.0
    assert recording.joint_names == ()
    assert len(recording.joints.time) == len(recording.frames) == len(recording.events) == 0


def test_frames_may_change_from_record_to_record(tmp_path):
    one, two = np.tile(np.eye(4), (1, 1, 1)), np.tile(np.eye(4), (2, 1, 1))
    path = write(
        tmp_path / "r.mcap",
        [FramePoses(0.0, ("ab",), one), FramePoses(0.1, ("cd",), one), FramePoses(0.2, ("ab", "cd"), two)],
    )
    frames = read_recording(path).frames
    assert {name: frame.time.tolist() for name, frame in frames.items()} == {
        "ab": [0.0, 0.2],
        "cd": [0.1, 0.2],
    }


def test_alignment_is_checked_by_a_known_message():
    """std_msgs/String-like values by hand: 'ab' is length 3, two letters, zero, then padding to 8."""
    layout = CdrWriter().text("ab").doubles(1).layout()
    message = layout.pack(0, np.array([1.0]))
    assert message.hex() == "00010000" + "03000000" + "616200" + "00" + "000000000000f03f"
    assert CdrReader(message).text() == "ab"


def test_wrong_number_of_joints(tmp_path):
    two = np.zeros(2)
    with Recorder(tmp_path / "r.mcap", JOINTS) as recorder, pytest.raises(ShapeError, match="6 numbers"):
        recorder.put(JointState(0.0, two, two, two))


def test_output_that_cannot_be_written(tmp_path):
    with pytest.raises(OutputError, match="cannot write the recording"):
        Recorder(tmp_path / "missing" / "r.mcap", JOINTS)


def test_input_that_is_no_recording(tmp_path):
    with pytest.raises(InputError, match="cannot read"):
        read_recording(tmp_path / "none.mcap")
    (tmp_path / "text.mcap").write_text("this is not a recording, it is a text")
    with pytest.raises(InputError, match="no MCAP recording"):
        read_recording(tmp_path / "text.mcap")


UPSTREAM = {  # git object names of the files in ROS 2 Kilted Kaiju
    "builtin_interfaces/Time": "dffade0e3ea98a7e51b1e30ba504184001469579",
    "geometry_msgs/Point": "f1d3a71a853c668f066de795ba5e0f4458f3f1c0",
    "geometry_msgs/Pose": "277e2f0179a64cd3e17e31502e3d8a074ace7064",
    "geometry_msgs/PoseStamped": "2b43935ed33b384937142aaf3aae085cdcb9ea5e",
    "geometry_msgs/Quaternion": "96d392779a286cc3f4c83d80962236f5ea42c884",
    "geometry_msgs/Transform": "f605c85ea8ec4c4871bdb7d77db6e7011c63e86d",
    "geometry_msgs/TransformStamped": "24e97b80b39d9ed9b1ea7b4df553d9ad40bb0b7c",
    "geometry_msgs/Vector3": "b54588e117c4632f551c221fbc33df8f958804bf",
    "rcl_interfaces/Log": "b4387dacd6529a60786c6fb8f54c09126e5ef55d",
    "sensor_msgs/JointState": "ffaa9bfb0059383a6282abee168c72fdc92793ce",
    "std_msgs/Bool": "ffd399ea7eb5f2c66e9b664f28fafa983abddd24",
    "std_msgs/Float64MultiArray": "43d7ab7378b8a79f69f04f8ab2a3b56d20b7587b",
    "std_msgs/Header": "6966bb98863c237131a2bd2822298df9511ce948",
    "std_msgs/MultiArrayDimension": "ab0376b4fc5f0144987114a5e27f6cb3cbb3b494",
    "std_msgs/MultiArrayLayout": "06f2fea3de3ae0d62dbaff24431c90ed0e280325",
    "tf2_msgs/TFMessage": "fda1e4d0985406667d26b7b36cbbedc9bb497074",
}


def test_definitions_are_upstream_to_the_byte():
    folder = files("holonom.app.recording.format") / "definitions"
    for name, expected in UPSTREAM.items():
        data = (folder / f"{name}.msg").read_bytes()
        assert hashlib.sha1(b"blob %d\0" % len(data) + data).hexdigest() == expected, name


def test_schema_text_joins_each_dependency_once():
    text = schema_text("geometry_msgs/PoseStamped")
    parts = text.split("\n" + "=" * 80 + "\n")
    assert [part.splitlines()[0] for part in parts[1:]] == [
        "MSG: geometry_msgs/Pose",
        "MSG: geometry_msgs/Point",
        "MSG: geometry_msgs/Quaternion",
        "MSG: std_msgs/Header",
        "MSG: builtin_interfaces/Time",
    ]

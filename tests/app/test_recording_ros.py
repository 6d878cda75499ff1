"""What tools of ROS and Foxglove look for in a recording, read by an independent decoder from the file's schemas."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from holonom.app.console.cli import main
from holonom.app.recording import EPOCH, read_recording
from holonom.app.recording.urdf import urdf_of
from holonom.mechanics import load_arm

CELLS = Path(__file__).parent / "cells"


@pytest.fixture(scope="module")
def coins(example_run) -> Path:
    return example_run("01_sort_coins") / "recording.mcap"


def messages(path: Path, *topics: str) -> dict[str, list]:
    found: dict[str, list] = {topic: [] for topic in topics}
    until = EPOCH + 2 * 10**9
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, raw, message in reader.iter_decoded_messages(topics=list(topics), ending_before=until):
            found[channel.topic].append((raw.log_time, message))
    return found


def matrix(transform) -> np.ndarray:
    T, t, r = np.eye(4), transform.translation, transform.rotation
    T[:3, :3], T[:3, 3] = Rotation.from_quat([r.x, r.y, r.z, r.w]).as_matrix(), [t.x, t.y, t.z]
    return T


def pose_of(origin: ET.Element | None) -> np.ndarray:
    """By the definition of URDF: roll, pitch and yaw about fixed axes."""
    T = np.eye(4)
    if origin is not None:
        T[:3, :3] = Rotation.from_euler("xyz", [float(v) for v in origin.get("rpy").split()]).as_matrix()
        T[:3, 3] = [float(v) for v in origin.get("xyz").split()]
    return T


def placed(urdf: str, q: dict[str, float]) -> dict[str, np.ndarray]:
    """Poses of all links in the root, by a reader of twenty lines that knows URDF and nothing of ours."""
    robot = ET.fromstring(urdf)
    joints = robot.findall("joint")
    (root,) = {link.get("name") for link in robot.findall("link")} - {j.find("child").get("link") for j in joints}
    found, waiting = {root: np.eye(4)}, list(joints)
    while waiting:
        joint = next(j for j in waiting if j.find("parent").get("link") in found)
        waiting.remove(joint)
        T = found[joint.find("parent").get("link")] @ pose_of(joint.find("origin"))
        if joint.get("type") != "fixed":
            axis = np.array([float(v) for v in joint.find("axis").get("xyz").split()])
            mimic, move = joint.find("mimic"), np.eye(4)
            value = q[joint.get("name")] if mimic is None else None
            if mimic is not None:
                value = float(mimic.get("multiplier")) * q[mimic.get("joint")] + float(mimic.get("offset"))
            if joint.get("type") == "prismatic":
                move[:3, 3] = axis * value
            else:
                move[:3, :3] = Rotation.from_rotvec(axis * value).as_matrix()
            T = T @ move
        found[joint.find("child").get("link")] = T
    return found


def test_the_robot_is_described_in_the_frames_of_tf(coins: Path) -> None:
    """Its links, moved by /joint_states from where /tf_static puts its base, lie where /tf and /truth/tf say."""
    found = messages(coins, "/robot_description", "/tf_static", "/joint_states", "/tf", "/truth/tf")
    ((_, description),) = found["/robot_description"]
    ((_, static),) = found["/tf_static"]
    stands = {t.child_frame_id: (t.header.frame_id, matrix(t.transform)) for t in static.transforms}
    assert {"base", "table", "tray"} <= set(stands)
    assert stands["base"][0] == "world"
    truth = [m for _, m in found["/truth/tf"] if any(t.child_frame_id == "tool" for t in m.transforms)]
    for k in (0, 100, 199):
        state = found["/joint_states"][k][1]
        links = placed(description.data, dict(zip(state.name, state.position, strict=True)))
        tf = {t.child_frame_id: t for t in found["/tf"][k][1].transforms}
        assert set(tf) == {"link1", "link2", "link3", "link4", "link5", "link6", "tool"} <= set(links)
        for name, transform in tf.items():
            assert transform.header.frame_id == "world"
            assert np.allclose(matrix(transform.transform), stands["base"][1] @ links[name], atol=1e-9)
        true = next(t for t in truth[k].transforms if t.child_frame_id == "tool")
        assert np.allclose(matrix(true.transform), matrix(tf["tool"].transform), atol=1e-3)


@pytest.mark.parametrize("name", ["puma560", "stanford", "scara", "ur5e", "panda", "planar2r"])
def test_every_preset_is_described(name: str) -> None:
    """With a tool that is turned any way."""
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = Rotation.random(random_state=7).as_matrix(), [0.1, -0.2, 0.3]
    arm = load_arm(name).with_tool(T)
    q = np.random.default_rng(5).uniform(-1.0, 1.0, (20, arm.n))
    base = np.array(arm.model.base)
    for row in q:
        links = placed(urdf_of(arm.model), dict(zip(arm.limits.names, row, strict=True)))
        frames = arm.frames(row)
        assert np.allclose(base @ links["tool"], frames[-1], atol=1e-9)
        for k, T in enumerate(frames[1:-1]):
            assert np.allclose(base @ links[f"link{k + 1}"], T, atol=1e-9)


@pytest.mark.oracle
def test_pinocchio_reads_the_description(pinocchio) -> None:
    """Kinematics and masses come out as they went in: its mass matrix is ours but for the rotors."""
    arm = load_arm("panda")
    model = pinocchio.buildModelFromXML(urdf_of(arm.model))
    data, q = model.createData(), np.random.default_rng(6).uniform(-1.0, 1.0, arm.n)
    pinocchio.framesForwardKinematics(model, data, q)
    tool = data.oMf[model.getFrameId("tool")].homogeneous
    assert np.allclose(np.array(arm.model.base) @ tool, arm.frames(q)[-1], atol=1e-9)
    assert np.allclose(pinocchio.computeGeneralizedGravity(model, data, q), arm.gravity(q), atol=1e-9)


def test_the_photograph_and_the_parts(coins: Path) -> None:
    found = messages(coins, "/measured/photograph", "/truth/parts", "/truth/tf")
    ((_, photograph),) = found["/measured/photograph"]
    assert photograph.format == "png"
    assert bytes(photograph.data) == read_recording(coins).attachments["photograph.png"]
    ((_, parts),) = found["/truth/parts"]
    frames = {t.child_frame_id for _, m in found["/truth/tf"] for t in m.transforms}
    coins_seen = [marker for marker in parts.markers if marker.header.frame_id.startswith("coin_")]
    assert len(coins_seen) == 24
    for marker in coins_seen:
        assert marker.header.frame_id in frames
        assert (marker.type, marker.action, marker.frame_locked) == (3, 0, True)
        assert (marker.lifetime.sec, marker.lifetime.nanosec) == (0, 0)
        assert 0.01 < marker.scale.x == marker.scale.y < 0.04
        assert marker.pose.orientation.w == 1.0
        assert marker.color.a == 1.0
    assert len({(marker.ns, marker.id) for marker in parts.markers}) == len(parts.markers)


def test_stamps_are_dates_and_the_same_in_every_run(coins: Path) -> None:
    """2000-01-01, whose seconds since 1970 are 946,684,800; a stamp of zero is none for ROS."""
    assert EPOCH == 946_684_800 * 10**9
    found = messages(coins, "/joint_states", "/tf_static", "/rosout")
    for topic in found.values():
        for log_time, message in topic:
            assert log_time >= EPOCH
            stamp = getattr(message, "stamp", None) or getattr(message, "header", None)
            if stamp is not None:
                stamp = getattr(stamp, "stamp", stamp)
                assert stamp.sec * 10**9 + stamp.nanosec == log_time
    assert read_recording(coins).joints.time[0] == 0.0


def test_what_is_said_once_is_kept_for_late_listeners(coins: Path) -> None:
    with coins.open("rb") as stream:
        channels = {c.topic: c.metadata for c in make_reader(stream).get_summary().channels.values()}
    kept = {topic for topic, words in channels.items() if "durability: 1" in words.get("offered_qos_profiles", "")}
    assert kept == {"/robot_description", "/tf_static", "/measured/photograph", "/truth/parts"}


def test_rosout_names_file_and_line(coins: Path) -> None:
    found = messages(coins, "/rosout")["/rosout"]
    lines = [message for _, message in found if message.line]
    assert lines
    assert {message.file for message in lines} == {"sort_coins.arps"}
    event = next(event for event in read_recording(coins).events if event.line)
    assert event.file == "sort_coins.arps"


def test_an_arm_on_a_base_hangs_on_its_frames(tmp_path: Path) -> None:
    assert main(["run", str(CELLS / "arm_on_base.toml"), "-o", str(tmp_path), "--quiet"]) in (0, 1)
    path = tmp_path / "recording.mcap"
    base, arm = "agv", "ur"
    topics = ("/tf_static", "/tf", "/truth/tf", f"/{arm}/robot_description", f"/{arm}/joint_states")
    found = messages(path, *topics)
    fixed = {t.child_frame_id: t for _, m in found["/tf_static"] for t in m.transforms}
    assert fixed[f"{arm}/base"].header.frame_id == f"{base}/base_link"
    moved = next(m for _, m in found["/tf"] if any(t.child_frame_id == f"{arm}/tool" for t in m.transforms))
    tool = next(t for t in moved.transforms if t.child_frame_id == f"{arm}/tool")
    assert tool.header.frame_id == f"{arm}/base"
    state = found[f"/{arm}/joint_states"][0][1]
    description = found[f"/{arm}/robot_description"][0][1].data
    links = placed(description, dict(zip(state.name, state.position, strict=True)))
    assert np.allclose(links[f"{arm}/tool"], matrix(tool.transform), atol=1e-9)
    truth = {
        t.child_frame_id: matrix(t.transform) for time, m in found["/truth/tf"] if time == EPOCH for t in m.transforms
    }
    believed = truth[f"{base}/base_link"] @ matrix(fixed[f"{arm}/base"].transform) @ links[f"{arm}/tool"]
    assert np.allclose(believed, truth[f"{arm}/tool"], atol=2e-3)


def test_joints_that_follow_others_are_recorded_and_described(root: Path, tmp_path: Path) -> None:
    """A finger that turns with the first joint, -2 times as far and 0.1 rad on: its link has its own place."""
    (tmp_path / "three.urdf").write_bytes((root / "fuzz" / "seeds" / "urdf" / "three.urdf").read_bytes())
    (tmp_path / "cell.toml").write_text(
        '[cell]\nname = "x"\ntime_limit = "5s"\n[[robot]]\nmodel = "three.urdf"\ndrives = "ideal"\n'
        'home = ["20deg", "100mm"]\nhold = "50ms"\n',
        "utf-8",
    )
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    path = tmp_path / "out" / "recording.mcap"
    found = messages(path, "/robot_description", "/joint_states", "/truth/tf", "/tf_static")
    state, truth = found["/joint_states"][0][1], found["/truth/tf"][0][1]
    links = placed(found["/robot_description"][0][1].data, dict(zip(state.name, state.position, strict=True)))
    at = {t.child_frame_id: matrix(t.transform) for t in truth.transforms}
    assert set(at) == {"link1", "link2", "link3", "tool"}
    stands = {t.child_frame_id: matrix(t.transform) for t in found["/tf_static"][0][1].transforms}["base"]
    for name, T in at.items():
        assert np.allclose(T, stands @ links[name], atol=1e-9)
    turned = at["link2"][:3, :3].T @ at["link3"][:3, :3]
    assert abs(np.arccos((np.trace(turned) - 1) / 2) - abs(-2 * np.radians(20.0) + 0.1)) < 1e-9

"""What a mobile base records: a peer decoder reads the values that went in, our reader gives them back."""

from __future__ import annotations

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from scipy.spatial.transform import Rotation

from holonom.app.recording import Recorder, read_recording
from holonom.errors import ShapeError
from holonom.signals import BaseCommand, BaseState, Inertial, WheelContact

WHEELS = ("front left", "rear left", "rear right", "front right")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    rng = np.random.default_rng(3)
    given = []
    for k in range(30):
        t, v = 0.01 * k, rng.normal(size=(6, 3))
        square = rng.normal(size=(3, 3))
        given += [BaseState(t, v[0], v[1], square @ square.T), BaseCommand(t, v[2], v[3])]
        given += [Inertial(t, v[4, 0], v[5, :2]), WheelContact(t, *rng.normal(size=(3, 4)))]
    path = tmp_path_factory.mktemp("base") / "recording.mcap"
    with Recorder(path, WHEELS) as recorder:
        for record in given:
            recorder.put(record)
    topics: dict[str, list] = {}
    with path.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, channel, _, message in reader.iter_decoded_messages():
            topics.setdefault(channel.topic, []).append(message)
    return given, topics, read_recording(path)


def of(given: list, kind: type) -> list:
    return [record for record in given if isinstance(record, kind)]


def test_peer_decodes_the_odometry(run):
    given, topics, _ = run
    for record, message in zip(of(given, BaseState), topics["/odom"], strict=True):
        assert (message.header.frame_id, message.child_frame_id) == ("odom", "base_link")
        place, q = message.pose.pose.position, message.pose.pose.orientation
        assert (place.x, place.y, place.z) == (*record.pose[:2], 0.0)
        turn = Rotation.from_quat([q.x, q.y, q.z, q.w]).as_rotvec()
        assert np.allclose(Rotation.from_rotvec([0, 0, record.pose[2]]).as_rotvec(), turn)
        twist = message.twist.twist
        assert (twist.linear.x, twist.linear.y, twist.angular.z) == tuple(record.twist)
        plane = np.array(message.pose.covariance).reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]
        assert np.array_equal(plane, record.covariance)


def test_peer_decodes_imu_and_wheels(run):
    given, topics, _ = run
    for record, message in zip(of(given, Inertial), topics["/imu"], strict=True):
        assert message.orientation_covariance[0] == -1.0  # states no orientation (REP 145)
        assert message.angular_velocity.z == record.rate
        assert (message.linear_acceleration.x, message.linear_acceleration.y) == tuple(record.acceleration)
    for name, kind in (("force", "truth"), ("slip", "truth"), ("residual", "estimated")):
        for record, message in zip(of(given, WheelContact), topics[f"/{kind}/wheel_{name}"], strict=True):
            assert np.array_equal(message.data, getattr(record, name))


def test_our_reader_gives_them_back(run):
    given, _, recording = run
    states, contacts = of(given, BaseState), of(given, WheelContact)
    assert np.allclose(recording.base.pose, [r.pose for r in states], atol=1e-14)
    assert np.array_equal(recording.base.twist, [r.twist for r in states])
    assert np.array_equal(recording.base.covariance, [r.covariance for r in states])
    assert np.allclose(recording.base_reference.pose, [r.pose for r in of(given, BaseCommand)], atol=1e-14)
    assert np.array_equal(recording.contacts.force, [r.force for r in contacts])
    assert np.array_equal(recording.contacts.residual, [r.residual for r in contacts])
    assert recording.end() == pytest.approx(0.29)


def test_one_number_per_wheel(tmp_path):
    with Recorder(tmp_path / "r.mcap", WHEELS) as recorder, pytest.raises(ShapeError, match="3 numbers"):
        recorder.put(WheelContact(0.0, np.zeros(3), np.zeros(3), np.zeros(3)))

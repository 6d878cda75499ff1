"""Robots as shipped and at random: laws, published reference values, live Pinocchio."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from xml.etree import ElementTree

import float_arm
import numpy as np
import pytest
from random_urdf import random_urdf

from holonom.errors import MissingInertia
from holonom.mechanics import Arm, load_arm
from holonom.model import read_urdf

ROBOTS = (
    "example_robot_data/ur10_robot.urdf",
    "example_robot_data/ur3_robot.urdf",
    "example_robot_data/ur5_robot.urdf",
    "pybullet/model.urdf",
    "rtb_data/al5d_robot.urdf",
    "rtb_data/irb140.urdf",
    "rtb_data/kr210l150.urdf",
    "rtb_data/lbr_iiwa_14_r820.urdf",
    "rtb_data/puma560_robot.urdf",
)
RANDOM = [(seed, 9) for seed in range(6)]


def drawn(seed, links):
    """The tool of a random robot is a guess, which is told; nothing else is."""
    text = random_urdf(seed, links)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        model = read_urdf(text)
    assert all("taken for the tool, a guess" in str(one.message) for one in told)
    return text, model


def folder(data_folder: Path) -> Path:
    return data_folder / "robots" / "urdf"


def reference(data_folder, robot):
    return json.loads((data_folder / "robots" / "pinocchio_reference.json").read_text())["robots"][robot]


def order(model, names):
    """Where each of the named joints stands in q."""
    own = [model.joints[i].name for i in model.independent]
    return [own.index(name) for name in names]


def close(got, expected, tolerance=1e-8):
    """To 1e-8, relative to the largest entry where that is above 1: the file states ten decimals or figures."""
    expected = np.array(expected)
    np.testing.assert_allclose(got, expected, rtol=0, atol=tolerance * max(1.0, np.abs(expected).max()))


def placed(values, at):
    q = np.zeros(len(at))
    q[at] = values
    return q


@pytest.mark.parametrize("robot", ROBOTS)
def test_reference_values(data_folder, robot):
    stated = reference(data_folder, robot)
    model = read_urdf(folder(data_folder) / robot, tip=stated["tip_frame"])
    at = order(model, stated["joints"])
    for case in stated["cases"]:
        q, qd, qdd = (placed(case[key], at) for key in ("q", "qd", "qdd"))
        close(float_arm.fk(model, q), case["T"])
        close(float_arm.jacobian(model, q)[:, at], case["J"])
        if model.bodies is not None:
            close(float_arm.mass_matrix(model, q)[np.ix_(at, at)], case["M"])
            close(float_arm.inverse_dynamics(model, q, 0 * q, 0 * q)[at], case["g"])
            close(float_arm.inverse_dynamics(model, q, qd, qdd)[at], case["tau"])


@pytest.mark.parametrize("robot", ["example_robot_data/ur5_robot.urdf", "pybullet/model.urdf"])
def test_reference_values_compiled(data_folder, robot):
    stated = reference(data_folder, robot)
    arm = load_arm(folder(data_folder) / robot, tip=stated["tip_frame"])
    at = order(arm.model, stated["joints"])
    q, qd, qdd = (np.array([placed(case[key], at) for case in stated["cases"]]) for key in ("q", "qd", "qdd"))
    expected = {key: np.array([case[key] for case in stated["cases"]]) for key in ("T", "J", "M", "g", "tau")}
    close(arm.fk(q), expected["T"])
    close(arm.jacobian(q)[..., at], expected["J"])
    close(arm.mass_matrix(q)[:, at][..., at], expected["M"])
    close(arm.gravity(q)[:, at], expected["g"])
    close(arm.inverse_dynamics(q, qd, qdd, friction=False)[:, at], expected["tau"])


def check_laws(model, seed=0):
    rng = np.random.default_rng(seed)
    n = len(model.independent)
    q, qd, qdd = rng.uniform(-1.5, 1.5, (3, n))
    h = 1e-6
    T, J = float_arm.fk(model, q), float_arm.jacobian(model, q)
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-12)
    for k, e in enumerate(h * np.eye(n)):
        dT = (float_arm.fk(model, q + e) - float_arm.fk(model, q - e)) / (2 * h)
        W = dT[:3, :3] @ T[:3, :3].T
        np.testing.assert_allclose(J[:, k], [*dT[:3, 3], W[2, 1], W[0, 2], W[1, 0]], atol=1e-8)
    if model.bodies is None:
        with pytest.raises(MissingInertia, match="kinematics only"):
            float_arm.mass_matrix(model, q)
        return
    B = float_arm.mass_matrix(model, q)
    tau = float_arm.inverse_dynamics(model, q, qd, qdd)
    scale = max(1.0, np.abs(B).max())
    np.testing.assert_allclose(B, B.T, atol=1e-13 * scale)
    assert np.linalg.eigvalsh(B).min() > -1e-12 * scale
    rest = float_arm.inverse_dynamics(model, q, qd, 0 * q)
    np.testing.assert_allclose(tau - rest, B @ qdd, atol=1e-12 * scale * n)
    if np.linalg.eigvalsh(B).min() > 1e-9 * scale:  # a tool of no size can turn without inertia (al5d)
        np.testing.assert_allclose(float_arm.qdd_of(model, q, qd, tau), qdd, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("robot", ROBOTS)
def test_shipped_robots_keep_the_laws(data_folder, robot):
    check_laws(read_urdf(folder(data_folder) / robot))


def test_no_shipped_robot_is_left_out(data_folder):
    assert {str(file.relative_to(folder(data_folder))) for file in folder(data_folder).rglob("*.urdf")} == set(ROBOTS)


def test_random_robots_have_every_kind_of_joint():
    models = [drawn(*shape)[1] for shape in RANDOM]
    joints = [joint for model in models for joint in model.joints]
    assert {"revolute", "prismatic"} == {joint.kind for joint in joints}
    assert sum(joint.mimic is not None for joint in joints) >= 2
    assert any(np.isinf(joint.limits.upper) for joint in joints)
    assert any(model.parent(i) != i - 1 for model in models for i in range(len(model.joints)))


@pytest.mark.parametrize(("seed", "links"), RANDOM)
def test_random_robots_keep_the_laws(seed, links):
    check_laws(drawn(seed, links)[1], seed)


class Peer:
    """Pinocchio's model of a URDF, its q arranged as ours: mimics spread, continuous joints as (cos, sin)."""

    def __init__(self, pin, text, names):
        self.pin = pin
        self.model = pin.buildModelFromXML(text)
        self.data = self.model.createData()
        self.joints = list(self.model.joints)[1:]
        self.G = np.zeros((self.model.nv, len(names)))  # theirs = G ours + offset
        self.offset = np.zeros(self.model.nv)
        follows = {joint.get("name"): joint.find("mimic") for joint in ElementTree.fromstring(text).iter("joint")}
        for name, joint in zip(list(self.model.names)[1:], self.joints, strict=True):
            mimic = follows[name]
            master = name if mimic is None else mimic.get("joint")
            self.G[joint.idx_v, names.index(master)] = 1.0 if mimic is None else float(mimic.get("multiplier"))
            self.offset[joint.idx_v] = 0.0 if mimic is None else float(mimic.get("offset"))

    def q(self, q):
        full = np.zeros(self.model.nq)
        for joint, angle in zip(self.joints, self.G @ q + self.offset, strict=True):
            full[joint.idx_q] = angle
            if joint.nq == 2:
                full[joint.idx_q : joint.idx_q + 2] = np.cos(angle), np.sin(angle)
        return full

    def fk(self, q, link):
        self.pin.framesForwardKinematics(self.model, self.data, self.q(q))
        return self.data.oMf[self.model.getFrameId(link, self.pin.BODY)].homogeneous

    def jacobian(self, q, link):
        aligned = self.pin.LOCAL_WORLD_ALIGNED
        frame = self.model.getFrameId(link, self.pin.BODY)
        return self.pin.computeFrameJacobian(self.model, self.data, self.q(q), frame, aligned) @ self.G

    def mass_matrix(self, q):
        upper = np.triu(self.pin.crba(self.model, self.data, self.q(q)))
        return self.G.T @ (upper + np.triu(upper, 1).T) @ self.G

    def inverse_dynamics(self, q, qd, qdd):
        return self.G.T @ self.pin.rnea(self.model, self.data, self.q(q), self.G @ qd, self.G @ qdd)


def to_largest(got, expected):
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-10 * np.abs(expected).max())


def compare(peer, model, tip, q, qd, qdd):
    to_largest(float_arm.fk(model, q), peer.fk(q, tip))
    to_largest(float_arm.jacobian(model, q), peer.jacobian(q, tip))
    to_largest(float_arm.mass_matrix(model, q), peer.mass_matrix(q))
    to_largest(float_arm.inverse_dynamics(model, q, qd, qdd), peer.inverse_dynamics(q, qd, qdd))


@pytest.mark.oracle
@pytest.mark.parametrize(("robot", "tip"), [(ROBOTS[2], "ee_link"), (ROBOTS[6], "tool0")])
def test_shipped_robots_agree_with_pinocchio(pinocchio, data_folder, robot, tip):
    text = (folder(data_folder) / robot).read_text().partition("?>")[2]
    model = read_urdf(text, tip=tip)
    peer = Peer(pinocchio, text, Arm(model).limits.names)
    for q, qd, qdd in np.random.default_rng(1).uniform(-3, 3, (5, 3, 6)):
        compare(peer, model, tip, q, qd, qdd)


@pytest.mark.oracle
@pytest.mark.parametrize(("seed", "links"), RANDOM)
def test_random_robots_agree_with_pinocchio(pinocchio, seed, links):
    text, model = drawn(seed, links)
    tip = model.tool_frame
    peer = Peer(pinocchio, text, Arm(model).limits.names)
    for q, qd, qdd in np.random.default_rng(seed).uniform(-2, 2, (5, 3, len(model.independent))):
        compare(peer, model, tip, q, qd, qdd)


@pytest.mark.oracle
def test_angles_of_a_thousand_turns_keep_nine_digits(pinocchio, data_folder):
    text = (folder(data_folder) / ROBOTS[2]).read_text().partition("?>")[2]
    arm = Arm(read_urdf(text, tip="ee_link"))
    peer = Peer(pinocchio, text, arm.limits.names)
    q, qd, qdd = np.random.default_rng(2).uniform(-1, 1, (3, 200, 6)) * [[[1e4]], [[2]], [[2]]]
    T, tau = arm.fk(q), arm.inverse_dynamics(q, qd, qdd)
    expected = np.array([peer.inverse_dynamics(*row) for row in zip(q, qd, qdd, strict=True)])
    np.testing.assert_allclose(T, [peer.fk(row, "ee_link") for row in q], rtol=0, atol=1e-9)
    np.testing.assert_allclose(tau, expected, rtol=0, atol=1e-9 * np.abs(expected).max())

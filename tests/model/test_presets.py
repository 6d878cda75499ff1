"""Presets: model cards, bodies that can exist, and the numbers each card cites."""

from __future__ import annotations

import dataclasses
import json
import math
import re

import float_arm
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holonom.model import preset, preset_names

PUBLISHED_OTHERWISE = {"puma560": (0, 2)}
"""Links whose published inertias no body has (their missing moments never act, or were measured so)."""


@pytest.mark.parametrize("name", preset_names())
def test_card_names_sources_and_poses_are_within_limits(name):
    model = preset(name)
    assert model.name == name
    assert "Model card\n----------" in model.card
    assert re.search("approximate|assumed|made up|book", model.card, re.IGNORECASE)
    for pose, q in model.poses.items():
        assert len(q) == len(model.joints)
        for value, joint in zip(q, model.joints, strict=True):
            if pose == "ready":
                assert joint.limits.lower <= value <= joint.limits.upper


@pytest.mark.parametrize("name", preset_names())
def test_bodies_can_exist(name):
    for k, body in enumerate(preset(name).bodies):
        xx, yy, zz, xy, yz, xz = body.inertia
        a, b, c = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        possible = a >= 0 and a + b >= c * (1 - 1e-9)
        assert possible == (k not in PUBLISHED_OTHERWISE.get(name, ()))


@pytest.mark.parametrize("name", preset_names())
def test_mass_matrix_gives_power(name):
    """B is positive, and the torque of a pure acceleration is B qdd."""
    model = preset(name)
    q, qdd = np.random.default_rng(3).uniform(0.1, 1.0, (2, len(model.joints)))
    B = float_arm.mass_matrix(model, q)
    assert np.linalg.eigvalsh(B).min() > 0
    still = 0 * q
    tau = float_arm.inverse_dynamics(model, q, still, qdd) - float_arm.inverse_dynamics(model, q, still, still)
    np.testing.assert_allclose(tau, B @ qdd, rtol=1e-12, atol=1e-13)


def test_three_joint_arm_is_the_specification_s():
    """Specification 08: position from column, shoulder and elbow."""
    l1, l2, z0 = 0.30, 0.25, 0.30
    for a, b, g in np.random.default_rng(4).uniform(-2, 2, (10, 3)):
        reach = l1 * math.cos(b) + l2 * math.cos(b + g)
        expected = [reach * math.cos(a), reach * math.sin(a), z0 + l1 * math.sin(b) + l2 * math.sin(b + g)]
        np.testing.assert_allclose(float_arm.fk(preset("three_joint"), [a, b, g])[:3, 3], expected, atol=1e-14)


def test_pendulum_is_the_specification_s():
    """Specification 02.3: (I + I_m k_r^2) thdd + m g l sin(th) = tau, I about the pivot; th = 0 hangs down."""
    m, l, radius, rotor, gear, g = 2.0, 0.6, 0.01, 2e-5, 50.0, 9.81
    about_pivot = m * (3 * radius**2 + (2 * l) ** 2) / 12 + m * l**2
    model = preset("pendulum")
    for th, thd, thdd in np.random.default_rng(5).uniform(-3, 3, (10, 3)):
        tau = float_arm.inverse_dynamics(model, [th], [thd], [thdd])
        assert tau[0] == pytest.approx((about_pivot + rotor * gear**2) * thdd + m * g * l * math.sin(th), abs=1e-12)
    np.testing.assert_allclose(float_arm.fk(model, [0.0])[:3, 3], [0, 0, -1.2], atol=1e-15)
    assert float_arm.fk(model, [0.1])[0, 3] > 0
    assert (model.joints[0].friction.viscous, model.joints[0].friction.coulomb_positive) == (0.05, 0)


@pytest.mark.parametrize("rotors", ["reflected", "full"])
def test_planar_arm_is_the_textbook_s(rotors):
    """Siciliano et al., Robotics, 7.3.2: B, c and g of the two-link planar arm; its k I_m in b12 takes full rotors."""
    a1, l1, l2, ml, Il, mm, Im, k, g = 1.0, 0.5, 0.5, 50.0, 10.0, 5.0, 0.01, 100.0, 9.81
    model = dataclasses.replace(preset("planar2r"), rotors=rotors)
    coupling = k * Im if rotors == "full" else 0.0
    for q1, q2, d1, d2 in np.random.default_rng(6).uniform(-3, 3, (10, 4)):
        b22 = Il + ml * l2**2 + k**2 * Im
        b12 = Il + ml * (l2**2 + a1 * l2 * math.cos(q2)) + coupling
        b11 = 2 * Il + ml * l1**2 + k**2 * Im + ml * (a1**2 + l2**2 + 2 * a1 * l2 * math.cos(q2)) + Im + mm * a1**2
        np.testing.assert_allclose(float_arm.mass_matrix(model, [q1, q2]), [[b11, b12], [b12, b22]], rtol=1e-13)
        h = -ml * a1 * l2 * math.sin(q2)
        g2 = ml * l2 * g * math.cos(q1 + q2)
        g1 = (ml * l1 + mm * a1 + ml * a1) * g * math.cos(q1) + g2
        expected = [h * d2 * d1 + h * (d1 + d2) * d2 + g1, -h * d1 * d1 + g2]
        np.testing.assert_allclose(float_arm.inverse_dynamics(model, [q1, q2], [d1, d2], [0, 0]), expected, rtol=1e-11)


def test_panda_has_the_published_pose_and_jacobian(data_folder):
    """puma560_cases.json, panda_dh: to the four decimals printed. Its hand is 0.103 m long (the note says 0.1034)."""
    case = json.loads((data_folder / "robots" / "puma560_cases.json").read_text())["panda_dh"]
    model = preset("panda")
    hand = np.eye(4)
    hand[:3, :3] = Rotation.from_euler("z", -45, degrees=True).as_matrix()
    hand[2, 3] = 0.103
    T = float_arm.fk(model, case["q"]) @ hand
    np.testing.assert_allclose(T, case["fkine"], atol=1e-4)
    J = float_arm.jacobian(model, case["q"])
    J[:3] += np.cross(J[3:].T, T[:3, 3] - float_arm.fk(model, case["q"])[:3, 3]).T
    np.testing.assert_allclose(np.kron(np.eye(2), T[:3, :3].T) @ J, case["jacobe"], atol=1e-4)


def test_ur5e_stands_as_its_maker_says():
    """Stretched along -x_0 at zero: reach a2 + a3, d4 + d6 to the side, height d1 - d5 (the maker's table)."""
    T = float_arm.fk(preset("ur5e"), [0.0] * 6)
    np.testing.assert_allclose(T[:3, 3], [-0.8172, -0.1333 - 0.0996, 0.1625 - 0.0997], atol=1e-12)
    assert sum(body.mass for body in preset("ur5e").bodies) == pytest.approx(17.7)


@pytest.mark.oracle
@pytest.mark.parametrize(("name", "peer"), [("stanford", "Stanford"), ("scara", "Cobra600"), ("panda", "Panda")])
def test_poses_agree_with_the_robotics_toolbox(roboticstoolbox, name, peer):
    model = preset(name)
    robot = getattr(roboticstoolbox.models.DH, peer)()
    robot.tool = np.eye(4)  # the Panda's hand; its flange is part of the last row there
    for q in np.random.default_rng(7).uniform(0.1, 1.0, (5, len(model.joints))):
        np.testing.assert_allclose(float_arm.fk(model, q), robot.fkine(q).A, atol=1e-12)

"""The Jacobian of any frame, of several at once, of any point; limits that are set."""

import dataclasses

import numpy as np
import pytest

from holonom.errors import InputError, NotFinite, ShapeError, UnknownName
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.jacobians import point_jacobian
from holonom.model import ArmModel, Frame, Joint, JointLimits, Mimic, constant_transform
from holonom.spatial import pose

H = 1e-6


def slope(place, q):
    """d place / dq by central differences: (3, n)."""
    steps = H * np.eye(len(q))
    return np.stack([(place(q + s) - place(q - s)) / (2.0 * H) for s in steps], axis=-1)


def turning(arm, frame, q):
    """Angular velocity in the world for each joint's unit speed, (3, n), from the rotation's differences."""
    columns = []
    for step in H * np.eye(len(q)):
        W = (arm.fk(q + step, frame) - arm.fk(q - step, frame))[:3, :3] @ arm.fk(q, frame)[:3, :3].T / (2.0 * H)
        columns.append([W[2, 1], W[0, 2], W[1, 0]])
    return np.array(columns).T


@pytest.fixture(scope="module")
def two_handed():
    """A torso that turns, and an arm each side; joint 5 follows joint 2. Both hands are named frames."""
    up, out = pose((0.0, 0.0, 0.3)), pose((0.4, 0.1, 0.0), [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    sides = [pose((0.0, y, 0.2), [[1, 0, 0], [0, 0, -1], [0, 1, 0]]) for y in (0.2, -0.2)]
    joints = (
        Joint("torso", "revolute", after=constant_transform(up)),
        Joint("left1", "revolute", constant_transform(sides[0]), constant_transform(out), parent=0),
        Joint("left2", "prismatic", after=constant_transform(out), parent=1),
        Joint("right1", "revolute", constant_transform(sides[1]), constant_transform(out), parent=0),
        Joint("right2", "revolute", after=constant_transform(out), parent=3, mimic=Mimic(1, -0.5, 0.2)),
    )
    hands = (Frame("left", 2, constant_transform(out)), Frame("right", 4, constant_transform(out)))
    return Arm(
        ArmModel("two", joints, base=constant_transform(pose((1.0, 2.0, 0.0), out[:3, :3])), tip=2, frames=hands)
    )


def test_both_hands_at_once(two_handed):
    q = np.array([0.3, -0.7, 0.2, 0.5])
    J = two_handed.jacobian(q, of=("left", "right"))
    assert J.shape == (2, 6, 4)
    for one, name in zip(J, ("left", "right"), strict=True):
        np.testing.assert_allclose(one[:3], slope(lambda q, name=name: two_handed.fk(q, name)[:3, 3], q), atol=1e-8)
        np.testing.assert_allclose(one[3:], turning(two_handed, name, q), atol=1e-8)
        np.testing.assert_allclose(two_handed.jacobian(q, of=name), one, atol=1e-14)
    assert (J[0, :, 3] == 0.0).all()  # the right arm does not move the left hand
    rows = two_handed.jacobian(np.array([q, 0.5 * q]), of=("left", "right"))
    np.testing.assert_allclose(rows[0], J, atol=1e-14)


@pytest.mark.parametrize("frame", ["world", "base", "tool", "own"])
@pytest.mark.parametrize("of", ["tool", "link3"])
def test_a_point_of_any_frame(frame, of):
    arm = load_arm("puma560").with_base(pose((0.1, 0.2, 0.3), [[0, -1, 0], [1, 0, 0], [0, 0, 1]]))
    q, p = np.array([0.2, 0.7, -2.9, 0.3, 0.6, -0.4]), np.array([0.1, -0.2, 0.05])
    J = point_jacobian(arm, q, p, of=of, frame=frame)
    R = {"world": np.eye(3), "own": arm.fk(q, of)[:3, :3]}.get(frame)
    R = arm.fk(q, frame)[:3, :3] if R is None else R
    v = slope(lambda q: (arm.fk(q, of) @ [*p, 1.0])[:3], q)
    np.testing.assert_allclose(J, np.concatenate([R.T @ v, R.T @ turning(arm, of, q)]), atol=1e-8)


def test_points_and_configurations_broadcast():
    arm = load_arm("puma560")
    q, p = np.random.default_rng(0).normal(size=(5, 6)), np.random.default_rng(1).normal(size=(4, 1, 3))
    J = point_jacobian(arm, q, p)
    assert J.shape == (4, 5, 6, 6)
    np.testing.assert_allclose(J[2, 3], point_jacobian(arm, q[3], p[2, 0]), atol=1e-12)
    with pytest.raises(ShapeError, match="point has shape"):
        point_jacobian(arm, q, [1.0, 2.0])
    with pytest.raises(NotFinite, match="point"):
        point_jacobian(arm, q, [1.0, 2.0, np.nan])
    with pytest.raises(UnknownName, match="frame"):
        arm.jacobian(q, of="elbow")
    with pytest.raises(UnknownName, match="own"):
        arm.jacobian(q, "elsewhere")


def test_limits_are_set_and_scaled():
    arm = load_arm("puma560")
    free = Arm(
        dataclasses.replace(
            arm.model, joints=tuple(dataclasses.replace(j, limits=JointLimits()) for j in arm.model.joints)
        )
    )
    accelerations = np.arange(1.0, 7.0)
    found = free.with_limits(
        accelerations=accelerations, speeds=2.0, lower=-1.0, upper=[1, 1, 1, 1, 1, 2.5], torques=9.0
    )
    np.testing.assert_array_equal(found.limits.acceleration, accelerations)
    np.testing.assert_array_equal(found.limits.speed, 2.0)
    np.testing.assert_array_equal(found.limits.upper, [1, 1, 1, 1, 1, 2.5])
    np.testing.assert_array_equal(found.with_limits(acceleration=0.5).limits.acceleration, 0.5 * accelerations)
    np.testing.assert_array_equal(free.limits.acceleration, np.inf)
    for wrong, error, message in (
        (
            {"acceleration": 0.5},
            InputError,
            r"acceleration = 0\.5 is to scale limits that are not stated.*accelerations=",
        ),
        ({"speed": 0.0}, InputError, "speed is 0.0; one positive factor"),
        ({"speed": np.array([0.5])}, InputError, r"speed is array\(\[0.5\]\); one positive factor .*; speeds= takes"),
        (
            {"acceleration": [0.5] * 6},
            InputError,
            r"acceleration is \[.*; one positive .*; accelerations= takes",
        ),
        ({"speed": "half"}, ShapeError, "speed holds something that is not a number"),
        ({"accelerations": [1.0, 2.0]}, ShapeError, "accelerations must be one number or 6"),
        ({"accelerations": -1.0}, InputError, "accelerations must be positive"),
        ({"lower": 2.0, "upper": 1.0}, InputError, r"would have limits 2 \.\. 1"),
        ({"jerks": 1.0}, UnknownName, "no limit 'jerks'"),
    ):
        with pytest.raises(error, match=message):
            free.with_limits(**wrong)

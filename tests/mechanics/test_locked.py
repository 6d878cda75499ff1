"""All solutions with one joint locked: offset wrists, and seven joints over the angle of one of them."""

import numpy as np
import pytest

from holonom.errors import InputError, ShapeError
from holonom.mechanics import IkStatus, all_solutions, arm_from_dh, load_arm, swivel_solutions
from holonom.mechanics.numerical_inverse import solve_inverse
from holonom.model import DHRow

QUARTER = np.pi / 2


def crx():
    """Fanuc CRX-10iA/L, lengths of the maker's drawing: 5 meets 4 and 6 in two points, 150 mm apart."""
    rows = [
        DHRow(alpha=-QUARTER), DHRow(a=0.71, alpha=np.pi), DHRow(alpha=-QUARTER),
        DHRow(alpha=QUARTER, d=-0.54), DHRow(alpha=-QUARTER, d=0.15), DHRow(alpha=np.pi, d=-0.16),
    ]  # fmt: skip
    return arm_from_dh(rows, convention="standard", name="crx")


def xarm6():
    """UFACTORY xArm6: axes 5 and 6 are 76 mm apart."""
    rows = [
        DHRow(alpha=-QUARTER, d=0.267), DHRow(a=0.28949), DHRow(a=0.0775, alpha=-QUARTER),
        DHRow(alpha=QUARTER, d=0.3425), DHRow(a=0.076, alpha=-QUARTER), DHRow(d=0.097),
    ]  # fmt: skip
    return arm_from_dh(rows, convention="standard", name="xarm6")


def apart(q, other):
    """Largest difference of a joint, whole turns aside."""
    return np.abs(np.angle(np.exp(1j * (q - other)))).max(-1)


@pytest.mark.parametrize("make", [crx, xarm6])
def test_every_solution_of_an_offset_wrist_is_found(make):
    """Those that a search from 150 places finds are all among them."""
    arm, rng = make(), np.random.default_rng(0)
    assert arm.closed_form is None
    counts = []
    for _ in range(6):
        q = rng.uniform(-3.0, 3.0, 6)
        T = arm.fk(q)
        found = all_solutions(arm, T)
        counts.append(len(found))
        assert apart(found, q).min() < 1e-6
        np.testing.assert_allclose(arm.fk(found), np.broadcast_to(T, (len(found), 4, 4)), atol=1e-8)
        assert all(apart(one, np.delete(found, k, 0)).min() > 1e-6 for k, one in enumerate(found))
        starts = rng.uniform(-np.pi, np.pi, (150, 6))
        searched = solve_inverse(arm, np.tile(T, (150, 1, 1)), starts, limits=False, restarts=0, tolerance=1e-11)
        for one in searched.q[searched.status == 0]:
            assert apart(found, one).min() < 1e-5
    assert max(counts) >= 8


def test_a_pose_out_of_reach_has_no_solution():
    T = np.eye(4)
    T[0, 3] = 5.0
    assert all_solutions(xarm6(), T).shape == (0, 6)


def test_seven_joints_over_the_angle_of_the_last():
    arm, rng = load_arm("panda"), np.random.default_rng(1)
    for _ in range(10):
        q = rng.uniform(arm.limits.lower, arm.limits.upper)
        T = arm.fk(q)
        angles = np.array([q[6], -1.0, 0.4])
        found = swivel_solutions(arm, T, angles)
        assert found.q.shape == (3, 8, 7)
        np.testing.assert_array_equal(found.q[..., 6], np.repeat(angles[:, None], 8, axis=1))
        assert apart(found.q[0], q).min() < 1e-6
        reached = found.status != IkStatus.UNREACHABLE
        assert np.abs(arm.fk(found.q) - T).max((-1, -2))[reached].max() < 1e-8


def test_what_cannot_be_locked_is_named():
    with pytest.raises(InputError, match="no chain of 6 joints; it has 7"):
        all_solutions(load_arm("panda"), np.eye(4))
    with pytest.raises(InputError, match="no chain of 7 joints; it has 6"):
        swivel_solutions(load_arm("ur5e"), np.eye(4), [0.0])
    with pytest.raises(ShapeError, match="one pose"):
        all_solutions(xarm6(), np.array([np.eye(4)]))
    with pytest.raises(ShapeError, match="angles"):
        swivel_solutions(load_arm("panda"), np.eye(4), 0.0)
    with pytest.raises(InputError, match="samples is 3"):
        all_solutions(xarm6(), np.eye(4), samples=3)
    rng = np.random.default_rng(2)
    rows = [DHRow(*rng.uniform(0.2, 1.0, 4)) for _ in range(6)]
    with pytest.raises(InputError, match="no closed form with its last or first joint locked"):
        all_solutions(arm_from_dh(rows, convention="standard"), np.eye(4))

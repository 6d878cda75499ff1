"""Poses: what is one, what is not, and the inverse."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holonom.errors import NotAPose
from holonom.spatial import check_pose, inverse, pose


def some(n: int) -> np.ndarray:
    rng = np.random.default_rng(2)
    turns = Rotation.random(n, rng=rng).as_matrix()
    return np.stack([pose(p, R) for p, R in zip(rng.normal(size=(n, 3)), turns, strict=True)])


def test_inverse_undoes():
    T = some(20).reshape(4, 5, 4, 4)
    np.testing.assert_allclose(inverse(T) @ T, np.broadcast_to(np.eye(4), T.shape), atol=1e-14)
    np.testing.assert_allclose(inverse(inverse(T)), T, atol=1e-14)


def test_poses_pass():
    T = some(20)
    assert check_pose(T) is T
    assert check_pose(np.eye(4).tolist()).shape == (4, 4)
    assert check_pose(np.empty((0, 4, 4))).shape == (0, 4, 4)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda T: T[..., :3, :], "shape"),
        (lambda T: T * np.nan, "NaN"),
        (lambda T: T @ np.diag([1.0, 1.0, -1.0, 1.0]), "mirror"),
        (lambda T: T @ np.diag([1.0, 1.0, 1.001, 1.0]), "no rotation"),
        (lambda T: T + np.eye(4)[3][:, None] * 0.1, "last row"),
        (lambda T: [["x"] * 4] * 4, "not a number"),
    ],
)
def test_what_is_no_pose_is_said(spoil, says):
    with pytest.raises(NotAPose, match=says):
        check_pose(spoil(some(3)), "T_wt")


@pytest.mark.parametrize("k", [0, 1, 2])
def test_each_row_counts(k):
    T = some(5)
    T[3, k, :3] *= 1.0 + 1e-5
    with pytest.raises(NotAPose, match=r"in pose \(3,\); orthonormalise it"):
        check_pose(T)


@pytest.mark.parametrize(
    "spoil", [np.diag([1, 1, -1, 1]), np.diag([1, 1, 1, 2]), np.diag([np.nan, 1, 1, 1]), np.eye(4) * 2]
)
def test_of_several_the_first_that_is_none_is_named(spoil):
    T = some(30).reshape(2, 5, 3, 4, 4)
    T[1, 2, 1:] = T[1, 2, 1:] @ spoil
    with pytest.raises(NotAPose, match=r"in pose \(1, 2, 1\)"):
        check_pose(T)
    with pytest.raises(NotAPose) as caught:
        check_pose(T[1, 2, 1])
    assert "in pose" not in str(caught.value)

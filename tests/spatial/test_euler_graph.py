"""Euler angles in both branches, transformation graphs."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from holonom.errors import ModelError, NotAPose, UnknownName
from holonom.spatial import PoseGraph, inverse, pose, rpy_angles, zyz_angles


@pytest.mark.parametrize(("angles", "order"), [(zyz_angles, "ZYZ"), (rpy_angles, "xyz")])
def test_both_branches_give_the_rotation(angles, order):
    for R in Rotation.random(200, rng=np.random.default_rng(1)):
        found = angles(R.as_matrix())
        assert not found.degenerate
        for branch in found.angles:
            np.testing.assert_allclose(Rotation.from_euler(order, branch).as_matrix(), R.as_matrix(), atol=1e-12)
        assert not np.allclose(found.angles[0], found.angles[1])


@pytest.mark.parametrize(
    ("angles", "order", "middle"),
    [
        (zyz_angles, "ZYZ", 0.0),
        (zyz_angles, "ZYZ", np.pi),
        (rpy_angles, "xyz", np.pi / 2),
        (rpy_angles, "xyz", -np.pi / 2),
    ],
)
def test_the_degenerate_case_is_said(angles, order, middle):
    R = Rotation.from_euler(order, [0.4, middle, -0.9]).as_matrix()
    found = angles(R)
    assert found.degenerate
    assert found.angles[0, 2] == 0.0
    np.testing.assert_allclose(Rotation.from_euler(order, found.angles[0]).as_matrix(), R, atol=1e-9)


def test_no_rotation_is_refused():
    with pytest.raises(NotAPose):
        zyz_angles(2 * np.eye(3))


def some(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return pose(rng.normal(size=3), Rotation.random(rng=rng).as_matrix())


def test_graph_multiplies_along_the_chain_and_solves_any_edge():
    wb, b0, n0, nt = some(1), some(2), some(3), some(4)
    graph = PoseGraph({("w", "b"): wb, ("b", "0"): b0, ("n", "0"): n0, ("n", "t"): nt})
    wt = wb @ b0 @ inverse(n0) @ nt
    np.testing.assert_allclose(graph.between("w", "t"), wt, atol=1e-12)
    np.testing.assert_allclose(graph.between("t", "w"), inverse(wt), atol=1e-12)
    rest = PoseGraph({("w", "w2"): np.eye(4), ("b", "0"): b0, ("n", "0"): n0, ("n", "t"): nt})
    np.testing.assert_allclose(rest.solve("w", "b", "w", "t", wt), wb, atol=1e-12)
    bare = PoseGraph({("b", "0"): b0, ("n", "0"): n0, ("n", "t"): nt})
    np.testing.assert_allclose(bare.solve("w", "b", "w", "t", wt), wb, atol=1e-12)
    with pytest.raises(ModelError, match="no chain"):
        rest.between("w", "t")
    with pytest.raises(UnknownName, match="frame 'x'"):
        rest.between("w", "x")

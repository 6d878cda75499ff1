"""Laws of SE(2), and arcs against numerical integration."""

import numpy as np
import pytest
from bases import presets
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from holonom.errors import ShapeError
from holonom.mobile.poses import (
    compose,
    exponential,
    integrated,
    inverse,
    logarithm,
    moved,
    relative,
    twist_at,
    twist_in_robot,
    twist_in_world,
    wrapped,
)

poses = st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-9, 9)).map(np.array)
motions = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3.1, 3.1)).map(np.array)


def matrix(pose):
    T = np.eye(3)
    T[:2, :2] = Rotation.from_euler("z", pose[2]).as_matrix()[:2, :2]
    T[:2, 2] = pose[:2]
    return T


@given(motions)
def test_exponential_is_the_matrix_exponential(xi):
    generator = np.array([[0.0, -xi[2], xi[0]], [xi[2], 0.0, xi[1]], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(matrix(exponential(xi)), expm(generator), atol=1e-12)
    np.testing.assert_allclose(logarithm(exponential(xi)), xi, atol=1e-11)


@pytest.mark.parametrize("w", [0.0, 1e-300, 1e-20, -1e-12, 1e-8, 1e-5, -1e-3])
def test_small_turns_lose_no_digit(w):
    x, y, theta = exponential([1.0, 0.0, w])
    series = [1.0 - w**2 / 6.0 + w**4 / 120.0, w / 2.0 - w**3 / 24.0 + w**5 / 720.0]
    np.testing.assert_allclose([x, y], series, rtol=1e-15)
    assert theta == w
    np.testing.assert_allclose(logarithm([x, y, theta]), [1.0, 0.0, w], rtol=1e-15, atol=1e-30)


@given(poses, poses, poses)
def test_poses_form_a_group(a, b, c):
    np.testing.assert_allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-11)
    np.testing.assert_allclose(compose(compose(a, b), c), compose(a, compose(b, c)), atol=1e-10)
    np.testing.assert_allclose(compose(a, inverse(a)), 0.0, atol=1e-10)
    np.testing.assert_allclose(relative(a, b), compose(inverse(a), b), atol=1e-10)
    np.testing.assert_allclose(compose(a, relative(a, b)), b, atol=1e-10)


@given(poses, st.integers(0, 1000))
def test_integration_is_the_product_of_arcs(start, seed):
    rng = np.random.default_rng(seed)
    twists, dt = rng.normal(size=(7, 3)), rng.uniform(0.01, 0.5, 7)
    expected = [start]
    for v, t in zip(twists, dt, strict=True):
        expected.append(moved(expected[-1], v, t))
    np.testing.assert_allclose(integrated(start, twists, dt), expected, atol=1e-11)


def test_batches_of_paths():
    rng = np.random.default_rng(2)
    start, twists = rng.normal(size=(4, 3)), rng.normal(size=(4, 9, 3))
    path = integrated(start, twists, 0.1)
    assert path.shape == (4, 10, 3)
    np.testing.assert_allclose(path[2], integrated(start[2], twists[2], 0.1), atol=1e-13)
    assert integrated([0, 0, 0], np.empty((0, 3)), 0.1).shape == (1, 3)
    assert moved(start, twists[:, 0], np.full(4, 0.2)).shape == (4, 3)
    with pytest.raises(ShapeError, match="one row per step"):
        integrated([0, 0, 0], [1.0, 0.0, 0.0], 0.1)
    with pytest.raises(ShapeError, match="one per twist"):
        integrated([0, 0, 0], np.zeros((3, 3)), [0.1, 0.2])
    with pytest.raises(ShapeError, match="dt holds nan"):
        moved([0, 0, 0], [1.0, 0.0, 0.0], np.nan)
    with pytest.raises(ShapeError, match="heading holds inf"):
        twist_in_robot([1.0, 0.0, 0.0], np.inf)
    with pytest.raises(ShapeError, match=r"motion\[2\] is nan"):
        exponential([0.0, 0.0, np.nan])


@pytest.mark.parametrize("name", ["unequal", "mecanum"])
def test_wheels_drive_an_arc(name):
    """Forward model and exact arc together against many small steps of the world rates."""
    base = presets()[name]
    speeds = 4.0 + np.arange(len(base.driven))
    v = base.twist(speeds)
    n, first = 20000, np.array([0.3, -0.2, 0.7])
    middle = first[2] + v[2] * 2.0 * (np.arange(n) + 0.5) / n
    pose = first + twist_in_world(v, middle).sum(axis=0) * 2.0 / n
    np.testing.assert_allclose(moved(first, v, 2.0), pose, atol=1e-8)


def test_a_robot_heading_north_that_moves_north_moves_forwards():
    np.testing.assert_allclose(twist_in_robot([0.0, 1.0, 0.2], np.pi / 2), [1.0, 0.0, 0.2], atol=1e-15)
    np.testing.assert_allclose(twist_in_world([1.0, 0.0, 0.2], np.pi / 2), [0.0, 1.0, 0.2], atol=1e-15)
    many = twist_in_robot([0.0, 1.0, 0.2], [0.0, np.pi / 2])
    np.testing.assert_allclose(many, [[0.0, 1.0, 0.2], [1.0, 0.0, 0.2]], atol=1e-15)


@given(st.floats(-50, 50))
def test_wrapped_angles(angle):
    found = float(wrapped(angle))
    assert -np.pi < found <= np.pi
    np.testing.assert_allclose(np.exp(1j * found), np.exp(1j * angle), atol=1e-13)
    assert wrapped(np.pi) == np.pi
    assert wrapped(-np.pi) == np.pi


@given(seed=st.integers(0, 2**32 - 1))
def test_twist_of_another_point(seed):
    """By small motions of the body; there and back; the centre of rotation stands still."""
    rng = np.random.default_rng(seed)
    twist, point = rng.normal(size=3), rng.normal(size=2)
    found = twist_at(twist, point)
    dt = 1e-7
    x, y, turn = moved(np.zeros(3), twist, dt)
    c, s = np.cos(turn), np.sin(turn)
    there = np.array([x + c * point[0] - s * point[1], y + s * point[0] + c * point[1]])
    assert np.allclose((there - point) / dt, found[:2], atol=1e-5)
    assert found[2] == twist[2]
    assert np.allclose(twist_at(found, -point), twist)
    centre = np.array([-twist[1], twist[0]]) / twist[2]
    assert np.allclose(twist_at(twist, centre)[:2], 0.0, atol=1e-9)
    assert twist_at(np.zeros((4, 3)), point).shape == (4, 3)

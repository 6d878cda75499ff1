"""The table camera: exactness, round trips, outliers, and every way in which points can fail."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from holonom.errors import CalibrationError, ShapeError
from holonom.vision import fit_homography, to_pixel, to_table

SQUARE = np.array([[40.0, 30.0], [350.0, 45.0], [330.0, 280.0], [25.0, 260.0]])
TRUE = np.array([[5e-4, 3e-5, 0.31], [-2e-5, -5e-4, 0.12], [1e-4, 2e-4, 1.0]])


def through(matrix, points):
    image = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return image[:, :2] / image[:, 2:]


def grid(columns=5, rows=4):
    u, v = np.meshgrid(np.linspace(20, 360, columns), np.linspace(15, 285, rows))
    return np.column_stack([u.ravel(), v.ravel()])


def test_four_points_are_met_exactly_and_give_the_true_camera():
    camera = fit_homography(SQUARE, through(TRUE, SQUARE))
    assert camera.residual_mm.max() < 1e-9
    assert camera.inliers.all()
    np.testing.assert_allclose(to_table(camera, grid()), through(TRUE, grid()), atol=1e-12)


def test_half_a_millimetre_per_pixel():
    camera = fit_homography(SQUARE, SQUARE * [5e-4, -5e-4])
    np.testing.assert_allclose(to_table(camera, [100.0, 200.0]), [0.05, -0.1], atol=1e-12)


@settings(max_examples=30, deadline=None)
@given(turn=st.floats(0.0, 2.0 * np.pi), scale=st.floats(1e-4, 1e-2), tilt=st.floats(-5e-4, 5e-4), mirror=st.booleans())
def test_pixels_to_table_and_back(turn, scale, tilt, mirror):
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    matrix = np.array([[c, -s, 0.4], [s, c, -0.2], [tilt, -0.5 * tilt, 1.0]]) @ np.diag(
        [1.0, -1.0 if mirror else 1.0, 1.0]
    )
    camera = fit_homography(SQUARE, through(matrix, SQUARE))
    points = grid().reshape(4, 5, 2)
    np.testing.assert_allclose(to_pixel(camera, to_table(camera, points)), points, atol=1e-7)


def test_opencv_draws_the_same_camera_from_four_points():
    target = through(TRUE, SQUARE)
    peer = cv2.getPerspectiveTransform(SQUARE.astype(np.float32), target.astype(np.float32))
    camera = fit_homography(SQUARE, target)
    np.testing.assert_allclose(camera.matrix / camera.matrix[2, 2], peer / peer[2, 2], rtol=1e-3, atol=1e-6)


def test_the_fit_of_many_points_is_a_minimum_of_the_squared_distances():
    rng = np.random.default_rng(3)
    pixels = grid()
    table = through(TRUE, pixels) + rng.normal(0.0, 2e-4, pixels.shape)
    camera = fit_homography(pixels, table)
    assert camera.inliers.all()
    least = np.sum(camera.residual_mm**2)
    for entry in range(8):
        for sign in (-1.0, 1.0):
            other = camera.matrix.copy()
            other.flat[entry] *= 1.0 + sign * 1e-4
            assert np.sum((1e3 * (through(other, pixels) - table)) ** 2) > least


def test_residuals_are_millimetres_on_the_table_and_average_out():
    rng = np.random.default_rng(4)
    pixels = grid(8, 6)
    table = through(TRUE, pixels) + rng.normal(0.0, 3e-4, pixels.shape)
    camera = fit_homography(pixels, table)
    np.testing.assert_allclose(
        camera.residual_mm, 1e3 * np.linalg.norm(through(camera.matrix, pixels) - table, axis=1), atol=1e-9
    )
    assert 0.25 < np.sqrt(np.mean(camera.residual_mm**2) / 2.0) < 0.35
    assert np.abs(to_table(camera, pixels) - through(TRUE, pixels)).max() < 3.5e-4


@pytest.mark.parametrize("seed", range(6))
def test_one_point_in_five_is_wrong_and_found(seed):
    rng = np.random.default_rng(seed)
    pixels = grid()
    table = through(TRUE, pixels) + rng.normal(0.0, 1e-4, pixels.shape)
    wrong = rng.choice(len(pixels), 4, replace=False)
    angle = rng.uniform(0.0, 2.0 * np.pi, 4)
    table[wrong] += rng.uniform(0.01, 0.08, (4, 1)) * np.column_stack([np.cos(angle), np.sin(angle)])
    camera = fit_homography(pixels, table)
    assert set(np.flatnonzero(~camera.inliers)) == set(wrong)
    assert np.abs(to_table(camera, pixels) - through(TRUE, pixels)).max() < 3e-4
    again = fit_homography(pixels, table)
    assert np.array_equal(camera.matrix, again.matrix)


def test_six_points_tell_one_outlier_five_do_not():
    pixels = np.vstack([SQUARE, [[180.0, 140.0], [100.0, 220.0]]])
    table = through(TRUE, pixels)
    table[4] += 0.03
    assert fit_homography(pixels, table).inliers.tolist() == [True, True, True, True, False, True]
    with pytest.raises(CalibrationError, match="contradict"):
        fit_homography(pixels[:5], table[:5])


LINE = np.array([[10.0, 10.0], [60.0, 35.0], [110.0, 60.0], [210.0, 110.0], [310.0, 160.0]])
OFF = np.array([[40.0, 250.0]])


@pytest.mark.parametrize(
    "pixels",
    [LINE[:4], LINE, np.vstack([LINE[:3], OFF]), np.vstack([LINE, OFF])],
    ids=["four on a line", "five on a line", "three of four on a line", "all but one on a line"],
)
def test_points_on_a_line_are_refused(pixels):
    with pytest.raises(CalibrationError, match="on a line"):
        fit_homography(pixels, pixels * 5e-4)
    nearly = pixels + np.random.default_rng(0).normal(0.0, 1e-3, pixels.shape)
    with pytest.raises(CalibrationError, match="on a line"):
        fit_homography(nearly, pixels * 5e-4)


def test_points_on_a_line_on_one_side_only_are_refused():
    line = np.vstack([LINE[:3], OFF])
    with pytest.raises(CalibrationError):
        fit_homography(line, SQUARE * 5e-4)
    with pytest.raises(CalibrationError):
        fit_homography(SQUARE, line * 5e-4)


@pytest.mark.parametrize("count", [0, 1, 3])
def test_fewer_than_four_points_are_refused(count):
    with pytest.raises(CalibrationError, match="four or more"):
        fit_homography(SQUARE[:count], SQUARE[:count] * 5e-4)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("side", [0, 1])
def test_what_is_no_number_is_refused(bad, side):
    points = [SQUARE.copy(), SQUARE * 5e-4]
    points[side][2, 1] = bad
    with pytest.raises(CalibrationError, match="number 3"):
        fit_homography(*points)


@pytest.mark.parametrize("side", [0, 1])
def test_a_point_given_twice_is_refused(side):
    pixels = np.vstack([SQUARE, [[180.0, 140.0]]])
    points = [pixels.copy(), pixels * 5e-4]
    points[side][4] = points[side][1]
    with pytest.raises(CalibrationError, match="numbers 2 and 5"):
        fit_homography(*points)
    with pytest.raises(CalibrationError, match="both"):
        fit_homography(np.ones((4, 2)), SQUARE)


def test_points_that_contradict_each_other_are_refused():
    rng = np.random.default_rng(5)
    pixels = grid(4, 3)
    with pytest.raises(CalibrationError, match="contradict"):
        fit_homography(pixels, rng.uniform(-0.1, 0.1, pixels.shape))


def test_two_points_exchanged_are_refused():
    with pytest.raises(CalibrationError, match="same order"):
        fit_homography(SQUARE, SQUARE[[1, 0, 2, 3]] * 5e-4)


def test_shapes_counts_and_tolerance_are_checked():
    with pytest.raises(CalibrationError, match=r"\(k, 2\)"):
        fit_homography(np.ones((4, 3)), SQUARE)
    with pytest.raises(CalibrationError, match="4 pixels for 5"):
        fit_homography(SQUARE, grid()[:5])
    with pytest.raises(CalibrationError, match="tolerance_mm"):
        fit_homography(SQUARE, SQUARE, tolerance_mm=0.0)
    camera = fit_homography(SQUARE, SQUARE * 5e-4)
    for verb in (to_table, to_pixel):
        with pytest.raises(ShapeError, match=r"\(\.\.\., 2\)"):
            verb(camera, [1.0, 2.0, 3.0])


def test_beyond_the_horizon_there_is_no_table():
    tilted = np.array([[5e-4, 0.0, 0.0], [0.0, 5e-4, 0.0], [0.0, -2e-3, 1.0]])
    camera = fit_homography(SQUARE, through(tilted, SQUARE))
    assert np.isfinite(to_table(camera, [100.0, 499.0])).all()
    assert np.isnan(to_table(camera, [[100.0, 501.0], [100.0, 900.0]])).all()

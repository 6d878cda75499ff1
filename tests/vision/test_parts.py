"""Parts on the table and photographs from files."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from coin_views import PHOTOGRAPH, through

from holonom.errors import CalibrationError, ImageError, NotAPose
from holonom.vision import Disc, TablePart, fit_homography, in_robot_frame, load_photograph, measure

SQUARE = np.array([[0.0, 0.0], [400.0, 0.0], [400.0, 300.0], [0.0, 300.0]])


def circle(u, v, radius, n=720):
    angle = np.arange(n) * 2.0 * np.pi / n
    return np.column_stack([u + radius * np.cos(angle), v + radius * np.sin(angle)])


def disc_of(contour):
    return Disc(*contour.mean(axis=0), float("nan"), float("nan"), contour)


def test_a_circle_on_the_table_is_measured_as_itself_through_any_camera():
    matrix = np.array([[4e-4, 1e-4, 0.2], [2e-5, -5e-4, 0.3], [3e-4, -5e-4, 1.0]])  # pixel -> table
    camera = fit_homography(SQUARE, through(matrix, SQUARE))
    seen = through(np.linalg.inv(matrix), circle(0.25, 0.2, 0.02))
    (part,) = measure(camera, [disc_of(seen)])
    assert (part.x, part.y) == pytest.approx((0.25, 0.2), abs=1e-9)
    assert part.diameter == pytest.approx(0.04, rel=1e-4)
    assert part.area == pytest.approx(np.pi * 0.02**2, rel=1e-4)


def test_parts_keep_the_order_of_the_discs():
    camera = fit_homography(SQUARE, SQUARE * 5e-4)
    parts = measure(camera, [disc_of(circle(300, 200, 20)), disc_of(circle(100, 50, 30))])
    assert [round(p.x, 6) for p in parts] == [0.15, 0.05]
    assert [round(p.diameter, 4) for p in parts] == [0.02, 0.03]


def test_a_disc_at_the_horizon_is_refused():
    tilted = np.array([[5e-4, 0.0, 0.0], [0.0, 5e-4, 0.0], [0.0, -2e-3, 1.0]])
    camera = fit_homography(SQUARE, through(tilted, SQUARE))
    with pytest.raises(CalibrationError, match="horizon"):
        measure(camera, [disc_of(circle(200, 495, 20))])


def test_table_to_robot_frame():
    turn = np.array([[0.0, -1.0, 0.0, 0.5], [1.0, 0.0, 0.0, -0.1], [0.0, 0.0, 1.0, 0.3], [0.0, 0.0, 0.0, 1.0]])
    parts = [TablePart(0.1, 0.2, 1e-3, 0.02), TablePart(0.0, 0.0, 1e-3, 0.02)]
    np.testing.assert_allclose(in_robot_frame(parts, turn), [[0.3, 0.0, 0.3], [0.5, -0.1, 0.3]], atol=1e-15)
    assert in_robot_frame([], turn).shape == (0, 3)
    with pytest.raises(NotAPose):
        in_robot_frame(parts, np.diag([1.0, 1.0, -1.0, 1.0]))


def test_the_photograph_is_read_as_grey_levels():
    image = load_photograph(PHOTOGRAPH)
    assert image.shape == (303, 384)
    assert image.dtype == np.uint8


def test_a_colour_image_becomes_grey(tmp_path):
    cv2.imwrite(str(tmp_path / "c.png"), np.full((40, 50, 3), (10, 20, 30), np.uint8))
    assert load_photograph(tmp_path / "c.png").shape == (40, 50)


def test_files_that_are_no_photograph_are_refused(tmp_path):
    with pytest.raises(ImageError, match="No such file"):
        load_photograph(tmp_path / "none.png")
    with pytest.raises(ImageError, match="directory"):
        load_photograph(tmp_path)
    for name, data in {"text.png": b"not an image", "empty.png": b""}.items():
        (tmp_path / name).write_bytes(data)
        with pytest.raises(ImageError, match="not an image"):
            load_photograph(tmp_path / name)
    cv2.imwrite(str(tmp_path / "small.png"), np.zeros((20, 50), np.uint8))
    with pytest.raises(ImageError, match="50 x 20 pixels"):
        load_photograph(tmp_path / "small.png")


def test_a_truncated_photograph_is_refused(tmp_path):
    (tmp_path / "cut.png").write_bytes(PHOTOGRAPH.read_bytes()[:200])
    with pytest.raises(ImageError, match="not an image"):
        load_photograph(tmp_path / "cut.png")

"""Outlines of shapes whose border is known exactly."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from holonom.vision.kernels import closed_path
from holonom.vision.outline import polygon_moments, trace_outlines

V, U = np.mgrid[:120, :120].astype(float)


def soft_ellipse(u, v, a, b):
    """Relief 1 inside, 0 outside; the steepest fall is on the ellipse."""
    distance = (np.hypot((U - u) / a, (V - v) / b) - 1.0) * np.sqrt(a * b)
    return (1.0 / (1.0 + np.exp(distance / 0.5))).astype(np.float32)


@pytest.mark.parametrize("centre", [(60.0, 60.0), (57.37, 62.81)])
@pytest.mark.parametrize("half_axes", [(30.0, 30.0), (40.3, 40.3), (33.0, 28.0)])
def test_the_border_is_found_to_a_small_part_of_a_pixel(centre, half_axes):
    relief = soft_ellipse(*centre, *half_axes)
    seed = np.array([[60.0, 60.0]]), np.array([32.0])
    points, fall = trace_outlines(relief, np.ones(relief.shape, bool), *seed)
    off = (np.hypot(*((points[0] - centre) / half_axes).T) - 1.0) * np.sqrt(np.prod(half_axes))
    assert np.abs(off).max() < 0.12
    assert np.sqrt(np.mean(off**2)) < 0.05
    assert fall.min() > 0.75


def test_the_border_of_the_photograph_is_no_edge():
    relief = soft_ellipse(60.0, 60.0, 30.0, 30.0)
    region = U < 88.0  # cuts 2 pixels off on the right
    relief[~region] = -5.0
    points, fall = trace_outlines(relief, region, np.array([[60.0, 60.0]]), np.array([30.0]))
    radius = np.hypot(*(points[0] - 60.0).T)
    kept = points[0, :, 0] < 80.0
    cut = (points[0, :, 0] > 80.0) & (np.abs(points[0, :, 1] - 60.0) < 7.0)
    assert cut.sum() >= 5
    assert fall[0, cut].max() < 0.2
    assert np.abs(radius[kept] - 30.0).max() < 0.2
    assert fall[0, kept].min() > 0.75


def test_moments_agree_with_opencv():
    rng = np.random.default_rng(2)
    angle = np.arange(50) * 2.0 * np.pi / 50
    points = 40.0 + rng.uniform(10.0, 30.0, (3, 50, 1)) * np.stack([np.cos(angle), np.sin(angle)], -1)
    area, centre, perimeter = polygon_moments(points)
    for k in range(3):
        contour = points[k].astype(np.float32)
        moments = cv2.moments(contour)
        assert area[k] == pytest.approx(moments["m00"], rel=1e-5)
        assert centre[k] == pytest.approx([moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]], rel=1e-5)
        assert perimeter[k] == pytest.approx(cv2.arcLength(contour, True), rel=1e-5)
        backwards = polygon_moments(points[k : k + 1, ::-1])
        assert backwards[0] == pytest.approx(area[k])
        assert backwards[1][0] == pytest.approx(centre[k])


def best_by_trying_every_start(score, price):
    """Value of the best closed path: one open path for each column that it may start and end in."""
    rows, columns = score.shape
    move = np.abs(np.subtract.outer(np.arange(columns), np.arange(columns)))
    cost = np.where(move < price.size, price[np.minimum(move, price.size - 1)], np.inf)
    best = -np.inf
    for start in range(columns):
        value = np.where(np.arange(columns) == start, score[0], -np.inf)
        for row in range(1, rows):
            value = (value[:, None] - cost).max(axis=0) + score[row]
        best = max(best, (value - cost[:, start]).max())
    return best


@pytest.mark.parametrize("seed", range(5))
def test_the_closed_path_is_the_best_one(seed):
    rng = np.random.default_rng(seed)
    score = rng.uniform(0.0, 0.3, (24, 15)).astype(np.float32)
    ridge = np.round(7 + 3 * np.sin(np.arange(24) * 2 * np.pi / 24 + seed)).astype(int)
    score[np.arange(24), ridge] += 1.0
    price = np.array([0.0, 0.05, 0.2], np.float32)
    path = np.empty(24, np.int64)
    closed_path(score, price, np.empty((2, 15), np.float32), np.empty((48, 15), np.int16), path)
    moves = np.abs(np.diff(path, append=path[0]))
    assert moves.max() <= 2
    value = score[np.arange(24), path].sum() - price[moves].sum()
    assert value == pytest.approx(best_by_trying_every_start(score, price), rel=1e-5)

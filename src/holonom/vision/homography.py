"""The camera over a flat table: pixels to metres and back (specification 08)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from holonom.arrays import Array
from holonom.errors import CalibrationError, ShapeError
from holonom.vision.opencv import cv2

__all__ = ["TableCamera", "fit_homography", "to_pixel", "to_table"]

Mask = NDArray[np.bool_]

RANK = 1e-3  # least relative eighth singular value of the design matrix, over normalised points
FLATTEST = 1e-3  # least relative singular value of the homography, over normalised points
SAME = 1e-6  # points closer than this, in units of their spread, are one
AGREE = 0.6  # least part of the points that must agree with one camera


@dataclass(frozen=True, slots=True, eq=False)
class TableCamera:
    """A camera that sees a plane.

    `matrix` (3, 3) maps pixels (u, v, 1) to table metres (x, y, 1) up to a factor, positive on the seen
    side of the horizon. Per calibration point: `residual_mm` (k,), the distance on the table between
    where it is and where the camera sees it, in millimetres, and `inliers` (k,), whether it was used.
    """

    matrix: Array
    residual_mm: Array
    inliers: Mask


class _Scaled(NamedTuple):
    """Points with mean 0 and mean distance sqrt(2), and the matrix that made them so."""

    points: Array
    matrix: Array


def fit_homography(pixels: ArrayLike, table_m: ArrayLike, *, tolerance_mm: float = 2.0) -> TableCamera:
    """Camera matrix from points seen in an image and measured on the table.

    Four points are met exactly. More go through RANSAC (with a fixed seed, so that the same points give
    the same camera); those within `tolerance_mm` are used in a normalised direct linear transform, refined
    to the least sum of squared distances on the table.

    Parameters
    ----------
    pixels
        Points in the image, (k, 2), k >= 4, pixels right and down.
    table_m
        The same points on the table, (k, 2), metres in the table frame.
    tolerance_mm
        Distance on the table within which a point agrees with the camera, millimetres.

    Returns
    -------
    The camera, with the residual of each point.

    Raises
    ------
    CalibrationError
        If there are fewer than four points, one is not a number or given twice, the points lie on a line
        (or three of four do, or all but one), or they contradict each other.

    Notes
    -----
    Hartley and Zisserman, Multiple View Geometry, 2nd ed., algorithms 4.1, 4.2 and 4.6. Outliers can be told only
    when five points or more agree: any four points fit some camera.
    """
    seen, measured = _points("pixels", pixels), _points("table points", table_m)
    if len(seen) != len(measured):
        raise CalibrationError(f"{len(seen)} pixels for {len(measured)} table points; give each pixel its point")
    if not tolerance_mm > 0.0:
        raise CalibrationError(f"tolerance_mm is {tolerance_mm}; give a distance above 0")
    source, target = _scaled("pixels", seen), _scaled("table points", measured)
    tolerance = 1e-3 * tolerance_mm * target.matrix[0, 0]
    inliers = _agreeing(source.points, target.points, tolerance)
    a, b = source.points[inliers], target.points[inliers]
    scaled = _direct_linear(a, b)
    if len(a) > 4:
        scaled = _refined(scaled, a, b)
    matrix = _oriented(np.linalg.inv(target.matrix) @ scaled @ source.matrix, seen[inliers])
    residual = 1e3 * np.linalg.norm(_project(matrix, seen) - measured, axis=-1)
    return TableCamera(matrix, residual, inliers)


def to_table(camera: TableCamera, pixels: ArrayLike) -> Array:
    """Table points (..., 2), metres, of pixels (..., 2); NaN at and beyond the horizon.

    Raises
    ------
    ShapeError
        If the last axis of `pixels` is not 2.
    """
    return _project(camera.matrix, _pairs("pixels", pixels))


def to_pixel(camera: TableCamera, table_m: ArrayLike) -> Array:
    """Pixels (..., 2) of table points (..., 2) in metres; NaN for points behind the camera.

    Raises
    ------
    ShapeError
        If the last axis of `table_m` is not 2.
    """
    inverse: Array = np.linalg.inv(camera.matrix).astype(np.float64)
    return _project(inverse, _pairs("table points", table_m))


def _project(matrix: Array, points: Array) -> Array:
    image = points @ matrix[:, :2].T + matrix[:, 2]
    weight = image[..., 2:]
    return image[..., :2] / np.where(weight > 0.0, weight, np.nan)


def _pairs(what: str, values: ArrayLike) -> Array:
    points = np.asarray(values, dtype=np.float64)
    if points.ndim == 0 or points.shape[-1] != 2:
        raise ShapeError(f"{what} have shape {points.shape}; (..., 2) is wanted")
    return points


def _points(what: str, values: ArrayLike) -> Array:
    points = np.asarray(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 2:
        raise CalibrationError(f"{what} have shape {points.shape}; (k, 2) with k >= 4 is wanted")
    if len(points) < 4:
        raise CalibrationError(f"{len(points)} {what}; a table camera needs four or more, no three on a line")
    if not np.isfinite(points).all():
        row = int(np.flatnonzero(~np.isfinite(points).all(axis=1))[0])
        raise CalibrationError(f"{what}: number {row + 1} is {points[row].tolist()}; give finite numbers")
    return points


def _scaled(what: str, points: Array) -> _Scaled:
    """Normalised points (algorithm 4.2); raises if two are one."""
    mean = points.mean(axis=0)
    spread = float(np.linalg.norm(points - mean, axis=1).mean())
    distance = np.linalg.norm(points[:, None] - points, axis=-1) + np.where(np.eye(len(points)), np.inf, 0.0)
    first, second = np.unravel_index(int(distance.argmin()), distance.shape)
    if distance[first, second] <= SAME * spread:
        raise CalibrationError(
            f"{what}: numbers {first + 1} and {second + 1} are both {points[first].tolist()}; give each once"
        )
    scale = np.sqrt(2.0) / spread
    matrix = np.array([[scale, 0.0, -scale * mean[0]], [0.0, scale, -scale * mean[1]], [0.0, 0.0, 1.0]])
    return _Scaled((points - mean) * scale, matrix)


def _agreeing(source: Array, target: Array, tolerance: float) -> Mask:
    """Points within `tolerance` of the camera that most of them agree on: all of four, else RANSAC."""
    count = len(source)
    _direct_linear(source, target)
    if count == 4:
        return np.ones(4, dtype=np.bool_)
    _, used = cv2.findHomography(source, target, cv2.RANSAC, tolerance, maxIters=5000, confidence=0.9999)
    inliers: Mask = np.zeros(count, np.bool_) if used is None else used.ravel() > 0
    agree = int(inliers.sum())
    if agree < max(5, AGREE * count):
        raise CalibrationError(
            f"calibration points contradict each other: no more than {agree} of {count} fit one camera; "
            f"{max(5, int(np.ceil(AGREE * count)))} must; measure them again, or allow more than their error"
        )
    return inliers


def _direct_linear(source: Array, target: Array) -> Array:
    """Homography of normalised points by the direct linear transform (4.3); raises if it is not unique."""
    one, none = np.column_stack([source, np.ones(len(source))]), np.zeros((len(source), 3))
    x, y = target[:, :1], target[:, 1:]
    design = np.vstack([np.hstack([one, none, -x * one]), np.hstack([none, one, -y * one])])
    _, singular, right = np.linalg.svd(design)
    matrix = right[-1].reshape(3, 3)
    shape = np.linalg.svd(matrix, compute_uv=False)
    if singular[7] < RANK * singular[0] or shape[2] < FLATTEST * shape[0]:
        raise CalibrationError(
            "calibration points lie on a line, or all but one do, so they do not fix the camera; "
            "give four or more points spread over the table, no three on a line"
        )
    return matrix


def _refined(matrix: Array, source: Array, target: Array) -> Array:
    """Homography with the least sum of squared distances in the target plane (Levenberg-Marquardt)."""
    start = matrix / np.linalg.norm(matrix)
    fixed = int(np.abs(start).argmax())

    def full(free: Array) -> Array:
        return np.insert(free, fixed, start.flat[fixed]).reshape(3, 3)

    def error(free: Array) -> Array:
        image = source @ full(free)[:, :2].T + full(free)[:, 2]
        return (image[:, :2] / image[:, 2:] - target).ravel()

    best = least_squares(error, np.delete(start.ravel(), fixed), method="lm", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    return full(np.asarray(best.x, dtype=np.float64))


def _oriented(matrix: Array, seen: Array) -> Array:
    """The matrix with the sign that puts the points before the horizon, scaled to 1 at their mean."""
    weight = seen @ matrix[2, :2] + matrix[2, 2]
    if weight.min() <= 0.0 <= weight.max():
        raise CalibrationError(
            "the horizon of the camera would cross the calibration points; "
            "check that pixels and table points are given in the same order"
        )
    return matrix / weight.mean()

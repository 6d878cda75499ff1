"""Distances and ray casts: against dense samples of the shapes themselves, and against each other."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.errors import InputError, ModelError
from holonom.geometry import Box, Cylinder, distance, gap, hull, margin, outline, ray_cast

SHAPES = [Box((0.6, 0.3, 1.0)), Cylinder(0.25, 0.8), Box((1.0, 1.0, 0.0))]


def surface(shape, rng, count=60000):
    """Points all over the surface."""
    if isinstance(shape, Box):
        half = 0.5 * np.array(shape.size)
        p = rng.uniform(-1, 1, (count, 3)) * half
        axis = rng.integers(3, size=count)
        p[np.arange(count), axis] = np.sign(rng.normal(size=count)) * half[axis]
        return p
    turn, h = rng.uniform(-np.pi, np.pi, count), 0.5 * shape.height
    radius = np.where(np.arange(count) % 2, shape.radius, shape.radius * np.sqrt(rng.uniform(size=count)))
    z = np.where(np.arange(count) % 2, rng.uniform(-h, h, count), np.sign(rng.normal(size=count)) * h)
    return np.stack([radius * np.cos(turn), radius * np.sin(turn), z], axis=-1)


@pytest.mark.parametrize("shape", SHAPES)
def test_distance_is_that_of_the_nearest_point_of_the_surface(shape):
    rng = np.random.default_rng(0)
    skin = surface(shape, rng)
    points = rng.uniform(-1, 1, (40, 3))
    nearest = np.linalg.norm(points[:, None] - skin, axis=-1).min(1)
    found = distance(shape, points)
    np.testing.assert_allclose(np.abs(found), nearest, atol=0.02)
    assert distance(shape, [0.0, 0.0, 0.0]) <= 0.0


@pytest.mark.parametrize("shape", SHAPES)
def test_rays_end_on_the_surface_and_meet_nothing_before(shape):
    rng = np.random.default_rng(1)
    origins, directions = rng.uniform(-2, 2, (400, 3)), rng.normal(size=(400, 3))
    origins[::7, 2], directions[::5, 0] = 0.0, 0.0  # along a face, straight up and down
    way = ray_cast(shape, origins, directions)
    hit = np.isfinite(way) & (way > 0.0)
    assert 10 < hit.sum() < 390
    ends = origins[hit] + way[hit, None] * directions[hit]
    np.testing.assert_allclose(distance(shape, ends), 0.0, atol=1e-12)
    steps = np.linspace(0.0, 1.0, 200)[:, None]
    for origin, direction, w in zip(origins, directions, way, strict=True):
        reach = min(w, 5.0 / np.linalg.norm(direction))
        before = distance(shape, origin + steps[:-1] * reach * direction)
        assert (before > -1e-9).all() or w == 0.0


def test_from_inside_the_way_is_nothing_and_parallel_rays_miss():
    assert ray_cast(SHAPES[1], [0.1, 0.0, 0.0], [1.0, 0.0, 0.0]) == 0.0
    assert ray_cast(SHAPES[0], [0.0, 0.0, 2.0], [1.0, 0.0, 0.0]) == np.inf
    assert ray_cast(SHAPES[0], [0.0, 0.0, 2.0], [0.0, 0.0, 1.0]) == np.inf
    assert ray_cast(SHAPES[1], [2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]) == pytest.approx(0.875)


def test_polygons():
    square = hull([[1, 1], [-1, 1], [-1, -1], [1, -1], [0.2, 0.3]])
    assert len(square) == 4
    np.testing.assert_allclose(margin(square, [[0.0, 0.0], [0.9, 0.2], [2.0, 0.0]]), [1.0, 0.1, -1.0])
    assert np.linalg.norm(outline(Cylinder(0.4, 0.0)), axis=1) == pytest.approx(0.4)
    with pytest.raises(InputError, match="span no area"):
        hull([[0, 0], [1, 1], [2, 2]])
    with pytest.raises(ModelError, match="finite size"):
        Box((1.0, -1.0, 1.0))


def turned(corners, turn, place):
    c, s = np.cos(turn), np.sin(turn)
    return corners @ np.array([[c, s], [-s, c]]) + place


def test_a_gap_is_that_of_the_nearest_points_of_two_polygons():
    """Against dense samples of both outlines; an overlap is the way out along an edge's normal."""
    rng = np.random.default_rng(2)
    seen = set()
    for _ in range(60):
        shapes = [hull(rng.normal(size=(7, 2)) * 0.4), outline(Box((0.8, 0.3, 1.0)))]
        one, other = (turned(c, rng.uniform(-3, 3), rng.uniform(-0.8, 0.8, 2)) for c in shapes)
        found = gap(one, other)
        assert found == pytest.approx(gap(other, one), abs=1e-12)
        edges = [np.linspace(c, np.roll(c, -1, 0), 80).reshape(-1, 2) for c in (one, other)]
        least = np.linalg.norm(edges[0][:, None] - edges[1], axis=-1).min()
        inside = (margin(one, edges[1]) > 0.0).any() or (margin(other, edges[0]) > 0.0).any()
        seen.add(inside)
        if inside:
            assert found < 0.0
            free = min(
                (
                    gap(one + (found - 1e-9) * d, other)
                    for c in (one, other)
                    for d in np.vstack([normals(c), -normals(c)])
                ),
                key=abs,
            )
            assert free == pytest.approx(0.0, abs=1e-6), "moved out by as much they touch"
        else:
            assert found == pytest.approx(least, abs=0.01)
    assert seen == {True, False}


def normals(corners):
    along = np.roll(corners, -1, axis=0) - corners
    return np.stack([along[:, 1], -along[:, 0]], axis=-1) / np.linalg.norm(along, axis=1, keepdims=True)

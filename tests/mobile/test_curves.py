"""Dubins and Reeds-Shepp curves: they lead there, obey the symmetries; no random way is shorter."""

from __future__ import annotations

import math

import numpy as np
import pytest

from holonom.errors import OutOfLimits, ShapeError
from holonom.mobile.curves import REEDS_SHEPP_WORDS, Curves, dubins, reeds_shepp

RADIUS = 1.7
BOTH = pytest.mark.parametrize("curves", [dubins, reeds_shepp])


def pairs(count: int, size: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    scale = [size, size, math.pi]
    return rng.uniform(-1, 1, (count, 3)) * scale, rng.uniform(-1, 1, (count, 3)) * scale


def missed(curves: Curves, end: np.ndarray) -> float:
    away = curves.end - end
    away[:, 2] = np.arcsin(np.sin(0.5 * away[:, 2]))
    return float(np.abs(away).max())


@BOTH
@pytest.mark.parametrize("size", [0.5, 3.0, 20.0])
def test_they_lead_there(curves, size: float) -> None:
    start, end = pairs(10_000, size)
    found = curves(start, end, RADIUS)
    assert missed(found, end) < 1e-9 * max(size, 1.0)
    assert (found.length >= np.hypot(*(end - start)[:, :2].T) - 1e-9).all()


def driven(rng: np.random.Generator, pieces: int, *, reversing: bool) -> tuple[np.ndarray, np.ndarray]:
    """Ends (N, 3) and lengths (N,) of ways from the origin, in pieces of any kind and length."""
    turn = rng.integers(-1, 2, (4000, pieces)).astype(float)
    length = rng.exponential(0.9, turn.shape)
    sign = rng.choice([-1.0, 1.0], turn.shape) if reversing else np.ones(turn.shape)
    z, theta = np.zeros(len(turn), dtype=complex), np.zeros(len(turn))
    for k in range(pieces):
        go, half = sign[:, k] * length[:, k], 0.5 * turn[:, k] * sign[:, k] * length[:, k]
        z += go * np.sinc(half / np.pi) * np.exp(1j * (theta + half))  # chord of an arc
        theta += 2.0 * half
    return np.column_stack([z.real, z.imag, theta]), length.sum(axis=1)


@pytest.mark.parametrize("pieces", [1, 2, 3, 4, 5])
def test_no_way_driven_at_random_is_shorter(pieces: int) -> None:
    rng = np.random.default_rng(pieces)
    end, length = driven(rng, pieces, reversing=False)
    assert (dubins([0.0, 0.0, 0.0], end, 1.0).length <= length + 1e-6).all()
    end, length = driven(rng, pieces, reversing=True)
    assert (reeds_shepp([0.0, 0.0, 0.0], end, 1.0).length <= length + 1e-6).all()


def test_known_lengths() -> None:
    """By hand: straight on, half a circle, turning round where it stands (three arcs of 60 degrees), back."""
    ends = np.array([[5.0, 0.0, 0.0], [0.0, 2.0, math.pi], [0.0, 0.0, math.pi], [-3.0, 0.0, 0.0]])
    assert reeds_shepp([0, 0, 0], ends, 1.0).length == pytest.approx([5.0, math.pi, math.pi, 3.0])
    assert dubins([0, 0, 0], ends, 1.0).length == pytest.approx([5.0, math.pi, 7.0 * math.pi / 3.0, 2 * math.pi + 3.0])


def test_reversing_never_costs() -> None:
    start, end = pairs(3000, 4.0, 1)
    assert (reeds_shepp(start, end, RADIUS).length <= dubins(start, end, RADIUS).length + 1e-9).all()


@BOTH
def test_symmetries(curves) -> None:
    """Mirrored, and driven from the end to the start with the car turned round (Reeds-Shepp also: simply backwards)."""
    start, end = pairs(2000, 4.0, 2)
    length = curves(start, end, RADIUS).length
    mirror = np.array([1.0, -1.0, -1.0])
    assert curves(start * mirror, end * mirror, RADIUS).length == pytest.approx(length, abs=1e-7)
    about = np.array([0.0, 0.0, math.pi])
    assert curves(end + about, start + about, RADIUS).length == pytest.approx(length, abs=1e-7)
    if curves is reeds_shepp:
        assert curves(end, start, RADIUS).length == pytest.approx(length, abs=1e-7)


def test_many_words_are_shortest_somewhere() -> None:
    found = reeds_shepp(*pairs(30_000, 3.0, 3), 1.0)
    signed = {(w, tuple(np.sign(row[: len(w)]))) for w, row in zip(found.words, found.lengths, strict=True)}
    assert len(signed) >= 40
    assert {word for word, _ in signed} <= set(REEDS_SHEPP_WORDS)
    assert len(REEDS_SHEPP_WORDS) == 44  # four of them, CCC, stand for two signs each


def test_poses_along_a_curve() -> None:
    curve = reeds_shepp([1.0, 2.0, 0.3], [0.5, 2.4, 2.9], RADIUS)
    poses, way = curve.poses(0, 0.01)
    assert poses[0] == pytest.approx([1.0, 2.0, 0.3])
    assert poses[-1, :2] == pytest.approx([0.5, 2.4])
    steps = np.diff(poses, axis=0)
    along = np.hypot(steps[:, 0], steps[:, 1])
    assert along.max() <= 0.01 + 1e-12
    assert along.sum() == pytest.approx(curve.length[0], rel=1e-5)
    assert np.abs(steps[:, 2]).max() <= 0.01 / RADIUS + 1e-12
    middle = poses[:-1, 2] + 0.5 * steps[:, 2]
    ahead = steps[:, 0] * np.cos(middle) + steps[:, 1] * np.sin(middle)
    assert (ahead * way[1:] >= -1e-12).all()  # a cusp stands twice, once for each direction
    assert curve.poses(0, 10.0)[0].shape[0] >= 2
    still = dubins([1.0, 1.0, 0.5], [1.0, 1.0, 0.5], 1.0)
    assert still.length[0] == 0.0
    assert still.poses(0, 0.1)[0] == pytest.approx(np.array([[1.0, 1.0, 0.5]]))


@BOTH
def test_bad_input(curves) -> None:
    with pytest.raises(OutOfLimits, match="radius is 0"):
        curves([0, 0, 0], [1, 0, 0], 0)
    with pytest.raises(OutOfLimits, match="radius"):
        curves([0, 0, 0], [1, 0, 0], math.inf)
    with pytest.raises(ShapeError, match="end"):
        curves([0, 0, 0], [1, 0], 1.0)
    with pytest.raises(OutOfLimits, match="spacing"):
        curves([0, 0, 0], [1, 0, 0], 1.0).poses(0, 0.0)

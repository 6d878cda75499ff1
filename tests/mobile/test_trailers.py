"""Trailers: axles that do not slide, hitches that hold, circles, the tractrix, flatness, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import holonom as hm
from holonom.errors import InputError, OutOfLimits, ShapeError
from holonom.mobile import towed
from holonom.mobile.poses import integrated

LENGTHS, HITCHES = [0.8, 0.5, 0.6], [0.2, 0.0, -0.1]


def wander(rng: np.random.Generator, count: int = 2000, *, aside: float = 0.0) -> np.ndarray:
    t = 0.005 * np.arange(count)
    wave = sum(np.sin(rng.uniform(0.3, 1.5, 3) * t[:, None] + rng.uniform(0, 6, 3)) for _ in range(3)) / 3.0
    return integrated(rng.normal(size=3), wave * [0.3, aside, 0.5] + [0.5, 0.0, 0.0], np.full(count, 0.005))


def unit(heading: np.ndarray) -> np.ndarray:
    return np.stack([np.cos(heading), np.sin(heading)], axis=-1)


@pytest.mark.parametrize("aside", [0.0, 0.2])
def test_no_axle_slides_and_every_hitch_holds(aside: float) -> None:
    base = wander(np.random.default_rng(1), aside=aside)
    found = towed(base, LENGTHS, HITCHES)
    before = base
    for i, (length, hitch) in enumerate(zip(LENGTHS, HITCHES, strict=True)):
        own = found.poses[:, i]
        ends = before[:, :2] - hitch * unit(before[:, 2]), own[:, :2] + length * unit(own[:, 2])
        np.testing.assert_allclose(*ends, atol=1e-12)
        moved, middle = np.diff(own[:, :2], axis=0), 0.5 * (own[1:, 2] + own[:-1, 2])
        across = moved @ [0.0, 1.0] * np.cos(middle) - moved @ [1.0, 0.0] * np.sin(middle)
        assert np.abs(across).max() < 1e-7, "m in 5 ms"
        np.testing.assert_allclose(np.cos(found.angles[:, i]), np.cos(before[:, 2] - own[:, 2]), atol=1e-9)
        before = own


def test_it_agrees_with_an_integration_written_here() -> None:
    """Positions of hitches by rigid bodies, slope of each heading by the hitch's velocity across; SciPy."""
    twist, rng = np.array([0.6, 0.0, 0.4]), np.random.default_rng(2)
    start = rng.uniform(-0.5, 0.5, 3)

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        heading, out = twist[2] * t, []
        axle, turn, before = twist[0] * unit(np.array(heading)), twist[2], heading
        for length, hitch, own in zip(LENGTHS, HITCHES, y, strict=True):
            pulled = axle - hitch * turn * np.array([-np.sin(before), np.cos(before)])
            turn = pulled @ [-np.sin(own), np.cos(own)] / length
            axle, before = unit(own) * (pulled @ unit(own)), own
            out.append(turn)
        return np.array(out)

    told = solve_ivp(rates, (0.0, 6.0), start, rtol=1e-10, atol=1e-12).y[:, -1]
    base = integrated(np.zeros(3), np.tile(twist, (60, 1)), np.full(60, 0.1))
    np.testing.assert_allclose(towed(base, LENGTHS, HITCHES, headings=start).poses[-1, :, 2], told, atol=1e-6)


def test_on_a_circle_axles_settle_on_circles() -> None:
    """Radii by Pythagoras: R_i^2 = R_(i-1)^2 + M_i^2 - L_i^2."""
    base = integrated(np.zeros(3), np.tile([0.5, 0.0, 0.25], (4000, 1)), np.full(4000, 0.02))  # R = 2 m
    found = towed(base, LENGTHS, HITCHES)
    radius = 2.0
    for i, (length, hitch) in enumerate(zip(LENGTHS, HITCHES, strict=True)):
        radius = np.sqrt(radius**2 + hitch**2 - length**2)
        assert np.hypot(*(found.poses[-1, i, :2] - [0.0, 2.0])) == pytest.approx(radius, abs=1e-6)
    assert found.jackknifed is None


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_straight_on_it_is_the_tractrix_and_backwards_it_folds(sense: float) -> None:
    """tan(b/2) changes by exp(-s/L)."""
    s = sense * np.linspace(0.0, 1.6, 200)
    base = np.column_stack([s, np.zeros((200, 2))])
    found = towed(base, [0.5], headings=[-0.15])
    told = 2.0 * np.arctan(np.tan(0.075) * np.exp(-s / 0.5))
    np.testing.assert_allclose(found.angles[:, 0], told, atol=1e-7)
    bent = np.flatnonzero(told >= np.pi / 2)
    assert found.jackknifed == (bent[0] if len(bent) else None)
    assert (found.jackknifed is None) == (sense > 0.0)


def test_the_last_axle_tells_all() -> None:
    """Flatness (Rouchon et al. 1993): every pose before follows from the last axle's path by derivatives."""
    s = np.linspace(0.0, 6.0, 6001)
    axle = np.stack([s, 0.3 * np.sin(0.9 * s)], axis=-1)
    headings = []
    for length in reversed(LENGTHS):
        slope = np.gradient(axle, s, axis=0, edge_order=2)
        headings.insert(0, np.unwrap(np.arctan2(slope[:, 1], slope[:, 0])))
        axle = axle + length * unit(headings[0])
    slope = np.gradient(axle, s, axis=0, edge_order=2)
    base = np.column_stack([axle, np.unwrap(np.arctan2(slope[:, 1], slope[:, 0]))])[20:-20]
    told = np.array(headings).T[20:-20]
    found = towed(base, LENGTHS, headings=told[0])
    np.testing.assert_allclose(found.poses[..., 2], told, atol=2e-3)
    np.testing.assert_allclose(found.poses[:, -1, :2], np.stack([s, 0.3 * np.sin(0.9 * s)], axis=-1)[20:-20], atol=2e-3)


@pytest.mark.parametrize(
    ("given", "kind", "said"),
    [
        (([[0, 0, 0]], [1.0]), ShapeError, "N from 2"),
        (([[0, 0, 0], [1, 0, 0]], []), ShapeError, r"lengths \(0,\)"),
        (([[0, 0, 0], [1, 0, 0]], [1.0, 0.0]), OutOfLimits, "a trailer's length of 0 m came"),
        (([[0, 0, 0], [1, 0, 0]], [1.0], [0.1, 0.2]), ShapeError, r"hitches of shape \(2,\)"),
        (([[0, 0, 0], [np.nan, 0, 0]], [1.0]), InputError, "nan"),
    ],
)
def test_what_is_refused(given: tuple, kind: type[Exception], said: str) -> None:
    with pytest.raises(kind, match=said):
        hm.mobile.towed(*given)

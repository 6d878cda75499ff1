"""Fastest speed along a path: a search over speeds on a grid with equations of its own, laws, bad input."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np
import pytest

from holonom.devices import DcMotor, Gear
from holonom.errors import InputError, MotionError, OutOfLimits, ShapeError
from holonom.mobile import (
    WheelBase,
    ackermann,
    contact_points,
    differential,
    drive_limits,
    dynamic_margin,
    omni,
    speed_profile,
)
from holonom.mobile.curves import reeds_shepp
from holonom.mobile.drive.limits import DriveLimits

MOTOR = DcMotor(
    resistance=1.2, inductance=0.56e-3, torque_constant=25.5e-3, back_emf_constant=25.5e-3,
    rotor_inertia=9.25e-6, max_voltage=14.8, max_current=8.0,
)  # fmt: skip
MU, G = 0.7, 9.80665
ROBOT = differential(0.3, 0.05, mass=6.0, com=(-0.06, 0.0), com_height=0.12)
CAR = ackermann(0.4, 0.3, 0.05, max_steering=0.6, mass=8.0, com=(0.18, 0.0), com_height=0.1)
BASES = {"differential": ROBOT, "car": CAR}
LENGTH, RATE = 6.0, 1.5
CASTOR = float(contact_points(ROBOT)[2, 0])


@functools.cache
def floor_of(base: WheelBase) -> DriveLimits:
    return drive_limits(base, MOTOR, Gear(12.0), MU)


def bends(shape: str, s: np.ndarray) -> np.ndarray:
    """Curvature at ways along 6 m: line, circle, eight, chicane."""
    if shape == "eight":
        return 1.2 * np.tanh(3.0 * np.sin(2.0 * np.pi * s / LENGTH))
    return {"line": 0.0 * s, "circle": 0.0 * s + 1.1, "chicane": 1.2 * np.sin(4.0 * np.pi * s / LENGTH)}[shape]


@functools.cache
def motor_lines(base: WheelBase) -> list[tuple[np.ndarray, np.ndarray]]:
    """Motor forces over rim speeds."""
    rims = np.linspace(-1.0, 1.0, 2001) * floor_of(base).rim_speed
    return [(rims, line) for line in floor_of(base).motor_limits(rims)]


def feasible(base: WheelBase, k: float, dk: float, v: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Whether (v, a), any shape, is within everything: Newton and Euler of either base, written out."""
    M, c, b, z = base.mass, base.com[0], 0.3, v**2
    inertia = base.alpha * M * base.radius**2
    ay = k * z + c * (k * a + dk * z)
    ax = a - c * k**2 * z
    if base is ROBOT:
        turning = inertia * (k * a + dk * z) + M * c * ay
        F = [0.5 * M * ax - turning / b, 0.5 * M * ax + turning / b]
        rims = [1.0 - 0.5 * b * k, 1.0 + 0.5 * b * k]
    else:
        rims = [1.0 - 0.5 * b * k, 1.0 + 0.5 * b * k]
        work = (M * (1.0 + (c * k) ** 2) + inertia * k**2) * a + k * dk * (M * c**2 + inertia) * z
        F = [rim * work / (rims[0] ** 2 + rims[1] ** 2) for rim in rims]
    h = base.com_height
    zx, zy = c - h * ax / G, -h * ay / G
    if base is ROBOT:
        castor = CASTOR
        part = zx / castor  # of the weight on the castor
        left = 0.5 * (1.0 - part) + zy / b
        N = [M * G * left, M * G * (1.0 - part - left), M * G * part]
        driven, holding = N[:2], N[0] + N[1]
    else:
        front, rear = zx / 0.4, 1.0 - zx / 0.4
        N = [M * G * (0.5 * part + side * zy / (2.0 * b)) for part in (front, rear) for side in (1.0, -1.0)]
        driven, holding = N[2:], N[0] + N[1] + N[2] + N[3]
    good = np.min(N, axis=0) >= 0.0
    limits = floor_of(base)
    for force, rim, load in zip(F, rims, driven, strict=True):
        low, high = (np.interp(v * rim, *line) for line in motor_lines(base))
        good &= (force >= low) & (force <= high) & (np.abs(v * rim) <= limits.rim_speed)
        good &= force**2 + (M * ay * load / holding) ** 2 <= (MU * load) ** 2
    if base is CAR:
        tan = [0.4 * k / (1.0 - side * 0.5 * b * k) for side in (1.0, -1.0)]
        steered = [
            0.4 * dk / (1.0 - side * 0.5 * b * k) ** 2 / (1.0 + t**2) for t, side in zip(tan, (1, -1), strict=True)
        ]
        good &= v * np.abs(steered).max() <= RATE
    return good


def edges(base: WheelBase, k: float, dk: float, v: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Least and greatest feasible acceleration over a step h at speeds (n,): a search, then halved; NaN: none."""

    def good(a: np.ndarray) -> np.ndarray:
        z = v[:, None] ** 2 + h * a  # midway
        return (z >= 0.5 * v[:, None] ** 2 - 1e-12) & feasible(base, k, dk, np.sqrt(np.maximum(z, 0.0)), a)

    grid = np.linspace(-MU * G, MU * G, 24)
    stop = -(v[:, None] ** 2) / (2.0 * h)
    tried = np.sort(np.concatenate([np.broadcast_to(grid, (len(v), 24)), stop], axis=1), axis=1)
    fits = good(tried)
    found = []
    for step, first in ((-1, fits.argmax(axis=1)), (1, fits.shape[1] - 1 - fits[:, ::-1].argmax(axis=1))):
        inside = np.take_along_axis(tried, first[:, None], 1)
        outside = np.take_along_axis(tried, np.clip(first + step, 0, 24)[:, None], 1)
        for _ in range(10):
            middle = 0.5 * (inside + outside)
            fit = good(middle)
            inside, outside = np.where(fit, middle, inside), np.where(fit, outside, middle)
        found.append(np.where(fits.any(axis=1), inside[:, 0], np.nan))
    return found[0], found[1]


def fastest(base: WheelBase, bend: Callable[[np.ndarray], np.ndarray], places: int = 80) -> float:
    """Least time, s, by dynamic programming backwards over places and speeds up to the fastest that can be braked."""
    h = LENGTH / places
    part = np.linspace(0.0, 1.0, 160) ** 1.5
    most, best = 0.0, np.zeros(160)
    for i in reversed(range(places)):
        k, around = bend(np.array([(i + 0.5) * h]))[0], bend(np.array([i * h, (i + 1.0) * h]))
        dk = (around[1] - around[0]) / h
        after, low, high = most, 0.0, 2.5
        for _ in range(2):  # the fastest speed from which the next place's speeds are reached, ever closer
            v = np.linspace(low, high, 60)
            least, greatest = edges(base, k, dk, v, h)
            ok = np.flatnonzero((v**2 + 2.0 * h * least <= after**2 + 1e-12) & (v**2 + 2.0 * h * greatest >= 0.0))
            low, high = v[ok[-1]], v[min(ok[-1] + 1, 59)]
        most = low
        v = most * part
        least, greatest = edges(base, k, dk, v, h)
        least = np.maximum(least, -(v**2) / (2.0 * h))
        greatest = np.minimum(greatest, (after**2 - v**2) / (2.0 * h))
        tried = least[:, None] + np.linspace(0.0, 1.0, 20) * (greatest - least)[:, None]
        to = np.sqrt(np.maximum(v[:, None] ** 2 + 2.0 * h * tried, 0.0))
        with np.errstate(divide="ignore"):
            cost = 2.0 * h / (to + v[:, None]) + np.interp(to, after * part, best)
        best = np.where(np.isnan(cost), np.inf, cost).min(axis=1)
    return float(best[0])


@pytest.mark.parametrize("shape", ["line", "circle", "eight", "chicane"])
@pytest.mark.parametrize("name", BASES)
def test_it_is_as_fast_as_a_search_over_speeds(name: str, shape: str) -> None:
    base = BASES[name]
    s = np.linspace(0.0, LENGTH, 1201)
    found = speed_profile(base, s, bends(shape, s), floor_of(base), steering_rate=RATE)
    assert found.time[-1] == pytest.approx(fastest(base, lambda at: bends(shape, at)), rel=0.01)


@pytest.mark.parametrize("shape", ["line", "circle", "eight", "chicane"])
@pytest.mark.parametrize("name", BASES)
def test_what_is_found_can_be_driven(name: str, shape: str) -> None:
    """Midway between places, within 2 % of friction and forces: and the base does not tip."""
    base = BASES[name]
    s = np.linspace(0.0, LENGTH, 1201)
    k = bends(shape, s)
    found = speed_profile(base, s, k, floor_of(base), steering_rate=RATE)
    a, z = found.acceleration[:-1], 0.5 * (found.speed[1:] ** 2 + found.speed[:-1] ** 2)
    middle, dk = 0.5 * (k[1:] + k[:-1]), np.diff(k) / np.diff(s)
    for i in range(3, len(a) - 3, 7):
        assert feasible(base, middle[i], dk[i], np.sqrt(0.97 * z[i : i + 1]), 0.97 * a[i : i + 1]).all(), (i, s[i])
    margin = dynamic_margin(base, np.column_stack([a, middle * z])) if base is CAR else np.ones(1)
    assert margin.min() > -1e-3
    np.testing.assert_allclose(np.diff(found.time), 2.0 * np.diff(s) / (found.speed[1:] + found.speed[:-1]))


@pytest.mark.parametrize("name", BASES)
def test_laws(name: str) -> None:
    base, s = BASES[name], np.linspace(0.0, LENGTH, 601)
    k = bends("chicane", s)
    drive = floor_of(base)
    fast = speed_profile(base, s, k, drive).time[-1]
    assert speed_profile(base, s, -k, drive).time[-1] == pytest.approx(fast, rel=1e-3)
    assert speed_profile(base, s, k, drive, max_speed=0.8).speed.max() == pytest.approx(0.8, rel=1e-6)
    assert speed_profile(base, s, k, drive, max_speed=0.8).time[-1] > fast
    finer = np.linspace(0.0, LENGTH, 2401)
    assert speed_profile(base, finer, bends("chicane", finer), drive).time[-1] == pytest.approx(fast, rel=3e-3)
    if base is CAR:
        slow = speed_profile(base, s, k, drive, steering_rate=0.4)
        assert slow.time[-1] > fast
        steering = base.steering(np.column_stack([np.ones_like(s), 0.0 * s, k]))
        rate = np.diff(steering, axis=0) / np.diff(slow.time)[:, None]
        assert np.abs(rate).max() <= 0.4 * 1.02
    back = speed_profile(base, s, k, drive, direction=-1.0)
    assert np.isfinite(back.time).all()


def test_a_cusp_is_a_stop() -> None:
    """Along a parking curve the base stops at cusps and where curvature jumps, and steers anew."""
    curve = reeds_shepp([0.0, 0.0, 0.0], [0.3, 0.9, 0.0], 1.0)
    way, k, direction = [], [], []
    for letter, length in zip(curve.words[0], curve.lengths[0], strict=False):
        if length:
            way.append((way[-1][-1] if way else 0.0) + np.linspace(0.0, abs(length), 200))
            k.append(np.full(200, {"L": 1.0, "S": 0.0, "R": -1.0}[letter]))
            direction.append(np.full(200, np.sign(length)))
    pieces = len(way)
    way, k, direction = np.concatenate(way), np.concatenate(k), np.concatenate(direction)
    found = speed_profile(CAR, way, k * direction, floor_of(CAR), direction=direction, steering_rate=RATE)
    jumps = np.flatnonzero(np.diff(way) == 0.0)
    assert len(jumps) == pieces - 1
    np.testing.assert_array_equal(found.speed[jumps], 0.0)
    assert (np.diff(found.time)[jumps] > 0.1).all()
    assert np.delete(found.speed, [0, len(way) - 1, *jumps, *(jumps + 1)]).min() > 0.0


def test_a_holonomic_base_holds_itself_across_by_its_motors() -> None:
    base = omni(n=4, radius=0.15, wheel_radius=0.05, mass=5.0, com_height=0.05)
    s = np.linspace(0.0, 4.0, 801)
    found = speed_profile(base, s, 0.0 * s + 1.0, floor_of(base))
    assert 1.0 < found.time[-1] < 10.0


def test_bad_input() -> None:
    s, drive = np.linspace(0.0, 1.0, 11), floor_of(CAR)
    with pytest.raises(InputError, match=r"radius 0.25 m 0.5 m along it.*turns no sharper"):
        speed_profile(CAR, s, np.where(np.arange(11) == 5, 4.0, 0.0), drive)
    with pytest.raises(ShapeError, match="way has shape"):
        speed_profile(CAR, s, s[:-1], drive)
    with pytest.raises(ShapeError):
        speed_profile(CAR, s, s * math.nan, drive)
    with pytest.raises(OutOfLimits, match="never go back"):
        speed_profile(CAR, s[::-1], 0.0 * s, drive)
    with pytest.raises(OutOfLimits, match="direction"):
        speed_profile(CAR, s, 0.0 * s, drive, direction=0.5)
    for name in ("max_speed", "steering_rate"):
        with pytest.raises(OutOfLimits, match=name):
            speed_profile(CAR, s, 0.0 * s, drive, **{name: 0.0})
    with pytest.raises(InputError, match="no mass"):
        speed_profile(ackermann(0.4, 0.3, 0.05), s, 0.0 * s, drive)
    stiff = dataclasses.replace(MOTOR, no_load_current=9.0)
    with pytest.raises(MotionError, match="cannot drive on"):
        speed_profile(ROBOT, s, 0.0 * s, drive_limits(ROBOT, stiff, Gear(12.0), MU))

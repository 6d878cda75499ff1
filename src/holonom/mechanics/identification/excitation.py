"""Motions that tell much about an arm: finite Fourier series (Swevers et al. 1997) of small condition number."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.errors import InputError, OutOfLimits
from holonom.mechanics.arm.arm import Arm
from holonom.mechanics.identification.base import BaseParameters, base_parameters, motion_ranges
from holonom.mechanics.identification.columns import regressor_of_rows
from holonom.mechanics.motion import Trajectory

__all__ = ["Excitation", "condition_number", "excitation"]


MARGIN = 0.98  # of every limit that is used: the series is checked on a grid, and moves a little further between
GRID = 40  # samples per period of the fastest harmonic at which limits are checked
HALVINGS = 10  # of the interval in which the largest amplitude that keeps the torque limits lies
SAMPLES = 8  # the same for the regressor


@dataclass(frozen=True, slots=True)
class Excitation:
    """An exciting motion and the condition number of the base regressor on it (columns scaled as in `base.scale`)."""

    trajectory: Trajectory
    condition: float
    base: BaseParameters


def excitation(
    arm: Arm,
    *,
    duration: float = 10.0,
    harmonics: int = 10,
    dt: float = 0.001,
    use: float = 1.0,
    friction: bool = True,
    trials: int = 200,
    seed: int = 0,
) -> Excitation:
    """Search for a periodic motion within the joint limits that excites all base parameters well.

    Every joint moves as `q0 + sum_l a_l / (w l) sin(w l t) - b_l / (w l) cos(w l t)`, at rest and without acceleration
    at both ends. Coefficients are drawn at random and improved by an evolution strategy of one parent (1/5 rule).

    Parameters
    ----------
    duration : of one period, s.
    harmonics : sines and cosines per joint, at least 2.
    dt : time between the samples of the trajectory, s.
    use : which part of each limit (range, speed, acceleration, torque) may be used, in (0, 1]. Torques are those of the
        model, where it states inertias: take less where it may be far off.
    friction : whether friction is to be identified too.
    trials : motions to try.
    seed : of the random numbers.

    Raises
    ------
    OutOfLimits
        `use` outside (0, 1].
    InputError
        Fewer than two harmonics, no trials, or a `dt` that does not resolve the fastest harmonic; no motion that was
        tried keeps the torque limits.
    """
    if not 0.0 < use <= 1.0:
        raise OutOfLimits(f"use = {use}; give the part of the limits that may be used, above 0 and up to 1")
    if harmonics < 2 or trials < 1 or not 0.0 < dt * harmonics * SAMPLES <= duration:
        raise InputError(
            f"{harmonics} harmonics, {trials} trials, dt = {dt} s in {duration} s; needed are two harmonics, one trial "
            f"and {SAMPLES} samples in a period of the fastest harmonic"
        )
    base = base_parameters(arm, friction=friction)
    series = _Series(arm, duration, harmonics, MARGIN * use)
    condition = condition_number(arm, base)
    coarse = np.linspace(0.0, duration, SAMPLES * harmonics, endpoint=False)
    best, value = _search(lambda c: condition(*series.motion(c, coarse)), (arm.n, 2 * harmonics + 1), trials, seed)
    if not np.isfinite(value):
        raise InputError(
            f"none of {trials} motions keeps the torque limits of arm {arm.model.name!r}: gravity alone exceeds them "
            f"where it was tried; check the limits against arm.gravity(q), or give more trials than {trials}"
        )
    time = np.arange(round(duration / dt) + 1) * dt
    return Excitation(Trajectory(dt, *series.motion(best, time)), value, base)


def condition_number(arm: Arm, base: BaseParameters) -> Callable[[Array, Array, Array], float]:
    """The condition number of the base regressor as a function of rows q, qd, qdd (N, n); columns as in `base.scale`.

    A joint's rows are divided by its torque limit where all limits are stated: what counts is torque noise, and a
    strong joint's is larger.
    """
    rows = regressor_of_rows(arm.model)
    torque = arm.limits.torque
    weight = 1.0 / torque if np.isfinite(torque).all() and (torque > 0).all() else np.ones(arm.n)

    def condition(q: Array, qd: Array, qdd: Array) -> float:
        W = (rows(q, qd, qdd)[..., base.columns] * weight[:, None]).reshape(-1, base.number)
        return float(np.linalg.cond(W / base.scale)) if qd.any() else np.inf

    return condition


class _Series:
    """Fourier series of all joints; whatever the coefficients, the motion keeps the limits."""

    def __init__(self, arm: Arm, duration: float, harmonics: int, use: float) -> None:
        (self._lower, self._upper), self._speed, self._acceleration = motion_ranges(arm.model)
        self._use, self._harmonics = use, np.arange(1, harmonics + 1)
        self._w = 2 * np.pi / duration * self._harmonics
        self._grid = np.linspace(0.0, duration, GRID * harmonics, endpoint=False)
        self._torque = arm.limits.torque if arm.model.bodies is not None else np.full(arm.n, np.inf)
        self._arm = arm

    def motion(self, c: Array, time: NDArray[Any]) -> tuple[Array, Array, Array]:
        """q, qd, qdd (N, n) for coefficients (n, 2 L + 1): amplitudes of speed, and where in its range a joint moves.

        Sums of a and of l b vanish: speed and acceleration are zero at both ends.
        """
        a, b, place = np.split(c, [len(self._w), 2 * len(self._w)], axis=1)
        a = a - a.mean(1, keepdims=True)
        b = b - np.outer(b @ self._harmonics, self._harmonics) / (self._harmonics @ self._harmonics)
        q, qd, qdd = self._sums(a, b, self._grid)
        low, high = q.min(0), q.max(0)
        room = self._use * (self._upper - self._lower)
        factor = np.minimum.reduce(
            [
                room / (high - low),
                self._use * self._speed / np.abs(qd).max(0),
                self._use * self._acceleration / np.abs(qdd).max(0),
            ]
        )
        free = room - factor * (high - low)
        middle = 0.5 * (self._upper + self._lower) + 0.5 * np.tanh(place[:, 0]) * free
        factor *= self._within_torque(middle, factor * (q - 0.5 * (low + high)), factor * qd, factor * qdd)
        q, qd, qdd = self._sums(a, b, time)
        return middle + factor * (q - 0.5 * (low + high)), factor * qd, factor * qdd

    def _within_torque(self, middle: Array, q: Array, qd: Array, qdd: Array) -> float:
        """The largest part of a motion about `middle` that keeps the torque limits; 0 if rest does not."""
        if not np.isfinite(self._torque).any():
            return 1.0

        def fits(part: float) -> bool:
            tau = self._arm.inverse_dynamics(middle + part * q, part * qd, part * qdd)
            return bool((np.abs(tau) <= self._use * self._torque).all())

        low, high = 0.0, 1.0
        if fits(high):
            return high
        for _ in range(HALVINGS):
            part = 0.5 * (low + high)
            low, high = (part, high) if fits(part) else (low, part)
        return low

    def _sums(self, a: Array, b: Array, time: NDArray[Any]) -> tuple[Array, Array, Array]:
        angle = time[:, None] * self._w
        s, c = np.sin(angle), np.cos(angle)
        w = self._w
        return s @ (a / w).T - c @ (b / w).T, c @ a.T + s @ b.T, -s @ (a * w).T + c @ (b * w).T


def _search(f: Callable[[Array], float], shape: tuple[int, ...], trials: int, seed: int) -> tuple[Array, float]:
    """Minimise f: a fifth of the trials are draws, the rest steps from the best one, longer while they succeed."""
    rng = np.random.default_rng(seed)
    best, value, step = np.zeros(shape), np.inf, 0.5
    for trial in range(trials):
        drawing = trial < max(1, trials // 5)
        x = rng.standard_normal(shape) if drawing else best + step * rng.standard_normal(shape)
        if (found := f(x)) < value:
            best, value = x, found
            step *= 1.0 if drawing else 1.5
        elif not drawing:
            step *= 1.5**-0.25
    return best, value

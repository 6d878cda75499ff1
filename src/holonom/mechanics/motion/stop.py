"""A controlled stop: the same path, with its time running slower and slower."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from holonom.arrays import Array
from holonom.mechanics.motion.trajectory import STILL, JointLimits, Trajectory, remainder, standstill

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

__all__ = ["stop"]


_ROUNDS = 3  # the place after a step depends on the rate after it; the error falls by a dt/qd in each round


def stop(current: Trajectory, consumed: int, limits: JointLimits) -> Trajectory:
    """Stop a running trajectory on its path, as fast as the joints' accelerations allow.

    Parameters
    ----------
    current
        The running trajectory; it keeps `limits`.
    consumed
        How many of its samples are already used, 0 to N.
    limits
        Joint limits; accelerations are used up to them.

    Returns
    -------
    Trajectory
        From sample `consumed` of `current` to rest at a point of the same path. The acceleration jumps at its
        start.

    Raises
    ------
    MotionError
        A `consumed` outside 0 to N.

    Notes
    -----
    With Q(tau) the path and r = d tau/dt, qd = Q' r. On a path that keeps the limits an unchanged r keeps them
    too, so at each sample the least r is taken whose change of qd every joint's acceleration allows.
    """
    from scipy.interpolate import CubicHermiteSpline  # heavy: on first use

    rest = remainder(current, consumed)
    dt, end = rest.dt, rest.duration
    if not rest.qd[0].any():
        return standstill(rest.q[0], dt, rest.line)
    path = CubicHermiteSpline(dt * np.arange(rest.q.shape[0]), rest.q, rest.qd)
    times, rates = [0.0], [1.0]
    while rates[-1] > 0.0 and times[-1] < end:
        tau, rate = _step(path, times[-1], rates[-1], limits.acceleration, dt)
        times.append(min(tau, end))
        rates.append(rate)
    q, qd = path(times), path(times, 1) * np.array(rates)[:, None]
    q[0], qd[-1] = rest.q[0], 0.0
    qdd = np.diff(qd, axis=0, append=qd[-1:]) / dt
    return Trajectory(dt, q, qd, qdd, rest.line)


def _step(path: CubicHermiteSpline, tau: float, rate: float, acceleration: Array, dt: float) -> tuple[float, float]:
    """Path time and rate one sample later, braking as hard as the accelerations allow."""
    speed = path(tau, 1) * rate
    after, least = tau + rate * dt, rate
    for _ in range(_ROUNDS):
        along = path(after, 1)
        moves = np.abs(along) > STILL
        bounds = (np.sign(along) * speed - acceleration * dt)[moves] / np.abs(along[moves])
        least = min(float(np.max(bounds, initial=0.0)), rate)
        after = tau + 0.5 * (rate + least) * dt
    return after, least

"""A controlled stop: the same path, with its time running slower and slower."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicHermiteSpline  # at once: a stop does not wait for it

from holonom.arrays import Array
from holonom.mechanics.motion.trajectory import STILL, JointLimits, Trajectory, remainder, standstill

__all__ = ["stop"]


_AHEAD = 2000  # samples of the path that are looked at first
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
    rest = remainder(current, consumed)
    q, qd, _ = rest.take(0, 1)
    if not qd[0].any():
        return standstill(q[0].copy(), rest.dt, rest.line)
    ahead = _AHEAD
    while (stopped := _within(rest, min(ahead, rest.count), limits)) is None:
        ahead *= 2
    return stopped


def _within(rest: Trajectory, count: int, limits: JointLimits) -> Trajectory | None:
    """The stop within the first samples of what is left; None where they do not suffice."""
    dt, end = rest.dt, (count - 1) * rest.dt
    q, qd, _ = rest.take(0, count)
    path = CubicHermiteSpline(dt * np.arange(count), q, qd)
    times, rates = [0.0], [1.0]
    while rates[-1] > 0.0 and times[-1] < end:
        tau, rate = _step(path, times[-1], rates[-1], limits.acceleration, dt)
        times.append(min(tau, end))
        rates.append(rate)
    if rates[-1] > 0.0 and count < rest.count:
        return None
    positions, speeds = path(times), path(times, 1) * np.array(rates)[:, None]
    positions[0], speeds[-1] = q[0], 0.0
    accelerations = np.diff(speeds, axis=0, append=speeds[-1:]) / dt
    return Trajectory(dt, positions, speeds, accelerations, rest.line)


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

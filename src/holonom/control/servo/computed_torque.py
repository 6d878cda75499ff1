"""Gains of the computed-torque law `u = qdd_ref + k_v e' + k_p e + k_i integral(e)` (spec 04.4)."""

from __future__ import annotations

import math

from holonom.control.servo.kernels import AccelerationParams
from holonom.errors import OutOfLimits

__all__ = ["acceleration_params", "greatest_bandwidth", "least_inertia"]


def greatest_bandwidth(dt: float) -> float:
    """Return the greatest bandwidth (rad/s) of the law at a sample time, s: a tenth of a radian per sample."""
    return 0.1 / dt


def least_inertia(params: AccelerationParams, dt: float) -> float:
    """Return the part of the true inertia that the model may have at least: below, the loop is unstable.

    With a times the true inertia in the model, `s^3 + a (k_v s^2 + k_p s + k_i)` is stable for `a k_v k_p > k_i`
    (Routh); of a triple pole that is 1/9. Continuous: sampling at `dt` (s), the law's own, costs a little more.
    """
    return params.integral_gain / dt / (params.speed_gain * params.position_gain)


def acceleration_params(
    bandwidth: float, dt: float, *, integral: bool = True, max_correction: float = math.inf
) -> AccelerationParams:
    """Gains that put all poles of the error equation at `-bandwidth`.

    `e''' + k_v e'' + k_p e' + k_i e = (s + w)^3 e` with the integral: k_v = 3 w, k_p = 3 w^2, k_i = w^3.
    Without it `(s + w)^2`: k_v = 2 w, k_p = w^2, and a constant load leaves an error.

    Parameters
    ----------
    bandwidth
        w, rad/s. Sampling at `dt` costs the poles their place: keep `bandwidth * dt` below 0.1.
    dt
        Sample time of the law, s (1 ms by default of the cell).
    integral
        Whether a constant load is integrated away.
    max_correction
        Limit of everything but `qdd_ref`, rad/s^2.

    Raises
    ------
    OutOfLimits
        A number that is not positive, or `bandwidth * dt` above 0.1.
    """
    for name, value in (("bandwidth", bandwidth), ("dt", dt), ("max_correction", max_correction)):
        if not value > 0.0:
            raise OutOfLimits(f"acceleration_params: {name} is {value!r}; it must be greater than 0")
    if bandwidth > greatest_bandwidth(dt) * (1.0 + 1e-9):
        raise OutOfLimits(
            f"acceleration_params: bandwidth {bandwidth:g} rad/s at a sample time of {dt:g} s; "
            f"at most {greatest_bandwidth(dt):g} rad/s there, or sample faster"
        )
    w = bandwidth
    if integral:
        return AccelerationParams(3.0 * w * w, 3.0 * w, w**3 * dt, max_correction)
    return AccelerationParams(w * w, 2.0 * w, 0.0, max_correction)

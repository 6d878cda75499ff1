"""Speed loop of a wheel from data sheets, with its margins on the floor and spinning free (spec 04.3)."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.control.margins import LoopMargin, margin_of
from holonom.control.servo.cascade import ServoAxis
from holonom.control.servo.kernels import SpeedParams
from holonom.errors import OutOfLimits

__all__ = ["WheelLoop", "tune_wheel"]

LOOP_DELAY = 1.5  # sample periods, as in `design_cascade`
OBSERVER_RATIO = 2.0  # bandwidth of the speed observer over the fastest crossover
OBSERVER_SAMPLES = 0.6  # bandwidth of the observer times the sample time, at most
INTEGRAL_RATIO = 3.0  # crossover on the floor over the corner of the integral
COUNT_RIPPLE = 0.05  # current that one encoder count may cost, as a part of the limit
COUNT_PEAK = 0.8  # speed that one count costs the observer, in counts times its bandwidth
SLOWEST = 1e-9  # rad/s: no loop is slower


@dataclass(frozen=True, slots=True)
class WheelLoop:
    """Speed loop of a wheel: params of `speed_step`, and what it promises.

    Attributes
    ----------
    speed
        Params; the current goes out as the voltage `R i + k_e w`, limited by the supply.
    observer_bandwidth
        rad/s, of the tracking loop that gives the speed.
    on_floor, spinning
        Margins with the base's mass on the wheel, and with the wheel alone.
    limited_by
        "phase margin", "encoder resolution" or "sample time".
    """

    speed: SpeedParams
    observer_bandwidth: float
    on_floor: LoopMargin
    spinning: LoopMargin
    limited_by: str


def tune_wheel(axis: ServoAxis, spinning_inertia: float, *, dt: float = 1e-3, phase_margin: float = 0.8) -> WheelLoop:
    """Gains of the speed loop of a wheel that may lose its grip.

    A wheel that loses its grip loses most of its inertia, and the loop gets faster by as much. It is therefore as fast
    as the phase margin allows for the *spinning* wheel, with the lags of armature, sampling and observer; the
    integral's corner lies below the crossover that is left on the floor.

    Parameters
    ----------
    axis
        The motor; its inertia is the wheel's share of the base, wheel and rotor, at the motor.
    spinning_inertia
        Wheel and rotor alone, kg m^2 at the motor.
    dt
        Sample time, s.
    phase_margin
        Of the spinning wheel, rad.

    Raises
    ------
    OutOfLimits
        An inertia not in (0, axis.inertia], a sample time that is not positive, a margin not in (0.2, 1.2) rad, a
        wheel that no loop keeps the margin of.
    """
    _check(axis, spinning_inertia, dt, phase_margin)
    lag = axis.inductance / axis.resistance
    fastest = OBSERVER_SAMPLES / (OBSERVER_RATIO * dt)

    def phase(w: float) -> float:
        s = 1j * w
        lags = cmath.phase(_observer(s, OBSERVER_RATIO * w)) - math.atan(w * lag) - LOOP_DELAY * dt * w
        return math.pi / 2 + lags - math.atan(spinning_inertia / axis.inertia / INTEGRAL_RATIO)

    by_phase = _crossing(lambda w: phase(w) - phase_margin, dt)
    by_counts = _resolvable(axis, spinning_inertia)
    crossover = min(by_phase, by_counts, fastest)
    limit = {by_phase: "phase margin", by_counts: "encoder resolution", fastest: "sample time"}[crossover]
    bandwidth = OBSERVER_RATIO * crossover
    lags = abs(_observer(1j * crossover, bandwidth) / (1.0 + 1j * crossover * lag))
    gain = crossover * spinning_inertia / axis.torque_constant / lags
    corner = crossover * spinning_inertia / axis.inertia / INTEGRAL_RATIO
    speed = SpeedParams(
        gain=gain,
        integral_gain=gain * dt * corner,
        max_current=axis.max_current,
        max_voltage=axis.max_voltage,
        back_emf=axis.back_emf_constant,
        conductance=1.0 / axis.resistance,
    )

    def loop(inertia: float) -> Callable[[Array], Array]:
        def at(s: Array) -> Array:
            plant = axis.torque_constant / (axis.viscous + s * inertia) / (1.0 + s * lag)
            return gain * (1.0 + corner / s) * plant * _observer(s, bandwidth) * np.exp(-LOOP_DELAY * dt * s)

        return at

    margin, spinning = (margin_of("speed", loop(inertia), dt) for inertia in (axis.inertia, spinning_inertia))
    return WheelLoop(speed, bandwidth, margin, spinning, limit)


def _observer(s: Any, bandwidth: float) -> Any:
    """Measured over true speed, of a tracking loop with three poles at -bandwidth."""
    return bandwidth**2 * (3.0 * s + bandwidth) / (s + bandwidth) ** 3


def _resolvable(axis: ServoAxis, inertia: float) -> float:
    """Crossover (rad/s) at which one count, through the observer and gain w J / k_t, costs its current."""
    count = 2.0 * math.pi / axis.counts_per_rev
    allowed = COUNT_RIPPLE * axis.max_current * axis.torque_constant / inertia
    return math.sqrt(allowed / (COUNT_PEAK * OBSERVER_RATIO * count))


def _crossing(falling: Callable[[float], float], dt: float) -> float:
    """Frequency (rad/s) below that of the samples at which a falling function is zero.

    Raises
    ------
    OutOfLimits
        There is none.
    """
    from scipy.optimize import brentq  # heavy: on first use

    low, high = 1e-3 / dt, math.pi / dt
    while not falling(low) > 0.0 and low > SLOWEST:
        low *= 0.1
    if not falling(low) > 0.0 > falling(high):
        raise OutOfLimits(
            f"tune_wheel: no speed loop of this wheel keeps its phase margin at any crossover from {low:.2g} to "
            f"{high:.3g} rad/s; check inertias, inductance and resistance, give a shorter dt or a smaller phase_margin"
        )
    return float(brentq(falling, low, high))


def _check(axis: ServoAxis, spinning: float, dt: float, margin: float) -> None:
    if not 0.0 < spinning <= axis.inertia:
        raise OutOfLimits(
            f"tune_wheel: spinning_inertia is {spinning!r} kg m2; it must be above 0 and at most the inertia "
            f"on the floor, {axis.inertia:.4g}"
        )
    if not 0.0 < dt < math.inf:
        raise OutOfLimits(f"tune_wheel: dt is {dt!r} s; it must be positive")
    if not 0.2 < margin < 1.2:
        raise OutOfLimits(f"tune_wheel: phase_margin is {margin!r} rad; it must lie between 0.2 and 1.2")

"""From the numbers of a servo axis to the gains of its cascade, with the margins they leave (spec 04.3)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.control.margins import LoopMargin, margin_of
from holonom.control.servo.axis import DesignWarning, SampleTimes, ServoAxis
from holonom.control.servo.kernels import CurrentParams, PositionParams, SpeedParams
from holonom.control.servo.matching import drivable_speed, unmatched
from holonom.errors import OutOfLimits

__all__ = [
    "CascadeGains",
    "DesignWarning",
    "SampleTimes",
    "ServoAxis",
    "design_cascade",
    "design_current",
    "design_speed",
    "looked_at",
    "open_loops",
    "resolvable_crossover",
]

LOOP_DELAY = 1.5  # sample periods: half of one for the hold, one for computing, as a digital drive has them
CURRENT_MARGIN = math.radians(60.0)
SPEED_RATIO = 10.0  # T_i / T_V' of the speed loop: phase margin atan(sqrt 10) - atan(1 / sqrt 10) = 55 deg
POSITION_RATIO = 8.0  # crossover of the speed loop over the position gain
POSITION_SAMPLES = 0.2  # position gain times its sample time, at most: 17 deg of phase
OBSERVER_RATIO = 2.0  # bandwidth of the speed observer over the crossover of the speed loop
COUNT_RIPPLE = 0.2  # current that one count of position error may cost, as a part of the current limit
LEAST_MARGINS = {"current": 50.0, "speed": 45.0, "position": 60.0, "angle": 40.0}  # deg, below which a design says so
LEAST_GAIN_MARGIN = 2.0
COUNT_PEAK = 0.8  # speed that one count costs a third-order tracking loop, in counts times its bandwidth


@dataclass(frozen=True, slots=True)
class CascadeGains:
    """Params of the three loops and what they promise.

    Attributes
    ----------
    current, speed, position
        Params of `current_step`, `speed_step`, `position_step` at the sample times `times`.
    observer_bandwidth
        rad/s, of the tracking loop that gives the speed; the margins count on its acceleration input.
    current_margin, speed_margin, position_margin
        Computed with the delays of sampling and of the inner loops.
    speed_limited_by
        "sample time" or "encoder resolution": what kept the speed loop from being faster.
    warnings
        Margins that are not reached, and assumptions that do not hold.
    """

    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    times: SampleTimes
    observer_bandwidth: float
    current_margin: LoopMargin
    speed_margin: LoopMargin
    position_margin: LoopMargin
    speed_limited_by: str
    warnings: tuple[DesignWarning, ...] = ()

    @property
    def margins(self) -> dict[str, LoopMargin]:
        """By name of the loop."""
        return {"current": self.current_margin, "speed": self.speed_margin, "position": self.position_margin}


def design_cascade(
    axis: ServoAxis,
    *,
    times: SampleTimes | None = None,
    max_braking: float | None = None,
    feed_back_emf: bool = True,
) -> CascadeGains:
    """Gains of the current, speed and position loops of an axis.

    - Current: PI, zero on the electrical time constant, so that the loop is `K_c / (s L)` with a delay of 1.5
      sample times; its crossover is where 60 degrees of phase margin are left (556 Hz at 10 kHz).
    - Speed: PI with `T_i = 10 T_V'` about the small lags `T_V'` (current loop, sampling), crossover at
      `1 / sqrt(T_i T_V')`: 55 degrees (about 50 Hz at 2 kHz); `T_i = J / B` where viscous friction makes that the
      shorter one, so that the zero cancels the lag. Slower where one encoder count would otherwise cost more than a
      fifth of the current limit.
    - Position: P, slow against the speed loop, and against its sampling, so that its step does not
      overshoot; speed as feed-forward.

    The margins that come out are looked at: what is not reached is among the `warnings`.

    Parameters
    ----------
    axis
        The axis.
    times
        Sample times; 0.1, 0.5 and 1 ms by default.
    max_braking
        Deceleration (rad/s^2 at the motor) that a long position step may count on; by default half of what
        the current limit gives, the other half being left for gravity and friction.
    feed_back_emf
        Whether the current loop is fed the back-emf of the measured speed.

    Raises
    ------
    OutOfLimits
        A `max_braking` that is not positive; a loop that comes out unstable.
    """
    if max_braking is not None and not max_braking > 0.0:
        raise OutOfLimits(f"design_cascade: max_braking is {max_braking!r}; it must be greater than 0 rad/s^2")
    times = times or SampleTimes()
    current = design_current(axis, times.current, feed_back_emf)
    speed, observer, limited_by = design_speed(axis, times, current)
    torque_limit = axis.torque_constant * axis.max_current

    responses = _open_loops(axis, times, current, speed)
    current_margin = margin_of("current", responses["current"], times.current)
    speed_margin = margin_of("speed", responses["speed"], times.speed)
    position = PositionParams(
        gain=min(speed_margin.crossover / POSITION_RATIO, POSITION_SAMPLES / times.position),
        max_speed=min(axis.max_speed, drivable_speed(axis)),
        max_braking=0.5 * torque_limit / axis.inertia if max_braking is None else max_braking,
    )

    margins = {
        "current": current_margin,
        "speed": speed_margin,
        "position": margin_of("position", _position_loop(responses["speed"], position, times), times.position),
    }
    return CascadeGains(
        current=current,
        speed=speed,
        position=position,
        times=times,
        observer_bandwidth=observer,
        current_margin=margins["current"],
        speed_margin=margins["speed"],
        position_margin=margins["position"],
        speed_limited_by=limited_by,
        warnings=(*looked_at(axis, times, margins), *unmatched(axis, current, speed, position)),
    )


def open_loops(axis: ServoAxis, gains: CascadeGains) -> dict[str, Callable[[Any], Any]]:
    """Open loops by name (current, speed, position): frequency responses at complex frequencies (n,), rad/s.

    Each with its delay of 1.5 samples and the closed loops inside.
    """
    found = _open_loops(axis, gains.times, gains.current, gains.speed)
    return found | {"position": _position_loop(found["speed"], gains.position, gains.times)}


def _open_loops(
    axis: ServoAxis, times: SampleTimes, current: CurrentParams, speed: SpeedParams
) -> dict[str, Callable[[Any], Any]]:
    def current_loop(s: Array) -> Array:
        pi = current.gain + current.integral_gain / (s * times.current)
        return pi / (axis.resistance + s * axis.inductance) * np.exp(-LOOP_DELAY * times.current * s)

    def speed_loop(s: Array) -> Array:
        pi = speed.gain + speed.integral_gain / (s * times.speed)
        plant = axis.torque_constant / (axis.viscous + s * axis.inertia)
        return pi * plant * _closed(current_loop(s)) * np.exp(-LOOP_DELAY * times.speed * s)

    return {"current": current_loop, "speed": speed_loop}


def _position_loop(
    speed_loop: Callable[[Any], Any], position: PositionParams, times: SampleTimes
) -> Callable[[Any], Any]:
    return lambda s: position.gain / s * _closed(speed_loop(s)) * np.exp(-LOOP_DELAY * times.position * s)


def looked_at(axis: ServoAxis, times: SampleTimes, margins: dict[str, LoopMargin]) -> list[DesignWarning]:
    """What does not hold of a design."""
    found, lag = [], axis.inductance / axis.resistance
    if times.current > lag and "current" in margins:
        found.append(
            DesignWarning(
                "sample_time",
                f"the current loop samples every {times.current:.3g} s, the electrical time constant L/R is only "
                f"{lag:.3g} s: what happens between samples is not controlled; sample faster, or add a choke",
                times.current,
                lag,
            )
        )
    for name, margin in margins.items():
        degrees, wanted = math.degrees(margin.phase_margin), LEAST_MARGINS[name]
        if degrees < wanted:
            found.append(
                DesignWarning(
                    f"{name}_phase_margin",
                    f"the {name} loop keeps {degrees:.1f} deg of phase at {margin.crossover:.4g} rad/s; "
                    f"{wanted:g} are wanted: sample the loops inside faster",
                    degrees,
                    wanted,
                )
            )
        if margin.gain_margin < LEAST_GAIN_MARGIN:
            found.append(
                DesignWarning(
                    f"{name}_gain_margin",
                    f"the {name} loop is unstable from {margin.gain_margin:.3g} times its gain; "
                    f"{LEAST_GAIN_MARGIN:g} are wanted: sample the loops inside faster",
                    margin.gain_margin,
                    LEAST_GAIN_MARGIN,
                )
            )
    return found


def design_current(axis: ServoAxis, dt: float, feed_back_emf: bool) -> CurrentParams:
    """PI of the current: its zero on L/R, 60 deg of phase left."""
    crossover = (0.5 * math.pi - CURRENT_MARGIN) / (LOOP_DELAY * dt)
    gain = crossover * axis.inductance
    return CurrentParams(
        gain=gain,
        integral_gain=gain * dt * axis.resistance / axis.inductance,
        max_voltage=axis.max_voltage,
        back_emf=axis.back_emf_constant if feed_back_emf else 0.0,
    )


def design_speed(axis: ServoAxis, times: SampleTimes, current: CurrentParams) -> tuple[SpeedParams, float, str]:
    """Speed loop, observer bandwidth (rad/s) and what limited them."""
    small_lag = axis.inductance / current.gain + LOOP_DELAY * times.speed
    by_sampling = 1.0 / (math.sqrt(SPEED_RATIO) * small_lag)
    by_counts = resolvable_crossover(axis)
    crossover = min(by_sampling, by_counts)
    gain = crossover * axis.inertia / axis.torque_constant
    slowest = axis.inertia / axis.viscous if axis.viscous > 0.0 else math.inf
    corner = max(crossover / math.sqrt(SPEED_RATIO), 1.0 / slowest)
    params = SpeedParams(
        gain=gain,
        integral_gain=gain * times.speed * corner,
        max_current=axis.max_current,
        max_voltage=axis.max_voltage,
        back_emf=axis.back_emf_constant,
        conductance=1.0 / axis.resistance,
    )
    limited_by = "sample time" if by_sampling <= by_counts else "encoder resolution"
    return params, OBSERVER_RATIO * crossover, limited_by


def resolvable_crossover(axis: ServoAxis) -> float:
    """Crossover w (rad/s) at which one count, through observer and gain w J / k_t, costs its current."""
    count = 2.0 * math.pi / axis.counts_per_rev
    allowed = COUNT_RIPPLE * axis.max_current * axis.torque_constant / axis.inertia
    return math.sqrt(allowed / (COUNT_PEAK * OBSERVER_RATIO * count))


def _closed(loop: Array) -> Array:
    return loop / (1.0 + loop)

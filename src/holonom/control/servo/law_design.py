"""What designs of servos share: loops with delays and elasticity, gains with margins (specification 04.3, 04.5)."""

from __future__ import annotations

import dataclasses
import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from holonom.arrays import Array
from holonom.control.margins import LoopMargin, margin_of
from holonom.control.servo.cascade import (
    LEAST_GAIN_MARGIN,
    LOOP_DELAY,
    OBSERVER_RATIO,
    POSITION_RATIO,
    POSITION_SAMPLES,
    CascadeGains,
    DesignWarning,
    SampleTimes,
    ServoAxis,
    design_current,
    design_speed,
    looked_at,
    open_loops,
    resolvable_crossover,
)
from holonom.control.servo.kernels import CurrentParams, PositionParams, SpeedParams
from holonom.control.servo.law_kernels import ONE_LOOP, PASSES, THREE_LOOPS, TWO_LOOPS, BiquadParams, LawParams
from holonom.control.servo.matching import drivable_speed, unmatched
from holonom.errors import OutOfLimits
from holonom.registry import check_fields

__all__ = ["Servo", "ServoGains", "law_gains", "law_loops", "servo_law", "servo_loops", "slowed"]

STRUCTURE = 0.02  # damping of an elastic shaft, of critical
SLOWER = 0.95  # from one try to the next
LEAST = 1e-3  # part of the first gain


@dataclass(frozen=True, slots=True)
class ServoGains:
    """Params of a servo beside the default cascade, and what they promise.

    Attributes
    ----------
    current, speed, position, times, observer_bandwidth
        As those of `CascadeGains`; what a servo has not got, its law leaves out.
    law
        What makes it another one.
    margins
        By name: current, speed, position; of one or two loops `angle`, opened at the actuator.
    speed_limited_by
        "sample time" or "encoder resolution".
    warnings
        Margins that are not reached, limits that do not match.
    """

    current: CurrentParams
    speed: SpeedParams
    position: PositionParams
    times: SampleTimes
    observer_bandwidth: float
    law: LawParams
    margins: dict[str, LoopMargin]
    speed_limited_by: str
    warnings: tuple[DesignWarning, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo(ABC):
    """A servo with its settings: frozen dataclasses with fields made by `parameter`; what all of them have.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    def __post_init__(self) -> None:
        check_fields(self)

    @abstractmethod
    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> CascadeGains | ServoGains:
        """Gains for an axis at sample times (0.1, 0.5, 1 ms unless given), with their margins.

        Raises
        ------
        OutOfLimits
            A loop that comes out unstable.
        ModelError
            An axis without what the servo needs.
        """


def servo_law(
    *, form: int = THREE_LOOPS, tachometer: bool = False, on_load: bool = False, compensation: float = 0.0,
    gap: float = 0.0, crossing: float = 0.0, crossing_gain: float = 0.0, lead: BiquadParams = PASSES,
    notch: BiquadParams = PASSES,
) -> LawParams:  # fmt: skip
    """Params of a law; of the default cascade unless told otherwise."""
    return LawParams(form, tachometer, on_load, compensation, gap, crossing, crossing_gain, lead, notch)


def law_gains(
    axis: ServoAxis, law: LawParams, *, times: SampleTimes | None = None, speed: SpeedParams | None = None,
) -> ServoGains:  # fmt: skip
    """Gains of an axis under a law; the speed's regulator is the usual PI unless it comes with the law."""
    times = times or SampleTimes()
    current = design_current(axis, times.current, True)
    usual, observer, limited_by = design_speed(_seen(axis, law), _sampled(times, law), current)
    speed = usual if speed is None else speed
    if law.tachometer:
        observer = min(observer, OBSERVER_RATIO * resolvable_crossover(axis))
    slow = PositionParams(1e-6, 1.0, 1.0)
    loops = law_loops(axis, times, current, speed, slow, law)
    inner = margin_of("speed", loops["speed"], _sampled(times, law).speed)
    torque_limit = axis.torque_constant * axis.max_current
    position = PositionParams(
        gain=min(inner.crossover / POSITION_RATIO, POSITION_SAMPLES / times.position),
        max_speed=min(axis.max_speed, drivable_speed(axis)),
        max_braking=0.5 * torque_limit / axis.inertia,
    )
    loops = law_loops(axis, times, current, speed, position, law)
    tops = {"current": times.current, "speed": _sampled(times, law).speed, "position": times.position}
    names = {THREE_LOOPS: ("current", "speed", "position"), TWO_LOOPS: ("current", "angle"), ONE_LOOP: ("angle",)}
    margins = {name: margin_of(name, loops[name], tops.get(name, times.speed)) for name in names[law.form]}
    return ServoGains(
        current, speed, position, times, observer, law, margins, limited_by,
        (*looked_at(axis, times, margins), *unmatched(axis, current, speed, position)),
    )  # fmt: skip


def slowed(
    axis: ServoAxis, law: LawParams, speed: SpeedParams, times: SampleTimes, wanted: float, *, corner: bool = True
) -> ServoGains:
    """Gains with the speed's regulator slowed down until its loop keeps a phase margin (rad); its corner with it."""
    current, part = design_current(axis, times.current, True), 1.0
    while True:
        integral = speed.integral_gain * part * (part if corner else 1.0)
        tried = speed._replace(gain=speed.gain * part, integral_gain=integral)
        loop = law_loops(axis, times, current, tried, PositionParams(1e-6, 1.0, 1.0), law)["speed"]
        if _keeps(loop, _sampled(times, law).speed, wanted) or part < LEAST:
            return law_gains(axis, law, times=times, speed=tried)
        part *= SLOWER


def law_loops(
    axis: ServoAxis, times: SampleTimes, current: CurrentParams, speed: SpeedParams, position: PositionParams,
    law: LawParams,
) -> dict[str, Callable[[Any], Any]]:  # fmt: skip
    """Open loops by name: responses at complex frequencies (n,), rad/s; `angle` is that of one and two loops."""
    dt = _sampled(times, law).speed

    def current_loop(s: Array) -> Array:
        pi = current.gain + current.integral_gain / (s * times.current)
        return pi / (axis.resistance + s * axis.inductance) * np.exp(-LOOP_DELAY * times.current * s)

    def motor(s: Array) -> Array:
        return axis.torque_constant / (axis.viscous + s * axis.inertia) * _elastic(axis, s)

    def actuated(s: Array) -> Array:
        """Speed by what the speed's regulator puts out, A."""
        if law.form != ONE_LOOP:
            loop = current_loop(s)
            return motor(s) * loop / (1.0 + loop)
        volts = motor(s) / (axis.resistance + s * axis.inductance)
        return axis.resistance * volts / (1.0 + axis.back_emf_constant * volts)

    def speed_loop(s: Array) -> Array:
        z = np.exp(s * dt)
        regulator = speed.gain * _biquad(law.lead, z) + speed.integral_gain / (s * dt)
        return regulator * _biquad(law.notch, z) * actuated(s) * np.exp(-LOOP_DELAY * dt * s)

    def position_loop(s: Array) -> Array:
        loop = speed_loop(s)
        carried = _carried(axis, s) if law.on_load else 1.0
        return position.gain / s * carried * loop / (1.0 + loop) * np.exp(-LOOP_DELAY * times.position * s)

    def angle_loop(s: Array) -> Array:
        return speed_loop(s) * (1.0 + position.gain / s)

    return {"current": current_loop, "speed": speed_loop, "position": position_loop, "angle": angle_loop}


def servo_loops(axis: ServoAxis, gains: CascadeGains | ServoGains) -> dict[str, Callable[[Any], Any]]:
    """Open loops of a servo, those of its margins, by name: see `open_loops`."""
    if isinstance(gains, CascadeGains):
        return open_loops(axis, gains)
    loops = law_loops(axis, gains.times, gains.current, gains.speed, gains.position, gains.law)
    return {name: loops[name] for name in gains.margins}


def _sampled(times: SampleTimes, law: LawParams) -> SampleTimes:
    """With the sample time of the speed's regulator."""
    return dataclasses.replace(times, speed=times.current) if law.tachometer else times


def _seen(axis: ServoAxis, law: LawParams) -> ServoAxis:
    """A tachometer has no counts."""
    return dataclasses.replace(axis, counts_per_rev=1e12) if law.tachometer else axis


def _keeps(loop: Callable[[Any], Any], dt: float, wanted: float) -> bool:
    try:
        found = margin_of("speed", loop, dt)
    except OutOfLimits:
        return False
    return found.phase_margin >= wanted and found.gain_margin >= LEAST_GAIN_MARGIN


def _biquad(params: BiquadParams, z: Array) -> Array:
    p = params
    found: Array = (p.b0 + p.b1 / z + p.b2 / z**2) / (1.0 + p.a1 / z + p.a2 / z**2)
    return found


def _elastic(axis: ServoAxis, s: Array) -> Array:
    """What an elastic shaft makes of the motor's own speed: antiresonance over resonance."""
    if math.isinf(axis.stiffness):
        return np.ones_like(s)
    low, high = axis.antiresonance, axis.resonance
    return (1.0 + 2.0 * STRUCTURE * s / low + (s / low) ** 2) / (1.0 + 2.0 * STRUCTURE * s / high + (s / high) ** 2)


def _carried(axis: ServoAxis, s: Array) -> Array:
    """The load's angle by the motor's."""
    if math.isinf(axis.stiffness):
        return np.ones_like(s)
    low = axis.antiresonance
    return (1.0 + 2.0 * STRUCTURE * s / low) / (1.0 + 2.0 * STRUCTURE * s / low + (s / low) ** 2)

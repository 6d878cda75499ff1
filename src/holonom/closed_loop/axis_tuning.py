"""`tune_axis`: gains of an axis from its sheets, and what they do in a whole simulation."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import Array
from holonom.closed_loop.axis import AxisRun, simulate_axis
from holonom.control import CascadeGains, DesignWarning, LoopMargin, SampleTimes, Servo, ServoGains
from holonom.control.servo.forms.three_loops import ThreeLoops
from holonom.control.servo.law_kernels import ONE_LOOP, PASSES
from holonom.devices.motors.thermal import ThermalModel
from holonom.errors import ModelError, OutOfLimits
from holonom.machine.axis.drive import DriveSettings
from holonom.registry import check_fields, parameter
from holonom.sim.axis.axis import Axis

__all__ = ["AxisLoop", "AxisTuning", "Verified", "WantedAxis", "trapezoid", "try_gains", "tune_axis"]

UNWATCHED = DriveSettings(supervised=False)
DELAY = 1.5  # samples: computing and hold
WITNESS = 0.02  # part of the no-load speed that one count of a look may be, for a watch that tells faults in 5 ms
RESERVE = 1.1  # speed that the position loop may ask for, to make up for what is lacking
HEADROOM = 0.9  # part of the speed that supply and acceleration allow, by default
LOADED = 0.2  # part of the current that friction and load may take, beside the acceleration's
LASTING = 0.9  # part of the current that the winding bears for ever
LEAST_PART = 0.1  # of the no-load speed, of the greatest acceleration
CALM = 0.5  # part of the frequency of a load on its stiffness up to which the speed loop may cross
SETTLED = 0.02  # part of a step within which it has settled


@dataclass(frozen=True, slots=True)
class WantedAxis:
    """What an axis is to do, at the joint.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    step: float = parameter(1.0, meaning="of the position, with which the gains are tried", unit="rad", above=0.0)
    speed: float | None = parameter(
        None, meaning="greatest; by default what supply and acceleration leave", unit="rad/s"
    )
    acceleration: float | None = parameter(None, meaning="by default what the motor bears for ever", unit="rad/s2")
    overshoot_percent: float = parameter(1.0, meaning="of the step, at most", least=0.0)
    settling_time: float | None = parameter(None, meaning="of the step to 2 %, at most", unit="s")
    following_error: float | None = parameter(None, meaning="of a move, at most", unit="rad")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        for name in ("speed", "acceleration", "settling_time", "following_error"):
            value = getattr(self, name)
            if value is not None and not 0.0 < value < math.inf:
                raise ModelError(f"WantedAxis: {name} is {value!r}; it must be finite and greater than 0")


@dataclass(frozen=True, slots=True)
class AxisLoop:
    """A loop: form; `Kc` in V/A, A s/rad (motor), 1/s; `Ti`, `Td` in s, None where it has none; margins; delay, s.

    Of a servo of one or two loops the loop is `angle`: PID with `Kc` in A/rad (of one loop: V/rad) of the motor.
    """

    form: Literal["PID", "PI", "P", "PD"]
    Kc: float
    Ti: float | None
    Td: float | None
    margin: LoopMargin
    delay: float


@dataclass(frozen=True, slots=True)
class Verified:
    """What a simulation with quantised angles, friction, backlash, limits and delays shows.

    Attributes
    ----------
    overshoot_percent, settling_time, end_error
        Of the step: percent, s to 2 % (infinite where it is not within that at the end), rad at the joint.
    following_error
        Largest of a move over the step with the wanted speed and acceleration, derivatives fed forward, rad.
    peak_current, peak_voltage
        Of the move, A and V.
    winding_temperature
        With the move there and back for ever without a pause, degC; None where the sheet has no thermal numbers,
        infinite where it never settles.
    position_ripple
        Peak to peak at rest, rad at the joint.
    """

    overshoot_percent: float
    settling_time: float
    end_error: float
    following_error: float
    peak_current: float
    peak_voltage: float
    winding_temperature: float | None
    position_ripple: float


@dataclass(frozen=True, slots=True)
class AxisTuning:
    """Gains, loops by name (current, speed, position), what a simulation shows, warnings; the runs of step and move.

    `size` is that of the step, rad; `moved` (3, n) the reference of the move.
    """

    axis: Axis
    gains: CascadeGains | ServoGains
    loops: dict[str, AxisLoop]
    verified: Verified
    warnings: tuple[DesignWarning, ...]
    step: AxisRun
    move: AxisRun
    size: float
    moved: Array


def try_gains(found: AxisTuning, true: Axis) -> Verified:
    """What the gains do on an axis that is not what its sheets say; its controller believes them."""
    step = simulate_axis(true, found.gains, found.step.reference, known=found.axis, drive=UNWATCHED)
    move = simulate_axis(true, found.gains, found.moved, known=found.axis, drive=UNWATCHED)
    return _verified(found.size, step, move, None)


def tune_axis(
    axis: Axis,
    *,
    times: SampleTimes | None = None,
    wanted: WantedAxis = WantedAxis(),
    thermal: ThermalModel | None = None,
    servo: Servo = ThreeLoops(),
) -> AxisTuning:
    """Gains of all loops from motor, gear, load and encoder, tried in a simulation.

    Parameters
    ----------
    axis
        What is tuned.
    times
        Sample times; 0.1, 0.5, 1 ms unless given.
    wanted
        What it is to do.
    thermal
        Of its motor.
    servo
        Of `SERVOS`; the cascade of three loops unless given.

    Raises
    ------
    OutOfLimits
        A speed that the supply does not give, an acceleration that the current does not give; with what is possible.
    """
    speed, acceleration = _possible(axis, wanted, thermal)
    axis = dataclasses.replace(axis, max_speed=RESERVE * speed)
    gains = servo.design(axis.servo_axis(), times=times)
    loops = _loops(gains)
    step = _step(axis, gains, wanted.step)
    moved = _there_and_back(wanted.step, speed, acceleration, gains.times.position)
    move = simulate_axis(axis, gains, moved)
    verified = _verified(wanted.step, step, move, thermal)
    stops = [e for run in (step, move) for e in run.events if e.first]
    stopped = [
        DesignWarning(e.cause.name.lower(), f"the drive stopped at {e.time:.4g} s: {e.text}", e.time, 0.0)
        for e in stops
    ]
    warnings = (
        *gains.warnings,
        *stopped,
        *_encoder_warnings(axis, gains, servo),
        *_restless(axis, wanted.step, gains, verified),
        *_unmet(wanted, verified),
        *_hot(verified, thermal),
    )
    return AxisTuning(axis, gains, loops, verified, warnings, step, move, wanted.step, moved)


def _possible(axis: Axis, wanted: WantedAxis, thermal: ThermalModel | None) -> tuple[float, float]:
    """Speed (rad/s) and acceleration (rad/s2) at the joint; unless wanted, what the motor can do for ever."""
    m, ratio = axis.motor, abs(axis.gear.ratio)
    rubbing, load = axis.known_friction, abs(axis.load.torque) / ratio / axis.gear.efficiency
    torque = m.torque_constant * m.max_current - max(rubbing.coulomb_positive, rubbing.coulomb_negative) - load
    mean = 0.5 * (1.0 / axis.gear.efficiency + axis.gear.efficiency)
    inertia = m.rotor_inertia + mean * axis.load_inertia
    most = torque / inertia / ratio
    if most <= 0.0:
        raise OutOfLimits(
            f"the current limit of {m.max_current:g} A gives {m.torque_constant * m.max_current:.4g} N m, less than "
            "friction and load take: this axis does not move; allow more current, or a higher ratio"
        )
    top = m.max_voltage / m.back_emf_constant / ratio
    lasting = min(thermal.largest_current(), m.max_current) if thermal is not None else 0.5 * m.max_current
    usual = max(most - m.torque_constant * (m.max_current - LASTING * lasting) / inertia / ratio, LEAST_PART * most)
    acceleration = usual if wanted.acceleration is None else wanted.acceleration
    speed = HEADROOM * _drivable(axis, acceleration / most) if wanted.speed is None else wanted.speed
    if speed >= top:
        raise OutOfLimits(f"speed is {speed:g} rad/s; {m.max_voltage:g} V give less than {top:.5g} rad/s at the joint")
    if acceleration >= most:
        raise OutOfLimits(
            f"acceleration is {acceleration:g} rad/s2; {m.max_current:g} A give at most {most:.5g} rad/s2 at the joint"
        )
    return speed, acceleration


def _drivable(axis: Axis, part: float) -> float:
    """Joint speed (rad/s) up to which the supply drives a part of the greatest acceleration."""
    m = axis.motor
    drops = m.resistance * m.max_current * (part + (1.0 - part) * LOADED)
    return max(m.max_voltage - drops, LEAST_PART * m.max_voltage) / m.back_emf_constant / abs(axis.gear.ratio)


def _loops(gains: CascadeGains | ServoGains) -> dict[str, AxisLoop]:
    c, s, p, times = gains.current, gains.speed, gains.position, gains.times
    dt = times.current if isinstance(gains, ServoGains) and gains.law.tachometer else times.speed
    corner = s.integral_gain / s.gain / dt  # 1 / Ti
    led = isinstance(gains, ServoGains) and gains.law.lead != PASSES
    made: dict[str, tuple[Literal["PID", "PI", "P", "PD"], float, float | None, float | None, float]] = {
        "current": ("PI", c.gain, c.gain * times.current / c.integral_gain, None, times.current),
        "speed": ("PI", s.gain, 1.0 / corner if corner > 0.0 else None, None, dt),
        "position": ("P", p.gain, None, None, times.position),
    }
    if corner == 0.0:
        made["speed"] = ("PD" if led else "P", s.gain, None, None, dt)
    if "angle" in gains.margins:  # (1 + corner / s) (k + s) K as K_c (1 + 1 / (s Ti) + s Td)
        volts = 1.0 / s.conductance if isinstance(gains, ServoGains) and gains.law.form == ONE_LOOP else 1.0
        both = p.gain + corner
        made["angle"] = ("PID", volts * s.gain * both, both / (corner * p.gain), 1.0 / both, times.speed)
    return {
        name: AxisLoop(form, Kc, Ti, Td, margin, DELAY * sample)
        for name, margin in gains.margins.items()
        for form, Kc, Ti, Td, sample in [made[name]]
    }


def _step(axis: Axis, gains: CascadeGains | ServoGains, size: float) -> AxisRun:
    """A step of the position, for as long as it takes, ten time constants of the loop, and 0.2 s."""
    speed = axis.max_speed or math.inf
    brakes = gains.position.max_braking / abs(axis.gear.ratio)
    lasts = size / speed + 2.0 * math.sqrt(size / brakes) + 10.0 / gains.position.gain + 0.2
    samples = math.ceil(lasts / gains.times.position)
    return simulate_axis(axis, gains, np.full(samples, size))


def _there_and_back(size: float, speed: float, acceleration: float, dt: float) -> Array:
    """(3, n): trapezoids of the speed."""
    there = trapezoid(size, speed, acceleration, dt)
    back = np.stack([size - there[0], -there[1], -there[2]])
    return np.concatenate([there, back], axis=1)


def trapezoid(size: float, speed: float, acceleration: float, dt: float) -> Array:
    """Position, speed, acceleration (3, n) of a move with limits, a sample each `dt` (s)."""
    peak = min(speed, math.sqrt(size * acceleration))
    ramp, lasts = peak / acceleration, peak / acceleration + size / peak
    t = np.minimum(dt * np.arange(math.ceil(lasts / dt) + 1), lasts)
    left, cruise = lasts - t, np.clip(t - ramp, 0.0, lasts - 2.0 * ramp)
    s = np.where(t < ramp, 0.5 * acceleration * t**2, 0.5 * peak * ramp + peak * cruise)
    s = np.where(left < ramp, size - 0.5 * acceleration * left**2, s)
    v = np.minimum(np.minimum(acceleration * t, acceleration * left), peak)
    a = np.where(t < ramp, acceleration, 0.0) - np.where((left < ramp) & (left > 0.0), acceleration, 0.0)
    return np.stack([s, v, a])


def _verified(size: float, step: AxisRun, move: AxisRun, thermal: ThermalModel | None) -> Verified:
    at_rest = step.position[-round(0.1 / (step.time[1] - step.time[0])) :]
    temperature = None
    if thermal is not None:
        rms = math.sqrt(float(move.square_current.mean()))
        try:
            temperature = thermal.settled(rms).winding
        except OutOfLimits:
            temperature = math.inf
    return Verified(
        overshoot_percent=100.0 * max(float(step.position.max()) / size - 1.0, 0.0),
        settling_time=_settling(step.time, np.abs(step.position - size) > SETTLED * size),
        end_error=float(abs(step.position[-1] - size)),
        following_error=float(np.abs(move.position - move.reference).max()),
        peak_current=float(np.abs(move.current).max()),
        peak_voltage=float(np.abs(move.voltage).max()),
        winding_temperature=temperature,
        position_ripple=float(np.ptp(at_rest)),
    )


def _settling(time: Array, outside: NDArray[np.bool_]) -> float:
    """Time of the last sample outside of the band, s; infinite where that is the last one of all."""
    if not outside.any():
        return 0.0
    return math.inf if outside[-1] else float(time[outside][-1])


def _restless(axis: Axis, size: float, gains: CascadeGains | ServoGains, verified: Verified) -> list[DesignWarning]:
    """What a simulation shows of a step that does not come to rest, and a resonance within the speed loop."""
    found, band = [], SETTLED * size
    if math.isinf(verified.settling_time):
        text = f"a step of {size:g} rad ends {verified.end_error:.4g} rad off; {band:.4g} rad count as settled"
        found.append(DesignWarning("not_settled", text, verified.end_error, band))
    if verified.position_ripple > band:
        swing = verified.position_ripple
        text = f"after a step of {size:g} rad it swings by {swing:.4g} rad; up to {band:.4g} rad is rest"
        found.append(DesignWarning("position_ripple", text, verified.position_ripple, band))
    crossing, most = _crossover(gains), CALM * math.sqrt(axis.stiffness / axis.load.inertia)
    if crossing > most:
        text = (
            f"with the motor held, the load swings at {most / CALM:.4g} rad/s; the speed loop, whose margin is that of "
            f"a stiff axis, crosses at {crossing:.4g} rad/s: up to {most:.4g} rad/s are sound; take a stiffness of "
            f"{axis.load.inertia * (crossing / CALM) ** 2:.4g} N m/rad, a slower loop (longer "
            "sample times), or the servo `notch`"
        )
        found.append(DesignWarning("resonance", text, crossing, most))
    return found


def _crossover(gains: CascadeGains | ServoGains) -> float:
    """Of the speed loop, or of what has it inside, rad/s."""
    return gains.margins["speed" if "speed" in gains.margins else "angle"].crossover


def _encoder_warnings(axis: Axis, gains: CascadeGains | ServoGains, servo: Servo) -> list[DesignWarning]:
    found, counts = [], axis.encoder.counts_per_rev
    if gains.speed_limited_by == "encoder resolution":
        fine = servo.design(dataclasses.replace(axis.servo_axis(), counts_per_rev=1e9), times=gains.times)
        asked, slow = _crossover(fine), _crossover(gains)
        needed = math.ceil(counts * (asked / slow) ** 2)
        found.append(
            DesignWarning(
                "encoder_resolution",
                f"{counts} counts per turn slow the speed loop to {slow:.4g} rad/s; its "
                f"sampling bears {asked:.4g} rad/s, for which {needed} counts are needed",
                float(counts),
                float(needed),
            )
        )
    top = axis.motor.max_voltage / axis.motor.back_emf_constant
    needed = math.ceil(2.0 * math.pi / (WITNESS * top * gains.times.speed))
    if counts < needed:
        found.append(
            DesignWarning(
                "encoder_supervision",
                f"one count in a sample of the speed loop is more than {100 * WITNESS:g} % of the no-load speed: "
                f"faults of the encoder are found later than within 5 ms; {needed} counts per turn are needed",
                float(counts),
                float(needed),
            )
        )
    return found


def _unmet(wanted: WantedAxis, verified: Verified) -> list[DesignWarning]:
    """What was wanted and does not come out."""
    limits = {
        "overshoot_percent": (wanted.overshoot_percent, "%"),
        "settling_time": (wanted.settling_time, "s"),
        "following_error": (wanted.following_error, "rad"),
    }
    return [
        DesignWarning(
            f"wanted_{name}", f"{name} is {value:.4g} {unit}; at most {limit:g} {unit} are wanted", value, float(limit)
        )
        for name, (limit, unit) in limits.items()
        if limit is not None and (value := getattr(verified, name)) > limit
    ]


def _hot(verified: Verified, thermal: ThermalModel | None) -> list[DesignWarning]:
    hottest = verified.winding_temperature
    if thermal is None or hottest is None or hottest <= thermal.limit:
        return []
    return [
        DesignWarning(
            "winding_temperature",
            f"moving there and back without a pause, the winding gets {hottest:.4g} degC hot; {thermal.limit:g} degC "
            "are allowed: move more slowly, or pause",
            hottest,
            thermal.limit,
        )
    ]

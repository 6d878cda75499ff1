"""Switched reluctance motor: unsaturated, its phases switched by angles that depend on speed and current (spec 03.1).

    d psi/dt = u - R i,   psi = L(x) i,   L = L_mean - L_swing cos x,   m = 1/2 i^2 dL/dtheta,

x the electrical angle of a phase, Z times the shaft's less the phase's shift: 0 unaligned, pi aligned. A half bridge
per phase applies +U, 0 or -U, and lets no negative current flow. Miller, Switched Reluctance Motors and Their Control,
1993, ch. 3-5.

Angles are told in the direction of motion: current between 0 and pi drives, between pi and 2 pi brakes, so four
quadrants are two tables and a mirror.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite, finite_array
from holonom.devices._checks import require
from holonom.errors import ModelError, OutOfLimits, ShapeError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = [
    "AngleTable",
    "ReluctanceCycle",
    "ReluctanceParams",
    "ReluctanceRun",
    "SwitchedReluctance",
    "reluctance_cycle",
    "reluctance_on",
    "reluctance_step",
    "reluctance_torque",
    "run_reluctance",
]

TURN = 2.0 * math.pi


class ReluctanceParams(NamedTuple):
    """R in ohm, mean and swing of L in H, poles of the rotor, phases, supply in V."""

    resistance: float
    mean: float
    swing: float
    poles: float
    phases: float
    voltage: float


class ReluctanceCycle(NamedTuple):
    """A settled period: mean torque of all phases in the direction of motion (N m), rms and peak of a phase (A)."""

    torque: float
    rms: float
    peak: float


@loop
def reluctance_torque(params: ReluctanceParams, current: float, x: float) -> float:
    """Torque of a phase, N m, at its electrical angle (rad): `1/2 i^2 dL/dtheta`."""
    return 0.5 * current * current * params.poles * params.swing * math.sin(x)


@loop
def reluctance_step(params: ReluctanceParams, flux: float, voltage: float, x: float, dt: float) -> float:
    """Flux linkage of a phase (V s) `dt` s later; exact for held voltage (V) and angle (rad, of the middle)."""
    inductance = params.mean - params.swing * math.cos(x)
    settled = voltage * inductance / params.resistance
    after = settled + math.exp(-params.resistance * dt / inductance) * (flux - settled)
    return max(after, 0.0)  # the diodes let none through


@loop
def reluctance_on(on: float, off: float, measured: float) -> bool:
    """Whether a phase is switched on at its measured angle (rad, in the direction of motion)."""
    return (measured - on) % (2.0 * math.pi) < (off - on) % (2.0 * math.pi)


@loop
def reluctance_cycle(
    params: ReluctanceParams, on: float, off: float, asked: float, speed: float, offset: float, resolution: float
) -> ReluctanceCycle:
    """Settled period of a phase at a speed of the shaft (rad/s, above 0), chopped to the current asked for (A).

    The chopper is quick: what it holds is met as far as the voltage can. `offset` (rad) is added by the sensor,
    `resolution` (rad) is its step; both electrical.
    """
    steps = 480
    dx = 2.0 * math.pi / steps
    dt = dx / (params.poles * speed)
    flux, torque, square, peak = 0.0, 0.0, 0.0, 0.0
    for _ in range(3):
        torque, square, peak = 0.0, 0.0, 0.0
        for k in range(steps):
            x = -0.5 * math.pi + dx * k  # begins where no phase that drives conducts
            seen = math.floor(x / resolution) * resolution if resolution > 0.0 else x
            fall = reluctance_step(params, flux, -params.voltage, x + 0.5 * dx, dt)
            rise = reluctance_step(params, flux, params.voltage, x + 0.5 * dx, dt)
            after = params.mean - params.swing * math.cos(x + dx)
            held = after * asked if reluctance_on(on, off, seen + offset) else 0.0
            flux = min(max(held, fall), rise)
            current = flux / after
            torque += reluctance_torque(params, current, x + dx)
            square += current * current
            peak = max(peak, current)
    return ReluctanceCycle(params.phases * torque / steps, math.sqrt(square / steps), peak)


@dataclass(frozen=True, slots=True)
class AngleTable:
    """Where phases are switched on and off, by speed and current: rad, electrical, in the direction of motion.

    Attributes
    ----------
    speeds
        Of the shaft, rad/s, increasing, (n,).
    currents
        A, increasing, (m,).
    driving, braking
        On and off angles, (n, m, 2).
    """

    speeds: Array
    currents: Array
    driving: Array
    braking: Array

    def __post_init__(self) -> None:
        for name in ("speeds", "currents"):
            values = finite_array(f"AngleTable: {name}", getattr(self, name), ["n"])
            if values.size < 1 or values[0] < 0.0 or np.any(np.diff(values) <= 0.0):
                raise ModelError(f"AngleTable: {name} are {values.tolist()}; they must grow from at least 0")
        for name in ("driving", "braking"):
            finite_array(f"AngleTable: {name}", getattr(self, name), (len(self.speeds), len(self.currents), 2))

    def angles(self, speed: float, current: float, *, braking: bool = False) -> tuple[float, float]:
        """On and off angle (rad) between the nodes, at the edge beyond them; for either direction of motion."""
        table = self.braking if braking else self.driving
        at_speed = [
            [float(np.interp(abs(speed), self.speeds, table[:, k, side])) for k in range(len(self.currents))]
            for side in (0, 1)
        ]
        on, off = (float(np.interp(abs(current), self.currents, row)) for row in at_speed)
        return on, off


@dataclass(frozen=True, slots=True)
class SwitchedReluctance:
    """Data sheet of a switched reluctance motor.

    Raises
    ------
    ModelError
        A field outside its range; an aligned inductance that is not the larger one.
    """

    resistance: float = parameter(meaning="of a phase", unit="ohm", above=0.0, example=0.5)
    unaligned_inductance: float = parameter(meaning="of a phase", unit="H", above=0.0, example=2e-3)
    aligned_inductance: float = parameter(meaning="of a phase", unit="H", above=0.0, example=10e-3)
    rotor_poles: int = parameter(meaning="Z", least=2, most=100, example=4)
    phases: int = parameter(meaning="m, 3 of a 6/4 motor", least=3, most=12, example=3)
    max_voltage: float = parameter(meaning="supply", unit="V", above=0.0, example=48.0)
    max_current: float = parameter(meaning="of a phase", unit="A", above=0.0, example=10.0)
    sensor: str = parameter("optical", meaning="of the rotor's angle", choices=("optical", "hall"))
    sensor_steps: int = parameter(0, meaning="steps a period that it tells; 0: without steps", least=0, most=100_000)
    sensor_offset: float = parameter(
        0.0, meaning="that it adds to the electrical angle", unit="rad", least=-math.pi, most=math.pi
    )

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        require("SwitchedReluctance", "aligned_inductance", self.aligned_inductance, above=self.unaligned_inductance)

    @property
    def resolution(self) -> float:
        """Step of the sensor, electrical rad; three Hall sensors a phase pair tell two edges a phase and period."""
        steps = self.sensor_steps or (2 * self.phases if self.sensor == "hall" else 0)
        return TURN / steps if steps else 0.0

    def params(self) -> ReluctanceParams:
        """Params of the compiled steps."""
        mean = 0.5 * (self.aligned_inductance + self.unaligned_inductance)
        swing = 0.5 * (self.aligned_inductance - self.unaligned_inductance)
        return ReluctanceParams(
            self.resistance, mean, swing, float(self.rotor_poles), float(self.phases), self.max_voltage
        )

    def cycle(self, angles: tuple[float, float], speed: float, current: float) -> ReluctanceCycle:
        """Settled period with on and off `angles` (rad), at a speed (rad/s, not 0) and a current asked for (A).

        Either direction of motion is the other one's mirror, a sensor's offset apart, which leads in one and lags in
        the other: torque is told in the direction of motion.
        """
        require("SwitchedReluctance.cycle", "speed", abs(speed), above=0.0)
        require("SwitchedReluctance.cycle", "current", current, least=0.0)
        on, off = angles
        return reluctance_cycle(
            self.params(),
            on,
            off,
            min(current, self.max_current),
            abs(speed),
            math.copysign(1.0, speed) * self.sensor_offset,
            self.resolution,
        )

    def best_angles(self, speed: float, current: float, *, braking: bool = False) -> tuple[float, float]:
        """On and off angle (rad) with the greatest mean torque, driving or braking, a sensor offset left out.

        Raises
        ------
        OutOfLimits
            No pair of angles makes such torque at this speed.
        """
        true = self.params()
        wanted = -1.0 if braking else 1.0
        middle_on, middle_off = (0.75 * math.pi, 1.75 * math.pi) if braking else (-0.25 * math.pi, 0.75 * math.pi)
        best, spread = (middle_on, middle_off), 0.5 * math.pi
        made = -math.inf
        for _ in range(5):
            centre = best
            for i in range(-3, 4):
                for k in range(-3, 4):
                    on, off = centre[0] + spread * i / 3.0, centre[1] + spread * k / 3.0
                    if not 0.05 < off - on < 1.5 * math.pi:
                        continue
                    torque = wanted * reluctance_cycle(true, on, off, current, abs(speed), 0.0, 0.0).torque
                    if torque > made:
                        best, made = (on, off), torque
            spread *= 0.4
        if made <= 0.0:
            raise OutOfLimits(
                f"no switching angles {'brake' if braking else 'drive'} at {speed:g} rad/s, {current:g} A"
            )
        return best

    def angle_table(self, speeds: Sequence[float], currents: Sequence[float]) -> AngleTable:
        """Return the best angles at each of some speeds (rad/s, above 0) and currents (A)."""
        pairs = [
            np.array([[self.best_angles(speed, i, braking=braking) for i in currents] for speed in speeds])
            for braking in (False, True)
        ]
        return AngleTable(np.array(speeds, dtype=float), np.array(currents, dtype=float), pairs[0], pairs[1])

    def torque(self, speed: float, current: float | None = None) -> float:
        """Greatest mean torque, N m, at a speed (rad/s) and current (A; the largest unless given): characteristic."""
        current = self.max_current if current is None else current
        speed = max(abs(speed), 1e-3)
        return self.cycle(self.best_angles(speed, current), speed, current).torque


@loop
def _between(nodes: Array, value: float) -> tuple[int, int, float]:
    """Nodes around a value, and how far it is from the first to the second; the last ones beyond the ends."""
    last = nodes.size - 1
    if value <= nodes[0] or last == 0:
        return 0, 0, 0.0
    if value >= nodes[last]:
        return last, last, 0.0
    k = int(np.searchsorted(nodes, value)) - 1
    return k, k + 1, float((value - nodes[k]) / (nodes[k + 1] - nodes[k]))


@loop
def _angle(table: Array, side: int, speeds: Array, currents: Array, speed: float, current: float) -> float:
    i, j, a = _between(speeds, speed)
    k, m, b = _between(currents, current)
    low = table[i, k, side] + a * (table[j, k, side] - table[i, k, side])
    high = table[i, m, side] + a * (table[j, m, side] - table[i, m, side])
    return low + b * (high - low)


@loop
def _run(
    params: ReluctanceParams,
    nodes: tuple[Array, Array, Array, Array],
    asked: Array,
    load: Array,
    shaft: tuple[float, float, float, float],
    sensor: tuple[float, float],
    flux: Array,
    out: Array,
) -> None:
    """Run; a row of `out` each sample: speed, torque, currents."""
    speeds, currents, driving, braking = nodes
    inertia, viscous, speed, dt = shaft
    offset, resolution = sensor
    angle = 0.0
    for k in range(asked.size):
        forward = 1.0 if speed > 0.0 or (speed == 0.0 and asked[k] >= 0.0) else -1.0
        table = driving if asked[k] * forward >= 0.0 else braking
        on = _angle(table, 0, speeds, currents, abs(speed), abs(asked[k]))
        off = _angle(table, 1, speeds, currents, abs(speed), abs(asked[k]))
        middle = angle + 0.5 * dt * speed
        torque = 0.0
        for phase in range(flux.size):
            shift = 2.0 * math.pi * phase / flux.size
            x, now, then = (
                params.poles * middle - shift,
                params.poles * angle - shift + offset,
                params.poles * (angle + dt * speed) - shift,
            )
            seen = forward * (math.floor(now / resolution) * resolution if resolution > 0.0 else now)
            fall = reluctance_step(params, flux[phase], -params.voltage, x, dt)
            rise = reluctance_step(params, flux[phase], params.voltage, x, dt)
            inductance = params.mean - params.swing * math.cos(then)
            held = inductance * abs(asked[k]) if reluctance_on(on, off, seen) else 0.0
            flux[phase] = min(max(held, fall), rise)
            out[k, 2 + phase] = flux[phase] / inductance
            torque += reluctance_torque(params, out[k, 2 + phase], then)
        angle += dt * speed
        speed += dt * (torque - load[k] - viscous * speed) / inertia
        out[k, 0], out[k, 1] = speed, torque


@dataclass(frozen=True, slots=True)
class ReluctanceRun:
    """A run of a reluctance motor after each sample: speed (rad/s), torque (N m), (n,); phase currents (A), (n, m)."""

    speed: Array
    torque: Array
    current: Array


def run_reluctance(
    motor: SwitchedReluctance,
    table: AngleTable,
    current: ArrayLike,
    load: ArrayLike = 0.0,
    *,
    inertia: float,
    dt: float,
    viscous: float = 0.0,
    speed: float = 0.0,
) -> ReluctanceRun:
    """Run a motor in all four quadrants by a table of switching angles, compiled.

    Parameters
    ----------
    motor : with its sensor.
    table : of switching angles.
    current : asked for, A, (n,); its sign is that of the torque.
    load : torque against positive motion, N m, (n,) or one for all.
    inertia : of rotor and load, kg m^2.
    dt : between samples, s.
    viscous : friction, N m s/rad.
    speed : at the start, rad/s.

    Raises
    ------
    ModelError, ShapeError, NotFinite
    """
    asked = np.clip(finite_array("current", current, ["n"]), -motor.max_current, motor.max_current)
    against = finite("load", load)
    if asked.size == 0 or against.shape not in ((), asked.shape):
        raise ShapeError(f"current has shape {asked.shape}, load {against.shape}; (n,) and (n,) or one are needed")
    require("run_reluctance", "inertia", inertia, above=0.0)
    require("run_reluctance", "dt", dt, above=0.0)
    require("run_reluctance", "viscous", viscous, least=0.0)
    require("run_reluctance", "speed", speed)
    out, flux = np.empty((asked.size, 2 + motor.phases)), np.zeros(motor.phases)
    _run(
        motor.params(),
        (table.speeds, table.currents, table.driving, table.braking),
        asked,
        np.ascontiguousarray(np.broadcast_to(against, asked.shape)),
        (inertia, viscous, float(speed), dt),
        (motor.sensor_offset, motor.resolution),
        flux,
        out,
    )
    return ReluctanceRun(out[:, 0], out[:, 1], out[:, 2:])

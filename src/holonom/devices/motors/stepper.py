"""Hybrid stepping motor with two phases: microsteps, resonance, lost steps, pull-out (spec 03.1).

The field points to the commanded angle; the rotor hangs on it by `m = -M_H sin(Z (theta - theta_c))`, Z the teeth of
the rotor (50 of a motor with 200 steps): four full steps are one period. Acarnley, Stepping Motors, 4th ed. 2002,
ch. 3-5; pull-out at speed from the voltage as of a synchronous machine.
"""

from __future__ import annotations

import math
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
    "Stepper",
    "StepperParams",
    "StepperRun",
    "StepperState",
    "run_stepper",
    "stepper_step",
    "stepper_torque",
]


class StepperParams(NamedTuple):
    """M_H and detent torque in N m, rotor teeth, inertia in kg m^2, friction in N m s/rad."""

    holding_torque: float
    detent_torque: float
    teeth: float
    inertia: float
    viscous: float


class StepperState(NamedTuple):
    """Angle of the shaft, rad, and its speed, rad/s."""

    angle: float
    speed: float


@loop
def stepper_torque(params: StepperParams, angle: float, command: float) -> float:
    """Torque on the rotor, N m, at a shaft angle (rad) while the field points to `command` (rad of the shaft)."""
    pull = -params.holding_torque * math.sin(params.teeth * (angle - command))
    return pull - params.detent_torque * math.sin(4.0 * params.teeth * angle)


@loop
def stepper_step(params: StepperParams, state: StepperState, command: float, load: float, dt: float) -> StepperState:
    """State `dt` s later under a load torque (N m, against positive motion); leapfrog, which keeps the energy."""
    middle = state.angle + 0.5 * dt * state.speed
    drive = stepper_torque(params, middle, command) - load
    damped = params.viscous * dt / params.inertia
    speed = (state.speed * (1.0 - 0.5 * damped) + dt * drive / params.inertia) / (1.0 + 0.5 * damped)
    return StepperState(middle + 0.5 * dt * speed, speed)


@loop
def _run(params: StepperParams, command: Array, load: Array, dt: float, angle: Array, speed: Array) -> None:
    state = StepperState(angle[0], speed[0])
    for k in range(command.size):
        state = stepper_step(params, state, command[k], load[k], dt)
        angle[k], speed[k] = state.angle, state.speed


@dataclass(frozen=True, slots=True)
class StepperRun:
    """Angle (rad) and speed (rad/s) of a stepping motor after each sample, (n,), and the full steps lost at the end."""

    angle: Array
    speed: Array
    lost_steps: int


@dataclass(frozen=True, slots=True)
class Stepper:
    """Data sheet of a two-phase hybrid stepping motor.

    Raises
    ------
    ModelError
    """

    holding_torque: float = parameter(meaning="M_H, both phases at rated current", unit="N m", above=0.0, example=0.4)
    rotor_teeth: int = parameter(meaning="Z; four full steps each", least=1, most=1000, example=50)
    inertia: float = parameter(meaning="of rotor and load", unit="kg m2", above=0.0, example=1.04e-5)
    viscous: float = parameter(0.0, meaning="friction", unit="N m s/rad", least=0.0)
    detent_torque: float = parameter(0.0, meaning="without current", unit="N m", least=0.0)
    current: float = parameter(1.0, meaning="rated, peak of a phase", unit="A", above=0.0)
    resistance: float = parameter(1.0, meaning="of a phase", unit="ohm", above=0.0)
    inductance: float = parameter(2e-3, meaning="of a phase", unit="H", above=0.0)
    voltage: float = parameter(24.0, meaning="of the driver", unit="V", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def steps_per_turn(self) -> int:
        """Full steps."""
        return 4 * self.rotor_teeth

    @property
    def full_step(self) -> float:
        """Angle of one, rad."""
        return 2.0 * math.pi / self.steps_per_turn

    @property
    def natural_frequency(self) -> float:
        """Of small swings about a step, Hz: `sqrt(Z M_H / J) / 2 pi`; step rates near it and its parts resonate."""
        stiffness = self.rotor_teeth * (self.holding_torque + 4.0 * self.detent_torque)
        return math.sqrt(stiffness / self.inertia) / (2.0 * math.pi)

    @property
    def lost_steps_multiple_of(self) -> int:
        """Steps are lost by whole periods of the torque: four, or a multiple."""
        return 4

    def params(self) -> StepperParams:
        """Params of `stepper_step`."""
        return StepperParams(
            self.holding_torque, self.detent_torque, float(self.rotor_teeth), self.inertia, self.viscous
        )

    def currents(self, step: float) -> tuple[float, float]:
        """Currents (A) of the two phases for a position in full steps, microsteps as its fractions."""
        require("Stepper.currents", "step", step)
        return self.current * math.cos(0.5 * math.pi * step), self.current * math.sin(0.5 * math.pi * step)

    def deflection(self, load: float) -> float:
        """How far a standing rotor gives way to a load (N m), in full steps: `asin(m / M_H) / (pi/2)`.

        Raises
        ------
        OutOfLimits
            A load above the holding torque: it slips.
        """
        require("Stepper.deflection", "load", load)
        if abs(load) >= self.holding_torque:
            raise OutOfLimits(
                f"a load of {load:g} N m on {self.holding_torque:g} N m of holding torque: it loses steps"
            )
        return math.asin(load / self.holding_torque) / (0.5 * math.pi)

    def microstep_torque(self, parts: int) -> float:
        """Torque (N m) that one microstep of `parts` in a full step adds at rest: `M_H sin(pi / 2 parts)`.

        Friction above it swallows microsteps.
        """
        require("Stepper.microstep_torque", "parts", parts, least=1)
        return self.holding_torque * math.sin(0.5 * math.pi / parts)

    def pull_out_torque(self, speed: float) -> float:
        """Greatest torque, N m, at a speed of the shaft (rad/s) without losing steps: the steady characteristic.

        Below the speed where the driver's voltage no longer makes the rated current it is the holding torque; above,
        that of a synchronous machine, `k (U/Z_e - w k R/(Z_e^2))` with `Z_e = |R + j Z w L|`.
        """
        require("Stepper.pull_out_torque", "speed", speed)
        w = abs(speed)
        k = self.holding_torque / self.current
        square = self.resistance**2 + (self.rotor_teeth * w * self.inductance) ** 2
        most = k * (self.voltage / math.sqrt(square) - w * k * self.resistance / square)
        return max(min(most - self.viscous * w, self.holding_torque), 0.0)

    def lost_steps(self, angle: float, command: float) -> int:
        """Full steps that a rotor at rest at `angle` (rad) has lost against its command (rad), signed."""
        periods = round((command - angle) * self.rotor_teeth / (2.0 * math.pi))
        return self.lost_steps_multiple_of * periods


def run_stepper(
    motor: Stepper, command: ArrayLike, load: ArrayLike = 0.0, *, dt: float, angle: float = 0.0, speed: float = 0.0
) -> StepperRun:
    """Run a stepping motor, compiled.

    Parameters
    ----------
    motor : with its load's inertia.
    command : where the field points, rad of the shaft, (n,): microsteps in steps as fine as they are.
    load : torque against positive motion, N m, (n,) or one for all.
    dt : between samples, s; a twentieth of the natural period at most.
    angle, speed : at the start, rad and rad/s.

    Raises
    ------
    ModelError, ShapeError, NotFinite
    """
    asked = finite_array("command", command, ["n"])
    against = finite("load", load)
    if asked.size == 0 or against.shape not in ((), asked.shape):
        raise ShapeError(f"command has shape {asked.shape}, load {against.shape}; (n,) and (n,) or one are needed")
    require("run_stepper", "dt", dt, above=0.0, most=0.05 / motor.natural_frequency)
    require("run_stepper", "angle", angle)
    require("run_stepper", "speed", speed)
    angles, speeds = np.full(asked.size, float(angle)), np.full(asked.size, float(speed))
    against = np.ascontiguousarray(np.broadcast_to(against, asked.shape))
    _run(motor.params(), asked, against, dt, angles, speeds)
    return StepperRun(angles, speeds, motor.lost_steps(float(angles[-1]), float(asked[-1])))

"""Three-phase induction motor: Kloss' characteristic, and the machine behind it in space vectors (spec 03.1).

Kloss 1907, without stator resistance: `m = 2 m_k / (s/s_k + s_k/s)`, s the slip. The dynamic machine, in stator
coordinates, amplitude-invariant, w the electrical speed:

    d psi_s/dt = u_s - R_s i_s,      d psi_r/dt = j w psi_r - R_r i_r,      m = 3/2 p Im(conj(psi_s) i_s).

Leonhard, Control of Electrical Drives, ch. 10.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["InductionMachine", "InductionMotor", "InductionParams", "InductionState", "induction_step"]


class InductionParams(NamedTuple):
    """R_s, R_r in ohm, L_s, L_r, L_m in H, pole pairs."""

    stator_resistance: float
    rotor_resistance: float
    stator_inductance: float
    rotor_inductance: float
    magnetising_inductance: float
    pole_pairs: float


class InductionState(NamedTuple):
    """Flux linkages of stator and rotor, V s, in stator coordinates."""

    stator: complex
    rotor: complex


@loop
def induction_step(
    params: InductionParams, state: InductionState, voltage: complex, speed: float, dt: float
) -> tuple[InductionState, float]:
    """Fluxes `dt` s later, exact for held voltage (V, stator) and speed (rad/s); and the torque then, N m (03.1)."""
    ls, lr, lm = params.stator_inductance, params.rotor_inductance, params.magnetising_inductance
    rs, rr = params.stator_resistance, params.rotor_resistance
    spread = ls * lr - lm * lm
    a, b = complex(-rs * lr / spread), complex(rs * lm / spread)
    c, d = complex(rr * lm / spread), -rr * ls / spread + 1j * params.pole_pairs * speed
    det = a * d - b * c
    settled_s, settled_r = -d * voltage / det, c * voltage / det
    mean = 0.5 * (a + d)
    half = cmath.sqrt(0.25 * (a - d) * (a - d) + b * c)
    plus, minus = cmath.exp((mean + half) * dt), cmath.exp((mean - half) * dt)
    cosine = 0.5 * (plus + minus)
    sine = 0.5 * (plus - minus) / half if abs(half) * dt > 1e-6 else cmath.exp(mean * dt) * dt
    x, y = state.stator - settled_s, state.rotor - settled_r
    stator = settled_s + cosine * x + sine * ((a - mean) * x + b * y)
    rotor = settled_r + cosine * y + sine * (c * x + (d - mean) * y)
    current = (lr * stator - lm * rotor) / spread
    torque = 1.5 * params.pole_pairs * (stator.conjugate() * current).imag
    return InductionState(stator, rotor), torque


@dataclass(frozen=True, slots=True)
class InductionMotor:
    """Steady induction motor by Kloss' formula.

    Raises
    ------
    ModelError
    """

    breakdown_torque: float = parameter(meaning="m_k, the greatest", unit="N m", above=0.0, example=30.0)
    breakdown_slip: float = parameter(meaning="s_k, where it is", above=0.0, most=10.0, example=0.2)
    synchronous_speed: float = parameter(meaning="of the field, at the shaft", unit="rad/s", above=0.0, example=157.08)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def starting_torque(self) -> float:
        """At standstill, N m."""
        return self.torque_at_slip(1.0)

    def torque_at_slip(self, slip: float) -> float:
        """Torque, N m, at a slip; negative when it is driven above the field's speed."""
        require("InductionMotor.torque_at_slip", "slip", slip)
        if slip == 0.0:
            return 0.0
        return 2.0 * self.breakdown_torque / (slip / self.breakdown_slip + self.breakdown_slip / slip)

    def torque(self, speed: float) -> float:
        """Torque, N m, at a speed of the shaft (rad/s)."""
        require("InductionMotor.torque", "speed", speed)
        return self.torque_at_slip(1.0 - speed / self.synchronous_speed)


@dataclass(frozen=True, slots=True)
class InductionMachine:
    """Equivalent circuit of an induction machine; rotor values as seen from the stator, of one phase.

    Raises
    ------
    ModelError
        A field outside its range; a magnetising inductance that is not the smallest one.
    """

    stator_resistance: float = parameter(meaning="R_s", unit="ohm", above=0.0, example=1.4)
    rotor_resistance: float = parameter(meaning="R_r", unit="ohm", above=0.0, example=1.0)
    stator_inductance: float = parameter(meaning="L_s, with its leakage", unit="H", above=0.0, example=0.18)
    rotor_inductance: float = parameter(meaning="L_r, with its leakage", unit="H", above=0.0, example=0.18)
    magnetising_inductance: float = parameter(meaning="L_m", unit="H", above=0.0, example=0.17)
    pole_pairs: int = parameter(meaning="p", least=1, most=100, example=2)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        least = min(self.stator_inductance, self.rotor_inductance)
        if self.magnetising_inductance >= least:
            raise ModelError(
                f"InductionMachine: magnetising_inductance is {self.magnetising_inductance:g} H; it must be below "
                f"{least:g} H, the least of stator and rotor inductance, which hold it and their leakage"
            )

    def params(self) -> InductionParams:
        """Params of `induction_step`."""
        return InductionParams(
            self.stator_resistance,
            self.rotor_resistance,
            self.stator_inductance,
            self.rotor_inductance,
            self.magnetising_inductance,
            float(self.pole_pairs),
        )

    def torque(self, voltage: float, frequency: float, speed: float) -> float:
        """Settled torque, N m, at a voltage (V, peak of a phase), frequency (Hz) and speed of the shaft (rad/s)."""
        require("InductionMachine.torque", "frequency", frequency, above=0.0)
        w = 2.0 * math.pi * frequency
        slip = w - self.pole_pairs * speed
        rotor = 1j * slip * self.magnetising_inductance / (self.rotor_resistance + 1j * slip * self.rotor_inductance)
        through = self.stator_inductance - self.magnetising_inductance * rotor  # flux of the stator per its current
        current = voltage / (self.stator_resistance + 1j * w * through)
        return 1.5 * self.pole_pairs * ((through * current).conjugate() * current).imag

    def kloss(self, voltage: float, frequency: float) -> InductionMotor:
        """Kloss' motor of this machine, which leaves the stator's resistance out.

        `m_k = 3/4 p (U/w)^2 (L_m/L_s)^2 / (s L_r)`, `s_k = R_r / (w s L_r)`, s L_r the rotor's stray inductance.
        """
        require("InductionMachine.kloss", "frequency", frequency, above=0.0)
        require("InductionMachine.kloss", "voltage", voltage, above=0.0)
        w = 2.0 * math.pi * frequency
        stray = self.rotor_inductance - self.magnetising_inductance**2 / self.stator_inductance
        linked = voltage / w * self.magnetising_inductance / self.stator_inductance
        return InductionMotor(
            0.75 * self.pole_pairs * linked**2 / stray, self.rotor_resistance / (w * stray), w / self.pole_pairs
        )

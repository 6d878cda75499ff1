"""Permanent-magnet synchronous motor, or brushless DC motor with sinusoidal back-emf, in dq coordinates (spec 03.1).

Amplitude-invariant (peak) values of a phase; w is the electrical speed, p times the shaft's:

    u_d = R i_d + L_d di_d/dt - w L_q i_q,      u_q = R i_q + L_q di_q/dt + w (L_d i_d + psi),
    m = 3/2 p (psi + (L_d - L_q) i_d) i_q.

Leonhard, Control of Electrical Drives, ch. 14; Morimoto et al., IEEE Trans. Ind. Appl. 26(5), 1990 (limits).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.compiled import sincos
from holonom.trace.code.loops import loop

__all__ = ["Dq", "Pmsm", "PmsmParams", "pmsm_step", "pmsm_torque"]


COSINE = tuple(1.0 / math.factorial(2 * k) for k in range(9))
SINE = tuple(1.0 / math.factorial(2 * k + 1) for k in range(9))
"""Taylor's coefficients of cosh(sqrt x) and sinh(sqrt x)/sqrt x."""


class Dq(NamedTuple):
    """A pair of currents (A) or voltages (V), peak values."""

    d: float
    q: float


class PmsmParams(NamedTuple):
    """R in ohm, L_d and L_q in H, psi in V s, pole pairs."""

    resistance: float
    inductance_d: float
    inductance_q: float
    flux: float
    pole_pairs: float


@loop
def pmsm_torque(params: PmsmParams, current: Dq) -> float:
    """Torque, N m: `3/2 p (psi + (L_d - L_q) i_d) i_q`."""
    saliency = params.inductance_d - params.inductance_q
    return 1.5 * params.pole_pairs * (params.flux + saliency * current.d) * current.q


@loop
def _decayed(x: float, y: float) -> tuple[float, float]:
    """Return cosh(sqrt x) and sinh(sqrt x)/sqrt x times exp y; of a negative x that is cos and sin."""
    decay = math.exp(y)
    if abs(x) <= 1.0:  # Taylor's series without a root, the first term left out below 2e-16
        c, s = COSINE[8], SINE[8]
        for k in range(7, -1, -1):
            c, s = COSINE[k] + x * c, SINE[k] + x * s
        return decay * c, decay * s
    root = math.sqrt(abs(x))
    if x < 0.0:
        s, c = sincos(root)
        return decay * c, decay * s / root
    slow, fast = math.exp(y + root), math.exp(y - root)
    return 0.5 * (slow + fast), 0.5 * (slow - fast) / root


@loop
def pmsm_step(params: PmsmParams, current: Dq, voltage: Dq, speed: float, dt: float) -> Dq:
    """Currents (A) `dt` s later; exact while voltages (V, dq) and speed (rad/s, of the shaft) are held (03.1)."""
    w = params.pole_pairs * speed
    ld, lq, r = params.inductance_d, params.inductance_q, params.resistance
    per_d, per_q = 1.0 / ld, 1.0 / lq
    mean, apart = -0.5 * r * (per_d + per_q), 0.5 * r * (per_d - per_q)
    back = voltage.q - w * params.flux
    per_det = 1.0 / (r * r + w * w * ld * lq)
    settled_d, settled_q = (r * voltage.d + w * lq * back) * per_det, (r * back - w * ld * voltage.d) * per_det
    cosine, sine = _decayed((apart * apart - w * w) * dt * dt, mean * dt)
    sine *= dt
    d, q = current.d - settled_d, current.q - settled_q
    return Dq(
        settled_d + cosine * d + sine * (w * lq * per_d * q - apart * d),
        settled_q + cosine * q + sine * (apart * q - w * ld * per_q * d),
    )


@dataclass(frozen=True, slots=True)
class Pmsm:
    """Data sheet of a permanent-magnet synchronous motor; values of one phase, currents as peak values.

    A sheet's terminal resistance and inductance are twice those of a phase; `flux` is the torque constant per peak
    ampere over `3/2 p`.

    Raises
    ------
    ModelError
        A field outside its range; one that is not finite.
    """

    resistance: float = parameter(meaning="of a phase", unit="ohm", above=0.0, example=0.232)
    inductance_d: float = parameter(meaning="along the magnets", unit="H", above=0.0, example=0.161e-3)
    inductance_q: float = parameter(meaning="across them", unit="H", above=0.0, example=0.161e-3)
    flux: float = parameter(meaning="psi, linkage of the magnets, peak", unit="V s", above=0.0, example=2.09167e-3)
    pole_pairs: int = parameter(meaning="p", least=1, most=100, example=8)
    rotor_inertia: float = parameter(meaning="without the load", unit="kg m2", above=0.0, example=1.35e-5)
    max_voltage: float = parameter(meaning="of the DC link", unit="V", above=0.0, example=24.0)
    max_current: float = parameter(meaning="peak of a phase", unit="A", above=0.0, example=20.0)
    modulation: str = parameter("space_vector", meaning="of the bridge", choices=("space_vector", "sine"))
    demagnetising_current: float = parameter(
        math.inf, meaning="against the magnets, peak; a limit of its own", unit="A", above=0.0, most=math.inf
    )

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def phase_voltage(self) -> float:
        """Radius of the voltage circle, V peak: `U/sqrt 3` by space vectors, `U/2` by sines."""
        return self.max_voltage / (math.sqrt(3.0) if self.modulation == "space_vector" else 2.0)

    @property
    def torque_constant(self) -> float:
        """Torque per peak ampere of i_q, N m/A: `3/2 p psi`."""
        return 1.5 * self.pole_pairs * self.flux

    @property
    def no_load_speed(self) -> float:
        """Speed of the shaft, rad/s, at which the back-emf fills the voltage circle (no field weakening)."""
        return self.phase_voltage / (self.pole_pairs * self.flux)

    def params(self) -> PmsmParams:
        """Params of `pmsm_step` and `pmsm_torque`."""
        return PmsmParams(
            self.resistance, self.inductance_d, self.inductance_q, self.flux, float(self.pole_pairs)
        )  # fmt: skip

    def torque(self, current: Dq) -> float:
        """Torque, N m, of currents (A, peak)."""
        return float(pmsm_torque(self.params(), Dq(float(current.d), float(current.q))))

    def voltage(self, current: Dq, speed: float) -> Dq:
        """Voltages (V) that hold currents (A) at a speed of the shaft (rad/s)."""
        w = self.pole_pairs * speed
        return Dq(
            self.resistance * current.d - w * self.inductance_q * current.q,
            self.resistance * current.q + w * (self.inductance_d * current.d + self.flux),
        )

    def most_torque_per_ampere(self, current: float) -> Dq:
        """Currents (A) of a given peak that make the greatest torque; a negative peak, the greatest backwards.

        With `D = L_q - L_d`: `i_d = (psi - sqrt(psi^2 + 8 D^2 I^2)) / (4 D)`.
        """
        require("Pmsm.most_torque_per_ampere", "current", current)
        saliency = self.inductance_q - self.inductance_d
        # the same, without the difference of nearly equal numbers
        root = math.sqrt(self.flux**2 + 8.0 * (saliency * current) ** 2)
        d = -2.0 * saliency * current * current / (self.flux + root)
        return Dq(d, math.copysign(math.sqrt(current * current - d * d), current))

    def short_circuit(self, speed: float) -> tuple[Dq, float]:
        """Currents (A) and braking torque (N m, against the speed) with all terminals joined, settled at a speed."""
        require("Pmsm.short_circuit", "speed", speed)
        w = self.pole_pairs * speed
        det = self.resistance**2 + w * w * self.inductance_d * self.inductance_q
        found = Dq(-w * w * self.inductance_q * self.flux / det, -self.resistance * w * self.flux / det)
        return found, self.torque(found)

    def short_circuit_brake(self) -> tuple[float, float]:
        """Greatest torque (N m) of the short-circuit brake and its speed (rad/s); at `w = R/L` without saliency."""
        from scipy.optimize import minimize_scalar

        middle = self.resistance / self.pole_pairs / math.sqrt(self.inductance_d * self.inductance_q)
        found = minimize_scalar(
            lambda log: self.short_circuit(math.exp(log))[1],
            bounds=(math.log(0.05 * middle), math.log(20.0 * middle)),
            method="bounded",
            options={"xatol": 1e-10},
        )
        return -float(found.fun), math.exp(float(found.x))

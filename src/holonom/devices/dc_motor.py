"""DC servo motor: its data sheet, and the constants of its transfer functions (spec 03.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.kernels import ArmatureParams

__all__ = ["DcMotor"]


@dataclass(frozen=True, slots=True)
class DcMotor:
    """Data sheet of a permanent-magnet DC motor, as Maxon prints it, in SI units.

    Attributes
    ----------
    resistance, inductance
        Armature, ohm and H.
    torque_constant, back_emf_constant
        `k2 Phi` in N m/A and `k1 Phi` in V s/rad; equal where a sheet states only one.
    rotor_inertia
        kg m^2, without the load.
    max_voltage, max_current
        Supply in V; limit of the power stage in A.
    no_load_current
        A, the current that turns the free motor; its torque is the motor's own friction.

    Raises
    ------
    ModelError
        A field that is not a finite positive number (`no_load_current` may be 0).
    """

    resistance: float
    inductance: float
    torque_constant: float
    back_emf_constant: float
    rotor_inertia: float
    max_voltage: float
    max_current: float
    no_load_current: float = 0.0

    def __post_init__(self) -> None:
        for field in (
            "resistance",
            "inductance",
            "torque_constant",
            "back_emf_constant",
            "rotor_inertia",
            "max_voltage",
            "max_current",
        ):
            require("DcMotor", field, getattr(self, field), above=0.0)
        require("DcMotor", "no_load_current", self.no_load_current, least=0.0)

    @property
    def speed_gain(self) -> float:
        """`A_M = 1 / k_e`, rad/s per V."""
        return 1.0 / self.back_emf_constant

    @property
    def load_gain(self) -> float:
        """`A_T = -R / (k_t k_e)`, rad/s per N m of load."""
        return -self.resistance / (self.torque_constant * self.back_emf_constant)

    @property
    def electrical_time_constant(self) -> float:
        """`T_V = L / R`, s."""
        return self.inductance / self.resistance

    @property
    def stall_torque(self) -> float:
        """Torque at the full supply and standstill, N m (the power stage may not allow its current)."""
        return self.torque_constant * self.max_voltage / self.resistance

    @property
    def no_load_speed(self) -> float:
        """Speed of the free motor at the full supply, rad/s."""
        return (self.max_voltage - self.resistance * self.no_load_current) / self.back_emf_constant

    def mechanical_time_constant(self, load_inertia: float = 0.0) -> float:
        """`T_M = Theta R / (k_t k_e)`, s; `load_inertia` (kg m^2 at the motor shaft) adds to the rotor's."""
        return -(self.rotor_inertia + load_inertia) * self.load_gain

    def damping(self, load_inertia: float = 0.0) -> float:
        """`zeta = sqrt(T_M / T_V) / 2`; below 1 the free motor oscillates (`T_M < 4 T_V`)."""
        return 0.5 * math.sqrt(self.mechanical_time_constant(load_inertia) / self.electrical_time_constant)

    def armature(self, dt: float) -> ArmatureParams:
        """Params of `armature_step` for the interval `dt` (s)."""
        require("DcMotor.armature", "dt", dt, above=0.0)
        return ArmatureParams(
            decay=math.exp(-dt / self.electrical_time_constant),
            conductance=1.0 / self.resistance,
            back_emf=self.back_emf_constant,
            max_voltage=self.max_voltage,
        )

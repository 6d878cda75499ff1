"""DC servo motor: its data sheet, and the constants of its transfer functions (spec 03.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.motors.kernels import ArmatureParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["DcMotor", "mean_weight"]

SHORT = 1e-4  # electrical time constants, below which a series is nearer than the formula


def mean_weight(electrical_times: float) -> float:
    """Weight `m` of the later current in its mean over an interval: `(1 - m) i_0 + m i_1`, exact for held `u`, `w`.

    The interval is given in electrical time constants L/R; a short one has the trapezoid's 1/2, a long one 1.
    """
    x = electrical_times
    return 0.5 + x / 12.0 if x < SHORT else -1.0 / math.expm1(-x) - 1.0 / x


@dataclass(frozen=True, slots=True)
class DcMotor:
    """Data sheet of a permanent-magnet DC motor, as Maxon prints it, in SI units.

    The two constants are equal where a sheet states only one. The torque of the no-load current is the motor's own
    friction.

    Raises
    ------
    ModelError
        A field that is not a finite positive number (`no_load_current` may be 0).
    """

    resistance: float = parameter(meaning="armature", unit="ohm", above=0.0, example=2.1)
    inductance: float = parameter(meaning="armature", unit="H", above=0.0, example=3.4e-3)
    torque_constant: float = parameter(meaning="k2 Phi, torque per current", unit="N m/A", above=0.0, example=0.189)
    back_emf_constant: float = parameter(meaning="k1 Phi, voltage per speed", unit="V s/rad", above=0.0, example=0.189)
    rotor_inertia: float = parameter(meaning="without the load", unit="kg m2", above=0.0, example=2e-4)
    max_voltage: float = parameter(meaning="supply", unit="V", above=0.0, example=40.0)
    max_current: float = parameter(meaning="limit of the power stage", unit="A", above=0.0, example=10.0)
    no_load_current: float = parameter(0.0, meaning="current that turns the free motor", unit="A", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

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

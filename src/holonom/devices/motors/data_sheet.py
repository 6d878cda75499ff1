"""A motor's data sheet with the keys that vendors print, and the DC motor that it describes (spec 03.1)."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.motors.thermal import ThermalModel
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["RPM", "MotorSheet"]

RPM = math.pi / 30.0
"""One rpm in rad/s."""


def _printed(meaning: str, unit: str, *, zero: bool = False) -> float | None:
    """Field of a number that a sheet may print."""
    bound = {"least": 0.0} if zero else {"above": 0.0}
    made: float | None = parameter(None, meaning=meaning, unit=unit, **bound)  # type: ignore[arg-type]
    return made


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorSheet:
    """What a data sheet prints, each number or none, in SI; speeds in rpm and `kn` in rpm/V, as printed.

    Of an electronically commutated motor the terminal (phase to phase) values, as vendors give them.

    Raises
    ------
    ModelError
        A number that is not finite and positive.
    """

    U: float | None = _printed("nominal voltage", "V")
    n0: float | None = _printed("no-load speed", "rpm")
    I0: float | None = _printed("no-load current", "A", zero=True)
    nN: float | None = _printed("nominal speed", "rpm")
    MN: float | None = _printed("nominal torque", "N m")
    IN: float | None = _printed("nominal current", "A")
    MH: float | None = _printed("stall torque at U", "N m")
    IA: float | None = _printed("stall current at U", "A")
    eta_max: float | None = _printed("largest efficiency", "")
    R: float | None = _printed("terminal resistance at 25 degrees", "ohm")
    L: float | None = _printed("terminal inductance", "H")
    kM: float | None = _printed("torque constant", "N m/A")
    kn: float | None = _printed("speed constant", "rpm/V")
    gradient_rpm_per_mNm: float | None = _printed("speed lost per torque", "rpm/mNm")
    tau_m: float | None = _printed("mechanical time constant", "s")
    J: float | None = _printed("rotor inertia", "kg m2")
    Rth1: float | None = _printed("thermal resistance from housing to air", "K/W")
    Rth2: float | None = _printed("thermal resistance from winding to housing", "K/W")
    tw: float | None = _printed("thermal time constant of the winding", "s")
    ts: float | None = _printed("thermal time constant of the motor", "s")
    T_max: float | None = _printed("largest winding temperature, 155 unless given", "degC")
    I_demag: float | None = _printed("current that demagnetises the magnets", "A")
    n_max: float | None = _printed("largest speed of bearings and commutation", "rpm")
    Ke_V_per_krpm: float | None = _printed("back-emf constant", "V/krpm")
    Kt: float | None = _printed("torque constant of a servo motor", "N m/A")
    stall_current: float | None = _printed("continuous current at standstill", "A")
    stall_torque: float | None = _printed("continuous torque at standstill", "N m")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def torque_constant(self) -> float | None:
        """Torque per current, N m/A: `kM`, `Kt`, or else the back-emf constant."""
        return next((k for k in (self.kM, self.Kt, self.back_emf_constant) if k is not None), None)

    @property
    def back_emf_constant(self) -> float | None:
        """Voltage per speed, V s/rad: of `Ke_V_per_krpm`, `kn`, or else the torque constant."""
        if self.Ke_V_per_krpm is not None:
            return 1e-3 * self.Ke_V_per_krpm / RPM
        if self.kM is not None or self.kn is None:
            return self.kM if self.kM is not None else self.Kt
        return 1.0 / (self.kn * RPM)

    @property
    def rotor_inertia(self) -> float | None:
        """Inertia, kg m^2: `J`, or what `tau_m = R J / k^2` says of it."""
        k = self.torque_constant
        if self.J is None and self.tau_m is not None and self.R is not None and k is not None:
            return self.tau_m * k * k / self.R
        return self.J

    def motor(self, *, max_voltage: float | None = None, max_current: float | None = None) -> DcMotor:
        """Return the DC motor.

        Parameters
        ----------
        max_voltage : of the supply, V; the nominal one unless given.
        max_current : of the power stage, A; unless given what the voltage drives at standstill, below demagnetising.

        Raises
        ------
        ModelError
            What the sheet has to print for it and does not.
        """
        voltage = self.U if max_voltage is None else max_voltage
        needed = {
            "R": self.R,
            "L": self.L,
            "kM, Kt, kn or Ke_V_per_krpm": self.torque_constant,
            "J or tau_m": self.rotor_inertia,
            "U": voltage,
        }
        missing = [key for key, value in needed.items() if value is None]
        if missing:
            raise ModelError(
                f"MotorSheet: {'; '.join(missing)} missing; a motor needs {'; '.join(needed)}: add what is printed"
            )
        assert self.R is not None and self.L is not None and voltage is not None  # noqa: PT018
        k, back, inertia = self.torque_constant, self.back_emf_constant, self.rotor_inertia
        assert k is not None and back is not None and inertia is not None  # noqa: PT018
        if max_current is None:
            max_current = min(voltage / self.R, math.inf if self.I_demag is None else self.I_demag)
        return DcMotor(self.R, self.L, k, back, inertia, voltage, max_current, no_load_current=self.I0 or 0.0)

    def thermal(self, *, ambient: float = 25.0) -> ThermalModel:
        """Return the model of winding and housing.

        Parameters
        ----------
        ambient : of the air, degC.

        Raises
        ------
        ModelError
            R, Rth1, Rth2, tw or ts is not printed.
        """
        numbers = {key: getattr(self, key) for key in ("R", "Rth1", "Rth2", "tw", "ts")}
        missing = [key for key, value in numbers.items() if value is None]
        if missing:
            raise ModelError(f"MotorSheet: {', '.join(missing)} missing; the thermal model needs {', '.join(numbers)}")
        limit = 155.0 if self.T_max is None else self.T_max
        R, to_air, to_housing, winding, housing = numbers.values()
        return ThermalModel(R, to_air, to_housing, winding, housing, ambient, limit)

    def printed(self) -> dict[str, float]:
        """What the sheet prints, by key."""
        found = {field.name: getattr(self, field.name) for field in fields(self)}
        return {key: value for key, value in found.items() if value is not None}

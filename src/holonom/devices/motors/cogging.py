"""Cogging torque, and the dead zone it makes of a drive that is asked for little (spec 03.1).

`m_c = -m_max sin(N theta)`: N is the least common multiple of slots and poles, rest every 1/N turn. Hanselman 2003,
ch. 9.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices.motors.dc_motor import DcMotor
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Cogging", "CoggingParams", "DeadBand", "cogging_torque"]


class CoggingParams(NamedTuple):
    """Greatest torque in N m, periods per turn."""

    torque: float
    periods: float


@loop
def cogging_torque(params: CoggingParams, angle: float) -> float:
    """Torque of the slots on the rotor, N m, at a shaft angle (rad)."""
    return -params.torque * math.sin(params.periods * angle)


@dataclass(frozen=True, slots=True)
class DeadBand:
    """What moves nothing: current in A, voltage in V at standstill; how far the shaft gives way, rad."""

    current: float
    voltage: float
    angle: float


@dataclass(frozen=True, slots=True)
class Cogging:
    """Slots and poles of a motor.

    Raises
    ------
    ModelError
    """

    torque: float = parameter(meaning="greatest of the slots", unit="N m", least=0.0, example=0.01)
    slots: int = parameter(meaning="of the stator", least=1, most=1000, example=12)
    poles: int = parameter(meaning="of the rotor, twice the pole pairs", least=2, most=1000, example=8)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.poles % 2:
            raise ModelError(f"Cogging: poles is {self.poles}; poles come in pairs: give an even number")

    @property
    def periods(self) -> int:
        """N, places of rest in a turn."""
        return math.lcm(self.slots, self.poles)

    def params(self) -> CoggingParams:
        """Params of `cogging_torque`."""
        return CoggingParams(self.torque, float(self.periods))

    def energy(self, angle: float) -> float:
        """Stored energy, J, least at rest: what the torque is the negative slope of."""
        return self.torque / self.periods * (1.0 - math.cos(self.periods * angle))

    def dead_band(self, motor: DcMotor, friction: float = 0.0) -> DeadBand:
        """Return currents and voltages below which a motor, settled between slots, does not turn on.

        Parameters
        ----------
        motor : whose torque constant and resistance they are of.
        friction : Coulomb, N m, which adds to it.
        """
        most = self.torque + friction
        current = most / motor.torque_constant
        return DeadBand(current, motor.resistance * current, 0.5 * math.pi / self.periods if self.torque else 0.0)

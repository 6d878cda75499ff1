"""Backlash: a load that floats between two flanks, the play operator and its describing function (spec 03.2, 03.5)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from holonom.devices._checks import require
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["Backlash", "FlankParams", "flank_torque", "play_step"]


class FlankParams(NamedTuple):
    """Stiffness (N m/rad) and damping (N m s/rad) of a flank; what it is pressed by without twist, N m.

    The last is negative where there is a gap: minus the stiffness times half of it.
    """

    stiffness: float
    damping: float
    pressed: float


@loop
def play_step(half_gap: float, output: float, given: float) -> float:
    """Return where a load without inertia comes to rest in a gap of twice `half_gap`: the hysteresis of play.

    It stays where it is (`output`) while the driving side (`given`) moves inside the gap, and is taken along at its
    ends.
    """
    return min(max(output, given - half_gap), given + half_gap)


@loop
def flank_torque(params: FlankParams, twist: float, rate: float) -> float:
    """Torque (N m) on a load whose driving side is ahead by `twist` (rad) and gains at `rate` (rad/s).

    Each flank pushes, and never pulls: inside a gap the load floats. Of a pair pressed against both flanks, both carry
    until one lifts off.
    """
    p = params
    ahead, behind = p.stiffness * twist + p.pressed, p.pressed - p.stiffness * twist
    torque = 0.0
    if ahead > 0.0:
        torque += max(ahead + p.damping * rate, 0.0)
    if behind > 0.0:
        torque -= max(behind - p.damping * rate, 0.0)
    return torque


@dataclass(frozen=True, slots=True)
class Backlash:
    """A gap between the flanks of a gear, or a preloaded pair without one; angles and torques at one shaft.

    Two gears pressed against each other with a `preload` leave no gap up to that torque, twice the stiffness, and more
    friction: the part `rubbing` of what presses them.

    Raises
    ------
    ModelError
        A number outside its range, a preload and a gap.
    """

    gap: float = parameter(0.0, meaning="angle between the flanks", unit="rad", least=0.0)
    stiffness: float = parameter(1e4, meaning="of a flank", unit="N m/rad", above=0.0)
    damping: float = parameter(0.0, meaning="of a flank in contact", unit="N m s/rad", least=0.0)
    preload: float = parameter(0.0, meaning="which a pair is pressed with", unit="N m", least=0.0)
    rubbing: float = parameter(0.0, meaning="friction of a pressed pair over its preload", least=0.0, most=1.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.gap > 0.0 and self.preload > 0.0:
            raise ModelError(
                f"Backlash: gap is {self.gap:g} and preload {self.preload:g}; a pair pressed together has no gap: "
                "state one of them"
            )

    @property
    def coulomb(self) -> float:
        """Coulomb friction (N m) that the preload adds: a part of what presses both flanks."""
        return 2.0 * self.rubbing * self.preload

    def params(self) -> FlankParams:
        """Params of `flank_torque`."""
        pressed = self.preload if self.preload > 0.0 else -0.5 * self.stiffness * self.gap
        return FlankParams(self.stiffness, self.damping, pressed)

    def lost(self, torque: float) -> float:
        """Angle (rad) between the rest under a torque (N m) to one side and to the other, elastic twist included.

        Lost motion: the gap and twice the twist.
        """
        require("Backlash.lost", "torque", torque, least=0.0)
        if self.preload == 0.0:
            return self.gap + 2.0 * torque / self.stiffness
        both = min(torque, 2.0 * self.preload)  # one lifts off at the twist preload / stiffness
        return both / self.stiffness + 2.0 * (torque - both) / self.stiffness

    def describing_function(self, amplitude: float) -> complex:
        """First harmonic of `play_step` under a sine of an amplitude (rad), over the sine.

        0 where the sine is not larger than half of the gap: the load does not move. Slotine & Li, Applied Nonlinear
        Control, 1991, 5.2.
        """
        require("Backlash.describing_function", "amplitude", amplitude, above=0.0)
        part = 0.5 * self.gap / amplitude
        if part >= 1.0:
            return 0.0 + 0.0j
        x = 1.0 - 2.0 * part
        real = 0.5 + (math.asin(x) + x * math.sqrt(1.0 - x * x)) / math.pi
        return complex(real, -4.0 / math.pi * part * (1.0 - part))

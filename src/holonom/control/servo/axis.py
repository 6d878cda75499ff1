"""A servo axis in numbers, sample times of its loops, what a design does not reach."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from holonom.errors import ModelError, OutOfLimits

__all__ = ["DesignWarning", "SampleTimes", "ServoAxis"]


@dataclass(frozen=True, slots=True)
class ServoAxis:
    """A servo axis as its regulators see it: plain numbers, all at the motor shaft.

    Attributes
    ----------
    resistance, inductance
        Armature, ohm and H.
    torque_constant, back_emf_constant
        N m/A and V s/rad.
    inertia
        Rotor and load together, kg m^2 (load inertia at the joint divided by the ratio squared).
    viscous
        N m s/rad.
    load_inertia, stiffness
        Of the load alone, kg m^2 (0: not known), and of the shaft to it, N m/rad; infinite: rigid.
    gap
        Backlash between motor and load, rad.
    load_counts
        Counts of an encoder on the load per turn of the motor, 0: none.
    max_voltage, max_current, max_speed
        V, A, rad/s.
    counts_per_rev
        Encoder counts per turn of the motor.

    Raises
    ------
    ModelError
        A number that is not finite and positive (those with a default may be 0, `stiffness` infinite).
    """

    resistance: float
    inductance: float
    torque_constant: float
    back_emf_constant: float
    inertia: float
    max_voltage: float
    max_current: float
    max_speed: float
    counts_per_rev: float
    viscous: float = 0.0
    load_inertia: float = 0.0
    stiffness: float = math.inf
    gap: float = 0.0
    load_counts: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            positive = value > 0.0 or (field.default == 0.0 and value == 0.0)
            if not (positive and (math.isfinite(value) or field.name == "stiffness")):
                raise ModelError(f"ServoAxis: {field.name} is {value!r}; it must be finite and greater than 0")
        if not math.isinf(self.stiffness) and not 0.0 < self.load_inertia < self.inertia:
            raise ModelError(
                f"ServoAxis: load_inertia is {self.load_inertia!r}; of an elastic axis it must be a part of the "
                f"inertia {self.inertia!r} kg m2"
            )

    @property
    def antiresonance(self) -> float:
        """Of an elastic axis, rad/s: the load swings, the motor stands, `sqrt(c / J_L)`."""
        return math.sqrt(self.stiffness / self.load_inertia)

    @property
    def resonance(self) -> float:
        """Of an elastic axis, rad/s: both swing, `sqrt(c (1/J_M + 1/J_L))`."""
        return math.sqrt(self.stiffness * (1.0 / (self.inertia - self.load_inertia) + 1.0 / self.load_inertia))


@dataclass(frozen=True, slots=True)
class SampleTimes:
    """Sample times of the three loops, s.

    Raises
    ------
    OutOfLimits
        A time that is not positive, or an inner loop that is slower than the one around it.
    """

    current: float = 1e-4
    speed: float = 5e-4
    position: float = 1e-3

    def __post_init__(self) -> None:
        if not 0.0 < self.current <= self.speed <= self.position < math.inf:
            raise OutOfLimits(
                f"SampleTimes: current {self.current!r}, speed {self.speed!r}, position {self.position!r} s; "
                "they must be positive, and no loop slower than the one around it"
            )


@dataclass(frozen=True, slots=True)
class DesignWarning:
    """What a design does not reach: a name, a sentence, the number that is and the one that is wanted."""

    name: str
    text: str
    value: float
    wanted: float

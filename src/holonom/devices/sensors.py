"""Data sheets of sensors that measure a quantity with noise and an offset."""

from __future__ import annotations

from dataclasses import dataclass

from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Accelerometer", "CurrentShunt", "Gyro"]


@dataclass(frozen=True, slots=True)
class Gyro:
    """A gyro about the vertical axis.

    Raises
    ------
    ModelError
        A field that is not finite, a negative noise.
    """

    noise: float = parameter(2e-3, meaning="standard deviation of a 1 kHz sample", unit="rad/s", least=0.0)
    bias: float = parameter(2e-4, meaning="what it shows at rest", unit="rad/s")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class Accelerometer:
    """Accelerometers along two axes of the base; raises as `Gyro` does."""

    noise: float = parameter(0.05, meaning="standard deviation of a 1 kHz sample", unit="m/s2", least=0.0)
    bias: float = parameter(0.02, meaning="what it shows at rest, on both axes", unit="m/s2")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class CurrentShunt:
    """A shunt in series with an armature; raises as `Gyro` does."""

    noise: float = parameter(0.03, meaning="standard deviation of a sample", unit="A", least=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

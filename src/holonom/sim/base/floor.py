"""The floor under a base: slip curves of its materials, and patches of another material (ice, oil, carpet)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.arrays import is_finite, shown
from holonom.errors import OutOfLimits, UnknownName

__all__ = [
    "CARPET",
    "ICE",
    "Floor",
    "Material",
    "RectangularPatch",
    "RoundPatch",
    "Step",
    "floor_table",
    "step_table",
    "wheel_grips",
]

MATERIAL = np.dtype([("stiffness", np.float64), ("shape", np.float64), ("peak", np.float64)])
"""B (s/m), C, D of the magic formula."""

PATCH = np.dtype(
    [
        ("round", np.bool_),
        ("x", np.float64),
        ("y", np.float64),
        ("cosine", np.float64),
        ("sine", np.float64),
        ("half_length", np.float64),  # radius of a disc
        ("half_width", np.float64),
        ("reach", np.float64),  # from the centre to the farthest corner
        ("material", MATERIAL),
    ]
)
"""A patch as the kernel tests it."""

STEP = np.dtype([(name, np.float64) for name in ("x", "y", "cosine", "sine", "height")])
"""An edge: a point of it, direction of its rise, height, m."""


@dataclass(frozen=True, slots=True)
class Material:
    """Slip curve between wheel and floor: friction coefficient over slip speed, `mu(s) = D sin(C atan(B s))`.

    Pacejka's magic formula without its curvature term (Tire and Vehicle Dynamics, ch. 4), over the slip speed
    in m/s instead of the slip ratio, so that it holds at standstill too.

    Attributes
    ----------
    peak
        Largest friction coefficient.
    sliding
        Coefficient at large slip; below the peak.
    slip_at_peak
        Slip speed (m/s) at which the peak is.

    Raises
    ------
    OutOfLimits
        Not `0 <= sliding < peak`, or a slip speed that is not positive; a floor without any friction is
        `Material(0.0, 0.0, 0.1)`.
    """

    peak: float = 0.8
    sliding: float = 0.65
    slip_at_peak: float = 0.05

    def __post_init__(self) -> None:
        falls = 0.0 <= self.sliding < self.peak < math.inf or self.sliding == self.peak == 0.0
        if not (falls and 0.0 < self.slip_at_peak < math.inf):
            raise OutOfLimits(
                f"Material: peak {self.peak!r}, sliding {self.sliding!r}, slip_at_peak {self.slip_at_peak!r} m/s; "
                "the sliding coefficient must be at least 0 and below the peak, the slip speed positive"
            )

    @property
    def shape(self) -> float:
        """C, from the fall behind the peak: `D sin(C pi/2) = sliding`."""
        part = self.sliding / self.peak if self.peak > 0.0 else 0.0
        return 2.0 - 2.0 / math.pi * math.asin(part)

    @property
    def stiffness(self) -> float:
        """B (s/m), from the place of the peak: `C atan(B s) = pi/2`."""
        return math.tan(0.5 * math.pi / self.shape) / self.slip_at_peak

    @property
    def creep(self) -> float:
        """Slip speed (m/s) of a gripping wheel over the friction that it uses, where both are small: 1/(B C D)."""
        return 1.0 / (self.stiffness * self.shape * self.peak) if self.peak > 0.0 else 0.0

    def friction(self, slip: float) -> float:
        """Friction coefficient at a slip speed (m/s); odd in it."""
        return self.peak * math.sin(self.shape * math.atan(self.stiffness * slip))


CARPET = Material()
"""Rubber ring on felt; assumed."""
ICE = Material(0.06, 0.04, 0.03)
"""Rubber ring on wet ice; assumed."""


@dataclass(frozen=True, slots=True)
class RectangularPatch:
    """A rectangular patch: centre (m), length and width (m), turned by `angle` (rad), of a material."""

    centre: tuple[float, float]
    length: float
    width: float
    material: Material = ICE
    angle: float = 0.0

    def __post_init__(self) -> None:
        _positive("RectangularPatch", length=self.length, width=self.width)


@dataclass(frozen=True, slots=True)
class RoundPatch:
    """A round patch: centre (m), radius (m), of a material."""

    centre: tuple[float, float]
    radius: float
    material: Material = ICE

    def __post_init__(self) -> None:
        _positive("RoundPatch", radius=self.radius)


@dataclass(frozen=True, slots=True)
class Step:
    """An edge across the floor, a straight line: a point of it (m), its height (m), the direction (rad) of its rise.

    The floor is higher by it beyond the edge. Wheels roll over one that is lower than their radius; a higher one stops
    them.
    """

    position: tuple[float, float]
    height: float
    rise: float = 0.0

    def __post_init__(self) -> None:
        _positive("Step", height=self.height)
        if not all(math.isfinite(x) for x in (*self.position, self.rise)):
            raise OutOfLimits(f"Step: position {self.position!r} m, rise {self.rise!r} rad; finite numbers are needed")


@dataclass(frozen=True, slots=True)
class Floor:
    """A floor of one material with patches; where patches overlap the last one counts.

    Attributes
    ----------
    slope, uphill
        Angle (rad) of the whole floor against the horizontal, and the direction (rad, in the world) in which it
        rises. Places are measured along the floor.
    steps
        Edges across it.
    """

    material: Material = CARPET
    patches: tuple[RectangularPatch | RoundPatch, ...] = ()
    slope: float = 0.0
    uphill: float = 0.0
    steps: tuple[Step, ...] = ()

    def __post_init__(self) -> None:
        if not (abs(self.slope) < 0.5 * math.pi and math.isfinite(self.uphill)):
            raise OutOfLimits(
                f"Floor: slope {self.slope!r}, uphill {self.uphill!r} rad; a slope between -pi/2 and pi/2 is allowed"
            )


def floor_table(floor: Floor) -> tuple[NDArray[np.void], NDArray[np.void]]:
    """Return the floor as records: its material (1,) of `MATERIAL`, its patches (k,) of `PATCH`."""
    rows = [_patch_row(patch) for patch in floor.patches]
    return np.array([_material_row(floor.material)], dtype=MATERIAL), np.array(rows, dtype=PATCH)


def step_table(floor: Floor) -> NDArray[np.void] | None:
    """Return the steps of a floor as records (k,) of `STEP`; None where there are none."""
    rows = [(*step.position, math.cos(step.rise), math.sin(step.rise), step.height) for step in floor.steps]
    return np.array(rows, dtype=STEP) if rows else None


def _material_row(material: Material) -> tuple[float, float, float]:
    return material.stiffness, material.shape, material.peak


def _patch_row(patch: RectangularPatch | RoundPatch) -> tuple[object, ...]:
    material = _material_row(patch.material)
    if isinstance(patch, RoundPatch):
        return (True, *patch.centre, 1.0, 0.0, patch.radius, patch.radius, patch.radius, material)
    cosine, sine, reach = math.cos(patch.angle), math.sin(patch.angle), 0.5 * math.hypot(patch.length, patch.width)
    return (False, *patch.centre, cosine, sine, 0.5 * patch.length, 0.5 * patch.width, reach, material)


def _positive(owner: str, **sizes: float) -> None:
    for name, value in sizes.items():
        if not 0.0 < value < math.inf:
            raise OutOfLimits(f"{owner}: {name} is {value!r} m; it must be finite and greater than 0")


def wheel_grips(names: Sequence[str], stated: Mapping[str, float]) -> list[float]:
    """Friction of each wheel over that of the floor.

    Raises
    ------
    UnknownName, OutOfLimits
    """
    for name, grip in stated.items():
        if name not in names:
            raise UnknownName("wheel", name, names)
        if not (is_finite(grip) and grip > 0.0):
            raise OutOfLimits(
                f"grips: {name!r} has {shown(grip)}; a number above 0 is needed, 1 is the floor's friction"
            )
    return [float(stated.get(name, 1.0)) for name in names]

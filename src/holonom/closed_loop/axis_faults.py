"""Faults of an axis that a simulation can have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from holonom.closed_loop.axis_kernels import AxisFaults
from holonom.devices.encoders.quadrature.encoder import line_faults
from holonom.devices.encoders.quadrature.kernels import HEALTHY
from holonom.errors import OutOfLimits, UnknownName

__all__ = ["AXIS_FAULTS", "AxisFault", "faults_of"]

NEVER = 2**62


@dataclass(frozen=True, slots=True)
class AxisFault:
    """A fault of an axis, a name of `AXIS_FAULTS`, from a time (s) on, and how large it is.

    ====================  =========================================================================
    channel_a_stuck       and channel_b_stuck: at a level, `size` 0 or 1
    encoder_dead          all its lines are low
    line_broken           its receivers see a broken pair
    channels_swapped      A and B exchanged
    edges_lost            a share `size` of all edges, 0.001 unless given
    wrong_counts          `size` counts per turn, a multiple of four, instead of those of the sheet; from the start
    index_stuck           at level `size` 0 or 1
    bad_frames            a share `size` of an absolute encoder's frames has a wrong checksum, all unless given
    phase_lost            the winding is open
    blocked               the shaft does not turn any more
    current_offset        the shunt's zero is off by `size` A; from the start
    supply                the supply is `size` V; from the start
    potentiometer         off by `size` rad of the motor; from the start
    brake_slips           the brake holds `size` N m only; from the start
    ====================  =========================================================================

    Raises
    ------
    UnknownName
        Another name.
    OutOfLimits
        A time or size that is not possible.
    """

    kind: str
    time: float = 0.0
    size: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in AXIS_FAULTS:
            raise UnknownName("fault of an axis", self.kind, AXIS_FAULTS)
        if not 0.0 <= self.time < math.inf:
            raise OutOfLimits(f"AxisFault: time is {self.time!r} s; it must be finite and at least 0")
        low, high, _ = SIZES.get(self.kind, (-math.inf, math.inf, 0.0))
        if not low <= self.value <= high or not math.isfinite(self.value):
            raise OutOfLimits(f"AxisFault: {self.kind} of size {self.value!r}; it must lie within {low:g} and {high:g}")

    @property
    def value(self) -> float:
        """Its size, the usual one unless given."""
        return SIZES.get(self.kind, (0.0, 0.0, 0.0))[2] if self.size is None else self.size


SIZES = {
    "channel_a_stuck": (0.0, 1.0, 0.0),
    "channel_b_stuck": (0.0, 1.0, 0.0),
    "edges_lost": (1e-6, 1.0, 1e-3),
    "wrong_counts": (4.0, 2.0**28, 1024.0),
    "index_stuck": (0.0, 1.0, 0.0),
    "bad_frames": (1e-6, 1.0, 1.0),
    "current_offset": (-math.inf, math.inf, 1.0),
    "supply": (0.0, math.inf, 0.0),
    "potentiometer": (-math.inf, math.inf, 2.0 * math.pi),
    "brake_slips": (0.0, math.inf, 0.0),
}
"""Least, greatest and usual sizes."""


AT_THE_START = {"current_zero", "supply", "potentiometer"}


def _level(fault: AxisFault) -> str:
    return "high" if fault.value >= 0.5 else "low"


AXIS_FAULTS: Mapping[str, Callable[[AxisFault], dict[str, Any]]] = MappingProxyType(
    {
        "channel_a_stuck": lambda f: {"lines": line_faults(a=_level(f))},
        "channel_b_stuck": lambda f: {"lines": line_faults(b=_level(f))},
        "encoder_dead": lambda f: {"lines": line_faults(dead=True)},
        "line_broken": lambda f: {"lines": line_faults(a="low"), "receiver": 1},
        "channels_swapped": lambda f: {"lines": line_faults(swapped=True)},
        "edges_lost": lambda f: {"lines": line_faults(lost=f.value)},
        "wrong_counts": lambda f: {},
        "index_stuck": lambda f: {"lines": line_faults(index=_level(f))},
        "bad_frames": lambda f: {"bad_frames": f.value},
        "phase_lost": lambda f: {"phase_lost": 1},
        "blocked": lambda f: {"blocked": 1},
        "current_offset": lambda f: {"current_zero": f.value},
        "supply": lambda f: {"supply": f.value},
        "potentiometer": lambda f: {"potentiometer": f.value},
        "brake_slips": lambda f: {},
    }
)
"""What each fault changes in `AxisFaults`."""


def faults_of(faults: Iterable[AxisFault], supply: float, dt: float) -> AxisFaults:
    """Params of the simulation; those with a time break at the same one.

    Raises
    ------
    OutOfLimits
        Two faults at different times, or two of one kind.
    """
    healthy: dict[str, Any] = {
        "step": NEVER, "lines": HEALTHY, "receiver": 0, "bad_frames": 0.0, "phase_lost": 0, "blocked": 0,
        "current_zero": 0.0, "supply": supply, "potentiometer": 0.0,
    }  # fmt: skip
    changed: dict[str, Any] = {}
    for fault in faults:
        changes = AXIS_FAULTS[fault.kind](fault)
        if changes.keys() & changed.keys():
            raise OutOfLimits(f"simulate_axis: {fault.kind} comes beside another fault of the same lines; give one")
        changed |= changes
    times = {f.time for f in faults if AXIS_FAULTS[f.kind](f).keys() - AT_THE_START}
    if len(times) > 1:
        raise OutOfLimits(f"simulate_axis: faults at {sorted(times)} s; all break at one time")
    if times:
        changed["step"] = round(times.pop() / dt)
    return AxisFaults(**(healthy | changed))

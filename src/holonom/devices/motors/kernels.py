"""Compiled steps of motors: scalars and NamedTuples in, scalars out; nothing is checked or allocated."""

from __future__ import annotations

from typing import NamedTuple

from holonom.trace.code.loops import loop

__all__ = [
    "ArmatureParams",
    "armature_step",
]


class ArmatureParams(NamedTuple):
    """An armature at one fixed interval: decay `exp(-R dt / L)`, 1/R in S, k_e in V s/rad, supply in V."""

    decay: float
    conductance: float
    back_emf: float
    max_voltage: float


@loop
def armature_step(params: ArmatureParams, current: float, voltage: float, speed: float) -> float:
    """Current (A) one interval later, from `L di/dt = u - R i - k_e w`, exact for held `u`, `w` (03.1)."""
    supplied = min(max(voltage, -params.max_voltage), params.max_voltage)
    settled = params.conductance * (supplied - params.back_emf * speed)
    return settled + params.decay * (current - settled)

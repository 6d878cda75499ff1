"""Presets: one file each, one line in this table."""

from __future__ import annotations

from importlib import import_module

from holonom.errors import UnknownName
from holonom.model.arm import ArmModel

__all__ = ["PRESETS", "preset", "preset_names"]

PRESETS = {
    "puma560": "Unimation Puma 560, Corke and Armstrong's consensus parameters",
    "three_joint": "3-joint teaching arm of specification 08",
    "planar2r": "planar 2R arm in a vertical plane, the textbook's numbers",
    "stanford": "Stanford arm, RRP and a spherical wrist; inertias approximate",
    "scara": "SCARA of the Cobra 600 class; masses made up",
    "ur5e": "Universal Robots UR5e, the maker's numbers",
    "panda": "Franka Emika Panda, seven joints; dynamics as identified by Gaz et al.",
    "pendulum": "driven pendulum with a geared motor, specification 02.3",
}


def preset_names() -> tuple[str, ...]:
    """Return the names that `preset` knows."""
    return tuple(PRESETS)


def preset(name: str) -> ArmModel:
    """Return a preset arm.

    Raises
    ------
    UnknownName
        No such preset; the message lists them.
    """
    if name not in PRESETS:
        raise UnknownName("arm preset", name, PRESETS)
    found: ArmModel = import_module(f"holonom.model.presets.{name}").model()
    return found

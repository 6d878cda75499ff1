"""Presets: one file each, one line in this table."""

from __future__ import annotations

from functools import partial
from importlib import import_module

from holonom.model.arm import ArmModel
from holonom.registry import OWN, Method, NoParams, Table

__all__ = ["PRESETS", "preset", "preset_names"]


def _made(module: str, _: NoParams) -> ArmModel:
    found: ArmModel = import_module(f"holonom.model.presets.{module}").model()
    return found


_LINES = {
    "puma560": (
        "Unimation Puma 560, Corke and Armstrong's consensus parameters",
        "Corke, Armstrong-Helouvry, A search for consensus among model parameters, ICRA 1994",
    ),
    "three_joint": ("3-joint teaching arm of specification 08", "specification 08"),
    "planar2r": (
        "planar 2R arm in a vertical plane, the textbook's numbers",
        "Siciliano, Sciavicco, Villani, Oriolo, Robotics, 7.3.2",
    ),
    "stanford": (
        "Stanford arm, RRP and a spherical wrist; inertias approximate",
        "Paul, Robot Manipulators, 1981",
    ),
    "scara": ("SCARA of the Cobra 600 class; masses made up", "Robotics Toolbox, model Cobra600"),
    "ur5e": (
        "Universal Robots UR5e, the maker's numbers",
        "Universal Robots, DH parameters for calculations of kinematics and dynamics",
    ),
    "panda": (
        "Franka Emika Panda, seven joints; dynamics as identified by Gaz et al.",
        "Gaz et al., Dynamic identification of the Franka Emika Panda, RA-L 2019",
    ),
    "pendulum": ("driven pendulum with a geared motor, specification 02.3", OWN),
}

PRESETS = Table(
    "presets",
    "arm preset",
    "the `ArmModel`",
    {name: Method(help, partial(_made, name), source) for name, (help, source) in _LINES.items()},
)
"""The name of a preset here is that of its module."""


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
    found: ArmModel = PRESETS.make(name)
    return found

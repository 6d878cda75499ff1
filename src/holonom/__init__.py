"""Holonom: a robot control system, from a joint motor to a robot program.

>>> import holonom as hm
>>> arm = hm.load_arm("puma560")
>>> T = arm.fk([0.0, 0.7, -2.8, 0.0, 0.5, 0.0])

=================  ==============================================================
`load_arm`         a preset arm; `arm_from_dh` one of your own
`load_base`        a mobile base from a URDF or xacro file
`hm.mechanics`     kinematics, dynamics, motion
`hm.trace`         the kernel compiler
`hm.model`         robot descriptions
`hm.geometry`      shapes, distances, ray casts
`hm.devices`       motors, gears, friction, encoders
`hm.control`       regulators, servo cascade, computed torque
`hm.mobile`        wheels, bases, odometry and its calibration
`hm.vision`        camera over a table, coins
`hm.lang`          the ARPS robot language
`hm.machine`       the controller of an arm or a base
`hm.sim`           simulated plants, floors, work pieces
`hm.closed_loop`   controller and plant together
`hm.plots`         figures of arms and their motions
=================  ==============================================================
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from holonom import errors

if TYPE_CHECKING:
    from holonom import (
        closed_loop,
        control,
        devices,
        geometry,
        lang,
        machine,
        mechanics,
        mobile,
        model,
        signals,
        sim,
        trace,
        vision,
    )
    from holonom.mechanics import Arm, arm_from_dh, load_arm
    from holonom.mobile.urdf import load_base
    from holonom.model import DHRow

__version__ = "0.1.0"
_SUBPACKAGES = (
    "closed_loop",
    "control",
    "devices",
    "geometry",
    "lang",
    "machine",
    "mechanics",
    "mobile",
    "model",
    "plots",
    "signals",
    "sim",
    "spatial",
    "trace",
    "vision",
)
_LAZY = {
    "Arm": "holonom.mechanics",
    "DHRow": "holonom.model",
    "arm_from_dh": "holonom.mechanics",
    "load_arm": "holonom.mechanics",
    "load_base": "holonom.mobile.urdf",
}
__all__ = [
    "Arm",
    "DHRow",
    "arm_from_dh",
    "closed_loop",
    "control",
    "devices",
    "errors",
    "geometry",
    "lang",
    "load_arm",
    "load_base",
    "machine",
    "mechanics",
    "mobile",
    "model",
    "signals",
    "sim",
    "trace",
    "vision",
]


def __getattr__(name: str) -> Any:
    """Load subpackages on first use: `import holonom` stays light."""
    if name in _SUBPACKAGES:
        return importlib.import_module(f"holonom.{name}")
    if name in _LAZY:
        return getattr(importlib.import_module(_LAZY[name]), name)
    raise AttributeError(f"module 'holonom' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])

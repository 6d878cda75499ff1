"""The law by which a base keeps its path, fitted to it: no command beyond what the base can drive."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, TypeAlias

import numpy as np

from holonom.control.base.path_keeping import KeepingSettings
from holonom.control.path_laws.compiled import LawCall, law_call
from holonom.control.path_laws.contract import PathLaw
from holonom.control.path_laws.kanayama import KanayamaSettings, kanayama_step
from holonom.control.path_laws.mpc import LinearMpc
from holonom.control.path_laws.stanley import LEAD
from holonom.errors import ModelError
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.base.wheel_base import WheelBase

__all__ = ["Law", "fitted_law", "limited_law", "path_law_call", "usual_law"]

Law: TypeAlias = PathLaw | LinearMpc
"""What a method of `PATH_LAWS` makes."""
NO_LAW = LawCall(0, np.zeros(8, np.uint8))


def usual_law(keeping: KeepingSettings) -> PathLaw:
    """Kanayama's law with the gains and limits of path keeping."""
    settings = KanayamaSettings(
        position_gain=keeping.bandwidth,
        heading_gain=keeping.bandwidth,
        max_correction=keeping.max_correction,
        max_turn_correction=keeping.max_turn_correction,
        max_speed=np.inf,
        max_turn_rate=np.inf,
        max_acceleration=keeping.max_acceleration,
        max_turn_acceleration=keeping.max_turn_acceleration,
    )
    return PathLaw(kanayama_step, settings)


def fitted_law(law: Law | None, base: WheelBase, keeping: KeepingSettings, max_rim: float) -> Law | None:
    """Return the law for a base, the usual one for None; None where the base moves along y at once.

    Its commands keep the base's turning radius, the speed that its rims (m/s) reach, and the accelerations of path
    keeping; a leading axle that is not stated is the foremost one that steers.

    Raises
    ------
    ModelError
        A law for a base that moves along y at once.
    """
    if moves_sideways(base):
        if law is not None:
            raise ModelError(
                f"a path law came for base {base.name!r}; it moves sideways at once, and keeps its place along and "
                "across by path keeping: leave the law out"
            )
        return None
    chosen = usual_law(keeping) if law is None else law
    radius = base.turning_radius
    rolling = float(np.abs(base.rest_coupling[:, 0]).max())
    bounds = {
        "max_speed": max_rim / rolling,
        "max_acceleration": keeping.max_acceleration,
        "max_turn_acceleration": keeping.max_turn_acceleration,
        "max_curvature": 1.0 / radius if radius > 0.0 else np.inf,
    }
    fitted = limited_law(chosen, bounds)
    if getattr(fitted.settings, "lead", 0.0) is None:
        steering = [wheel.x for wheel in base.wheels if wheel.kind == "steered" and wheel.x > 0.0]
        lead = max(steering, default=LEAD)
        fitted = _with(fitted, {"lead": lead})
    return fitted


def limited_law(law: Law, bounds: Mapping[str, float]) -> Law:
    """Return the law with each of some limits no more than a bound."""
    return _with(law, {name: min(getattr(law.settings, name), bound) for name, bound in bounds.items()})


def _with(law: Law, changed: Mapping[str, float]) -> Law:
    values: dict[str, Any] = dict(changed)
    if isinstance(law, LinearMpc):
        return LinearMpc(dataclasses.replace(law.settings, **values))
    return PathLaw(law.step, dataclasses.replace(law.settings, **values))


def path_law_call(law: Law | None, dt: float) -> LawCall:
    """What the compiled controller calls; nothing where the base moves along y at once."""
    return NO_LAW if law is None else law_call(law, dt)

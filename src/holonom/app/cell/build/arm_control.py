"""From `controllers` and `levels` of an arm to the settings of its control loops."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from holonom.app.cell.load import place_in
from holonom.app.cell.model.drives import ArmLimits, levels_of
from holonom.app.cell.model.robot import Robot
from holonom.app.fields.methods import Chosen
from holonom.control import ComputedTorqueSettings
from holonom.errors import CellError, InputError
from holonom.machine import ControlSettings, Levels
from holonom.machine.arm.clock import samples_per_tick

__all__ = ["control_of"]

USUAL = ComputedTorqueSettings()


def control_of(
    robot: Robot, drives: str, path: Path, at: tuple[str | int, ...]
) -> tuple[tuple[ControlSettings, ...], tuple[str, ...]]:
    """Return settings of an arm's controllers, and what was assumed; of ideal joints one, for its levels.

    Raises
    ------
    CellError
        Periods that do not fit each other or a controller.
    """
    assert isinstance(robot.controllers, tuple)
    levels = levels_of(robot.levels, place_in(path, *at, "levels"))
    try:
        samples_per_tick(levels.servo)
    except InputError as problem:
        raise CellError(f"{place_in(path, *at, 'levels', 'servo')}: {problem}") from None
    try:
        made = [_settings(law, robot, levels) for law in robot.controllers]
    except InputError as problem:
        raise CellError(f"{place_in(path, *at, 'controllers')}: {problem}") from None
    if drives != "ideal":
        return tuple(made), tuple(_slowed(made))
    stated = "controllers" in robot.model_fields_set
    return tuple(made[-1:]), ("its controllers do nothing: ideal joints follow their commands",) if stated else ()


def _settings(law: Chosen, robot: Robot, levels: Levels) -> ControlSettings:
    assert isinstance(robot.limits, ArmLimits)
    stated = isinstance(law.params, ComputedTorqueSettings) and law.params != USUAL
    settings = ControlSettings(
        law.name,
        law.params,
        law_bandwidth=law.params.law_bandwidth if stated else None,
        following_error=robot.limits.following_error,
        slide_error=robot.limits.slide_error,
        levels=levels,
    )
    settings.law()
    return settings


def _slowed(made: list[ControlSettings]) -> Iterator[str]:
    for own in made:
        if own.controller == "computed_torque" and own.law_bandwidth is None and own.bandwidth < USUAL.law_bandwidth:
            yield (
                f"the bandwidth of its computed torque is {own.bandwidth:g} rad/s: more asks for a shorter period of "
                f"the model than {1e3 * own.levels.model:g} ms"
            )

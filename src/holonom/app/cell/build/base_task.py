"""What a base is to do: its path and the law that keeps it, velocities, a pose; what of it wheels and limits refuse."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from holonom.app.cell.load import place_in
from holonom.app.cell.model.drives import BaseLimits
from holonom.app.cell.model.robot import Robot
from holonom.app.cell.model.tasks import PathTable, StartTable
from holonom.app.job import PathTolerance, Task
from holonom.arrays import Array
from holonom.control.base.path_keeping import KeepingSettings
from holonom.control.path_laws.mpc import LinearMpc
from holonom.errors import CellError
from holonom.machine import PATHS, PathLimits, ReferencePath, plan_path
from holonom.machine.base.laws import Law, fitted_law, limited_law, usual_law
from holonom.mobile import WheelBase
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.curves import Curves
from holonom.mobile.odometry import integrate

__all__ = ["base_task", "check_path", "path_law"]

LEAST = 0.01  # m that it may be off in any case
UNDER = 0.2  # m that a base which balances may roll while it holds its place
AROUND = np.radians(10.0)  # that the heading may be off where the cell says nothing
CORNER = 0.2  # rad, of arcs that the box of commanded velocities is measured by
BESIDE = 0.05  # of the larger side of a path's box, that a base may be off it where the cell says nothing
EVERY = 20  # samples of a path, of which one is looked at
ASTRAY = 1e-3  # m/s by which wheels may be dragged
BENDS = 1001  # curvatures that are tried between straight on and what is asked for
LAW_LIMITS = {
    "speed": "max_speed",
    "acceleration": "max_acceleration",
    "turn_rate": "max_turn_rate",
    "turn_acceleration": "max_turn_acceleration",
}
"""Limits of a cell, as a law of paths calls them."""


def path_law(robot: Robot, base: WheelBase, planned: ReferencePath | None) -> Law | None:
    """The law of its path within the limits that the cell states; None where nothing is stated of either.

    Raises
    ------
    CellError
        A path that passes limits of the law that was chosen.
    ModelError
        A law for a base that moves sideways.
    MissingExtra
        A law whose library is not installed.
    """
    if robot.path is None or planned is None:
        return None
    chosen, limits = robot.path.law, robot.limits
    assert isinstance(limits, BaseLimits)
    if chosen is None and (moves_sideways(base) or not set(LAW_LIMITS) & limits.model_fields_set):
        return None
    law: Law = usual_law(KeepingSettings()) if chosen is None else chosen.make()
    fitted_law(law, base, KeepingSettings(), np.inf)
    if isinstance(law, LinearMpc):
        law.check_library()
    asked = {"speed": np.abs(planned.twist[:, 0]).max(), "turn_rate": np.abs(planned.twist[:, 2]).max()}
    for key, most in asked.items():
        allowed = getattr(law.settings, LAW_LIMITS[key])
        if chosen is not None and most > allowed * (1.0 + 1e-6):
            raise CellError(
                f"{LAW_LIMITS[key]} of {chosen.name} is {allowed:g}; the path asks for {most:.4g}: drive it slower, or "
                f"state {LAW_LIMITS[key]}"
            )
    return limited_law(
        law, {LAW_LIMITS[key]: getattr(limits, key) for key in LAW_LIMITS if key in limits.model_fields_set}
    )


def base_task(robot: Robot) -> Task:
    """Path, velocities or a pose to hold, and how far off it may be."""
    start = robot.start or StartTable.model_construct()
    found = Task(start=start.time, after=start.signal, done=robot.done)
    if robot.path is not None:
        path = _path(robot.path, robot.source.base)
        table = robot.path
        tolerance = PathTolerance(table.position_tolerance or beside(path.pose), table.heading_tolerance)
        return dataclasses.replace(found, path=path, tolerance=tolerance)
    if robot.velocity is not None:
        rows = np.array([[step.at, *step.twist] for step in robot.velocity])
        lasting = np.diff(rows[:, 0], append=rows[-1, 0])
        turns = np.ceil(np.abs(lasting * rows[:, 3]) / CORNER).astype(int) + 1
        steps = np.repeat(lasting[:, None] * rows[:, 1:] / turns[:, None], turns, axis=0)
        way = integrate(np.vstack([np.zeros(3), steps]))
        return dataclasses.replace(found, velocities=rows, tolerance=PathTolerance(beside(way), AROUND))
    hold = robot.hold if robot.hold is not None else 0.0
    least = UNDER if robot.source.base.balances else LEAST
    return dataclasses.replace(found, hold=hold, tolerance=PathTolerance(least, AROUND))


def beside(poses: Array) -> float:
    """How far beside a way (N, 3) a base may be, m, where the cell does not say: a part of its box, and no less."""
    return max(BESIDE * float(np.ptp(poses[:, :2], axis=0).max()), LEAST)


def _path(path: PathTable, base: WheelBase) -> ReferencePath:
    points = PATHS.make(path.shape, {field.name: getattr(path, field.name) for field in PATHS[path.shape].fields})
    limits = PathLimits(path.speed, path.acceleration)
    if isinstance(points, Curves):
        return plan_path(dataclasses.replace(points, start=points.start + np.array([*path.origin, 0.0])), limits)
    heading = path.heading or ("fixed" if moves_sideways(base) else "tangent")
    return plan_path(points + np.array(path.origin), limits, laps=path.laps, heading=heading, start=path.angle)


def check_limits(robot: Robot, planned: ReferencePath, path: Path, at: tuple[str | int, ...]) -> tuple[str, ...]:
    """Refuse a path that passes limits of the cell; say which limits are none of a path."""
    limits = robot.limits
    assert isinstance(limits, BaseLimits)
    asked = {
        "speed": np.hypot(*planned.twist[:, :2].T),
        "turn_rate": np.abs(planned.twist[:, 2]),
        "acceleration": np.hypot(*planned.acceleration[:, :2].T),
        "turn_acceleration": np.abs(planned.acceleration[:, 2]),
    }
    stated = sorted(limits.model_fields_set)
    for key in [key for key in stated if key in asked]:
        most, allowed = float(asked[key].max()), getattr(limits, key)
        if most > allowed * (1.0 + 1e-6):
            raise CellError(
                f"{place_in(path, *at, 'limits', key)}: {allowed:g} came; the path asks for {most:.4g}: drive it "
                "slower, or allow more"
            )
    others = [key for key in stated if key not in asked]
    return (f"limits of {', '.join(others)} are of velocities, not of a path",) if others else ()


def check_path(robot: Robot, task: Task, path: Path, at: tuple[str | int, ...], *, simulated: bool) -> tuple[str, ...]:
    """Refuse a path that wheels cannot roll along or that passes limits; say of steered ones that they cannot."""
    assert task.path is not None
    base: WheelBase = robot.source.base
    notes = check_limits(robot, task.path, path, at)
    found = _undrivable(base, task.path)
    if found and simulated:
        raise CellError(f"{place_in(path, *at, 'path')}: {found}")
    return (*notes, f"it cannot drive its path: {found}") if found else notes


def _undrivable(base: WheelBase, path: ReferencePath) -> str:
    """Why the wheels cannot roll along a path: where, and what they can; "" where they can."""
    twist = path.twist[::EVERY]
    away = np.abs((base.feasible(twist) - twist) * [1.0, 1.0, base.radius]).max(axis=1)
    k = int(away.argmax())
    if away[k] <= ASTRAY:
        return ""
    (vx, vy, w), (x, y) = twist[k], path.pose[::EVERY][k, :2]
    where = f"at {path.time[::EVERY][k]:.2f} s, at ({x:.2f}, {y:.2f}) m,"
    if abs(vy) > ASTRAY and not moves_sideways(base):
        sideways = f"{where} it asks for {vy:.2g} m/s sideways, which these wheels cannot roll"
        return f'{sideways}; heading = "tangent" looks along it'
    if base.turning_radius < np.inf:
        asked, least = (abs(vx / w) if w else np.inf), base.turning_radius
        if asked >= least:  # some wheels turn on the spot and drive wide curves, and nothing between
            least = _tightest_ahead(base, twist[k])
        return f"{where} it asks for a curve of {asked:.3g} m; the tightest that these wheels drive is {least:.3g} m"
    return f"{where} it asks for {np.degrees(w):.3g} deg/s; this base cannot turn"


def _tightest_ahead(base: WheelBase, twist: Array) -> float:
    """Radius, m, of the tightest curve that is wider than that of a twist (3,) and that its wheels drive."""
    bends = np.linspace(0.0, 1.0, BENDS)[:, None] * [0.0, 0.0, 1.0] * twist + [twist[0], 0.0, 0.0]
    away = np.abs((base.feasible(bends) - bends) * [1.0, 1.0, base.radius]).max(axis=1)
    w = abs(bends[int((away <= 1e-6).argmin()) - 1, 2])
    return float(abs(twist[0]) / w) if w else np.inf

"""From a `[[robot]]` that is a mobile base to its `BaseJob`: wheels, drives, controller, task."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from holonom.app.cell.build.base_task import base_task, check_path, path_law
from holonom.app.cell.load import place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.drives import BaseLimits, BaseParts, WheelDrive, levels_of
from holonom.app.cell.model.places import placement_pose
from holonom.app.cell.model.robot import Robot
from holonom.app.cell.model.tasks import FAULTS
from holonom.app.job import BaseJob
from holonom.app.report.findings.base_outline import margin_of
from holonom.arrays import Array
from holonom.control.base.shaping import ShapingSettings
from holonom.devices import DcMotor, Encoder, Friction, Gear, SteeringMotor
from holonom.errors import CellError, InputError, ModelError
from holonom.machine import BaseSettings, ReferencePath
from holonom.mobile import BaseDrive, BaseSensors, WheelBase
from holonom.mobile.base.payload import Payload, loaded
from holonom.mobile.drive.base_drive import stands_in_line
from holonom.mobile.drive.sized import sized_base_drive, usual_steering
from holonom.sim import BaseFault
from holonom.sim.base.balancing import FALLEN
from holonom.sim.base.plant import simulated_lanes
from holonom.spatial import pose

__all__ = ["build_base_job", "deck_height", "refuse_unsimulated", "unsimulated"]

DECK = 2.6
"""Height of a drawn deck over the radius of the largest wheel."""
AWAY = 1e-3  # m and rad that the start of a path may lie beside the pose that a cell states


def deck_height(base: WheelBase) -> float:
    """Height of the deck on which other robots stand, m."""
    return DECK * max(wheel.radius for wheel in base.wheels)


def unsimulated(base: WheelBase) -> str | None:
    """Why a base cannot be simulated, None where it can."""
    try:
        simulated_lanes(base)
    except ModelError as problem:
        return str(problem)
    return None


def refuse_unsimulated(cell: Cell, path: Path) -> None:
    """Raise `CellError` where the cell, the file `path`, has a base that cannot be simulated; for `holonom run`."""
    found = []
    for number, robot in enumerate(cell.robot):
        why = None if robot.is_arm else unsimulated(robot.source.base)
        if why is not None:
            arranged = robot.source.arrangement
            key = ("arrangement",) if arranged else ("wheels",)
            what = f"arrangement {arranged!r}" if arranged else "these wheels"
            found.append(f"{place_in(path, 'robot', number, 'model', *key)}: {what} cannot be simulated yet: {why}")
    if found:
        raise CellError("\n".join(found))


def build_base_job(cell: Cell, number: int, path: Path, sensors: BaseSensors) -> tuple[BaseJob, tuple[str, ...]]:
    """Build robot `number`, a base, of the cell in the file `path`, and say what was assumed.

    Raises
    ------
    CellError
        Drives that cannot be sized, a path that cannot be driven or passes the base's limits, a pose that is not where
        the path begins, motors of ideal drives that break.
    """
    robot, at = cell.robot[number], ("robot", number)
    base: WheelBase = robot.source.base
    key = "drives"
    try:
        drive, drives, notes = _drive(robot, base)
        key = "steering"
        drive, told = _with_steering(robot, base, drive)
        key = "path"
        task = base_task(robot)
        key = "limits"
        settings = _settings(robot, sensors)
        key = "pose"
        lean = _lean(robot)
        key = "law"
        settings = dataclasses.replace(settings, law=path_law(robot, base, task.path))
    except InputError as problem:
        keys = ("path", key) if key == "law" else (key,)
        raise CellError(f"{place_in(path, *at, *keys)}: {problem}") from None
    notes += told
    if task.path is not None:
        notes += check_path(robot, task, path, at, simulated=unsimulated(base) is None)
    _check_stand(base, path, at)
    notes += _check_balance(robot, base, path, at)
    start = _start(robot, task.path, path, at)
    why = unsimulated(base)
    if why is not None:
        notes += (f"it cannot be simulated yet: {why}",)
    called = robot.name or base.name
    notes += _unfelt(cell, robot, drives, path)
    faults = tuple(BaseFault(f.time, f.wheel, FAULTS[f.kind]) for f in cell.fault if cell.robot_of(f.robot) is robot)
    frames = {"base_link": np.eye(4), "top": pose((0.0, 0.0, deck_height(base)))}
    levels = levels_of(robot.levels, place_in(path, "robot", number, "levels"))
    job = BaseJob(
        robot.name,
        base,
        drive,
        drives,
        settings,
        sensors,
        start,
        task,
        faults,
        frames,
        levels,
        lean,
        _payloads(cell, robot, base, path),
    )
    return job, tuple(f"{called}: {note}" for note in notes)


def _unfelt(cell: Cell, robot: Robot, drives: str, path: Path) -> tuple[str, ...]:
    """Refuse motors that break where there are none; say that ideal drives do not slip."""
    if drives != "ideal":
        return ()
    for k, fault in enumerate(cell.fault):
        if cell.robot_of(fault.robot) is robot:
            place = place_in(path, "fault", k, "kind")
            raise CellError(
                f"{place}: it came; the ideal drives of {robot.name or 'the base'} have no motors that break"
            )
    felt = {"patches of the floor": cell.patch, "its slope": cell.floor.slope, "its steps": cell.floor.steps}
    unfelt = [what for what, there in felt.items() if there]
    return (f"ideal drives do not slip, so {' and '.join(unfelt)} change nothing for it",) if unfelt else ()


def _drive(robot: Robot, base: WheelBase) -> tuple[BaseDrive, str, tuple[str, ...]]:
    if isinstance(robot.drives, WheelDrive):
        return _stated(robot.drives), "motors", ()
    limits = robot.limits
    assert isinstance(limits, BaseLimits)
    speed, acceleration = _speed(robot), limits.acceleration
    if robot.path is not None:
        acceleration = max(acceleration, robot.path.acceleration)
    sized = sized_base_drive(base, speed, acceleration)
    if robot.drives is not None:
        return sized, str(robot.drives), ()
    note = f"no motors are stated; they are sized for {speed:g} m/s and {acceleration:g} m/s2"
    return sized, "from_limits", (note,)


def _speed(robot: Robot) -> float:
    """The greatest that it is to reach, m/s."""
    assert isinstance(robot.limits, BaseLimits)
    return robot.limits.speed if robot.path is None else max(robot.limits.speed, robot.path.speed)


def _with_steering(robot: Robot, base: WheelBase, drive: BaseDrive) -> tuple[BaseDrive, tuple[str, ...]]:
    """The drive with the steering motors that the cell states, else with usual ones, which is said."""
    if not base.steered:
        if robot.steering is not None:
            raise CellError("it came; no wheel of this base is steered; leave it out")
        return drive, ()
    if robot.steering is not None:
        return dataclasses.replace(drive, steering=SteeringMotor(**robot.steering.model_dump())), ()
    m = usual_steering(base, _speed(robot))
    drive = dataclasses.replace(drive, steering=m)
    usual = f"{m.max_rate:g} rad/s, {m.max_torque:g} N m and a lag of {1e3 * m.lag:g} ms"
    return drive, (f"no steering motors are stated; usual ones are taken: {usual}",)


def _stated(d: WheelDrive) -> BaseDrive:
    motor = DcMotor(
        resistance=d.resistance,
        inductance=d.inductance,
        torque_constant=d.torque_constant,
        back_emf_constant=d.torque_constant,
        rotor_inertia=d.rotor_inertia,
        max_voltage=d.supply,
        max_current=d.max_current,
        no_load_current=d.no_load_current,
    )
    torque = d.no_load_current * d.torque_constant
    return BaseDrive(
        motor=motor,
        gear=Gear(d.gear_ratio, d.gear_efficiency),
        encoder=Encoder(d.counts_per_turn),
        friction=Friction(coulomb_positive=torque, coulomb_negative=torque),
        wheel_inertia=d.wheel_inertia,
    )


def _settings(robot: Robot, sensors: BaseSensors) -> BaseSettings:
    parts, limits = robot.controllers, robot.limits
    assert isinstance(parts, BaseParts)
    assert isinstance(limits, BaseLimits)
    settings = BaseSettings(sensors=sensors, shaping=ShapingSettings(**limits.model_dump()))
    return dataclasses.replace(
        settings,
        slip=settings.slip if parts.slip_detection else None,
        traction=settings.traction if parts.traction_control else None,
        watch=settings.watch if parts.dead_motor_compensation else None,
        keep=robot.path.keep if robot.path is not None else settings.keep,
        balance=settings.balance if robot.balance is None else robot.balance.make(),
    )


def _check_balance(robot: Robot, base: WheelBase, path: Path, at: tuple[str | int, ...]) -> tuple[str, ...]:
    """Refuse a body that is to balance and hangs from its axle; say by what it balances."""
    if not base.balances:
        return ()
    if not base.com_height > min(base.wheel_radii):
        height, axle = 1e3 * base.com_height, 1e3 * min(base.wheel_radii)
        raise CellError(
            f"{place_in(path, *at, 'model', 'height')}: {height:g} mm came; a body that balances has its centre of "
            f"mass above its axle, which lies at {axle:g} mm"
        )
    if robot.drives == "ideal":
        return ("ideal drives hold its body upright",)
    law = "lqr" if robot.balance is None else robot.balance.name
    return (f"its body balances by {law}, its centre of mass {1e3 * base.com_height:g} mm high",)


def _payloads(cell: Cell, robot: Robot, base: WheelBase, path: Path) -> tuple[tuple[float, Payload], ...]:
    """What it carries, by time; refused where a body that balances could not pitch with it."""
    found = []
    for number, event in enumerate(cell.event):
        if event.payload is None or cell.robot_of(event.robot) is not robot:
            continue
        payload = Payload(**event.payload.model_dump())
        try:
            simulated_lanes(loaded(base, payload))
        except ModelError as problem:
            raise CellError(f"{place_in(path, 'event', number, 'payload')}: {problem}") from None
        found.append((event.at, payload))
    return tuple(sorted(found, key=lambda change: change[0]))


def _lean(robot: Robot) -> float:
    """How far a body that balances leans forwards at the start, rad."""
    lean = 0.0 if robot.pose is None else robot.pose.pitch
    if abs(lean) >= FALLEN:
        raise CellError(f"pitch {np.degrees(lean):g}deg came; beyond {np.degrees(FALLEN):g}deg it has fallen")
    return lean


def _check_stand(base: WheelBase, path: Path, at: tuple[str | int, ...]) -> None:
    """Refuse a base that tips at rest; one whose wheels span no area is held upright across their line."""
    margin = margin_of(base)
    if not (stands_in_line(base) if margin is None else margin >= 0.0):
        x, y = (1e3 * float(value) for value in base.com)
        raise CellError(
            f"{place_in(path, *at, 'model', 'com')}: ({x:g}, {y:g}) mm came; the base tips over at rest: its centre of "
            "mass must lie between its wheels"
        )


def _start(robot: Robot, path: ReferencePath | None, file: Path, at: tuple[str | int, ...]) -> Array:
    """Where the base starts (3,): its pose, or the start of its path."""
    if robot.pose is None:
        return path.pose[0].copy() if path is not None else np.zeros(3)
    x, y = placement_pose(robot.pose)[:2, 3]
    stated = np.array([x, y, robot.pose.angle])
    if path is not None:
        beside = stated - path.pose[0]
        beside[2] = (beside[2] + np.pi) % (2.0 * np.pi) - np.pi
        if np.abs(beside).max() > AWAY:
            px, py, angle = path.pose[0]
            raise CellError(
                f"{place_in(file, *at, 'pose')}: the path begins at ({px:g}, {py:g}) m and {np.degrees(angle):g} deg; "
                "leave pose out, or give the path that origin and angle"
            )
        return path.pose[0].copy()
    return stated

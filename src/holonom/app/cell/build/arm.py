"""From a `[[robot]]` that is an arm to its `ArmJob`: model, tool, drives, program."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from holonom.app.cell.build.arm_control import control_of
from holonom.app.cell.build.camera import Seen, parts_for
from holonom.app.cell.build.taught import taught_problems
from holonom.app.cell.load import place_in
from holonom.app.cell.model.cell import Cell
from holonom.app.cell.model.drives import ArmLimits, JointDrive
from holonom.app.cell.model.places import placement_pose
from holonom.app.cell.model.robot import GripperTool, Robot, RodTool
from holonom.app.job import ArmJob, Mount
from holonom.arrays import Array
from holonom.errors import CellError, InputError, ModelError, ProgramFault, UnknownName
from holonom.lang import Program, load_program, start
from holonom.machine import LineSettings
from holonom.machine.arm.servos import check_drives
from holonom.mechanics import Arm
from holonom.mechanics.arm.sized_drives import sized_drives
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.equations.dynamics.inertia import fixed_to_body
from holonom.mechanics.equations.kinematics import frames
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import ArmModel, Body, Joint, Motor
from holonom.sim import Gripper, Ground
from holonom.spatial import pose

__all__ = ["ArmBuild", "build_arm_job", "usual_home"]

RUN_UP = 0.25
"""s in which a joint without an acceleration limit reaches its speed limit, where its torque allows."""
BESIDE = 0.01
"""Part of a joint's range by which a home that nobody states keeps away from its limits."""
SUNK = 1e-3
"""m that the tool of an arm may begin within a surface."""
SLOW_TURN, SLOW_SLIDE = 1.0, 0.25
"""Speed limit of a joint that states none, rad/s and m/s."""


@dataclasses.dataclass(frozen=True, slots=True)
class ArmBuild:
    """An arm's job, what was assumed for it, and the taught locations that it cannot go to."""

    job: ArmJob
    notes: tuple[str, ...]
    unreachable: tuple[str, ...]


def build_arm_job(
    cell: Cell, number: int, path: Path, seen: Seen | None, mount: Mount | None = None, height: float = 0.0
) -> ArmBuild:
    """Build robot `number`, an arm, of the cell in the file `path`.

    `mount` says which robot carries it, `height` (m) how high above the floor its own base then is.

    Raises
    ------
    CellError
        Its drives, controllers, levels or the entry of its program; a home at which its tool is below its surface.
    ProgramError
        The program or its location file.
    """
    robot = cell.robot[number]
    called, at = robot.name or robot.source.name, ("robot", number)
    arm, home = _standing(robot, mount), np.array(_home(robot))
    arm, drives, notes = _driven(arm, robot, home, path, at)
    arm, more = _with_limits(arm, home)
    settings, slowed = control_of(robot, drives, path, at)
    limits = robot.limits
    assert isinstance(limits, ArmLimits)
    rated = arm
    arm = arm.with_limits(speed=limits.joint_speed, acceleration=limits.joint_acceleration)
    program = _program(robot, arm.limits.turns, path, at)
    unreachable = _unreachable(arm, home, robot, program) if mount is None else ()
    ground = _ground(cell, robot, height if mount is not None else None)
    sunk = ground.height - float(frames(arm.model, home.tolist())[-1][1][2])
    if sunk > SUNK:
        raise CellError(
            f"{place_in(path, *at, 'home')}: {called}'s tool begins {1e3 * sunk:.0f} mm below the surface that it "
            "works over; give another home, or move the robot or the surface"
        )
    hand = robot.tool if isinstance(robot.tool, GripperTool) else None
    job = ArmJob(
        name=robot.name,
        arm=arm,
        mount=mount,
        drives=drives,
        settings=settings,
        home=home,
        program=program,
        entry=robot.program.entry if robot.program is not None else None,
        look=parts_for(hand, cell, seen) if hand is not None and seen is not None else (),
        gripper=_gripper(hand) if hand is not None else None,
        ground=ground,
        line=LineSettings(
            limits.line_speed, limits.line_acceleration, limits.rotation_speed, limits.rotation_acceleration
        ),
        rated=rated,
        hold=robot.hold or 0.0,
        steady=bool(robot.steady_tool),
        contact_force=limits.contact_force,
        settle_time=limits.settle_time,
    )
    return ArmBuild(
        job, tuple(f"{called}: {note}" for note in (*arm.model.notes, *notes, *more, *slowed)), tuple(unreachable)
    )


def _standing(robot: Robot, mount: Mount | None) -> Arm:
    """The arm on its base where it stands in the world, with tool and load."""
    model: ArmModel = robot.source.model
    arm = Arm(model)
    if mount is None:
        T = placement_pose(robot.pose)
        arm = arm.with_base(T if _is_identity(model.base) else T @ np.array(model.base))
    if robot.tool is None:
        return arm
    T_tool = np.array(model.tool)
    load = _load(robot.tool)
    if load.mass > 0.0:
        arm = arm.with_load(load if _is_identity(model.tool) else _moved(load, T_tool))
    end = pose((0.0, 0.0, robot.tool.length))
    return arm.with_tool(end if _is_identity(model.tool) else T_tool @ end)


def _is_identity(T: object) -> bool:
    return bool(np.array_equal(np.array(T), np.eye(4)))


def _load(tool: GripperTool | RodTool) -> Body:
    """A tool as a solid cylinder along z of the flange."""
    length, mass = tool.length, tool.mass
    width = tool.opening + 2 * tool.finger[1] if isinstance(tool, GripperTool) else 0.1 * length
    across = mass * (3 * (width / 2) ** 2 + length**2) / 12
    along = mass * (width / 2) ** 2 / 2
    return Body(mass, (0.0, 0.0, length / 2), (across, across, along, 0.0, 0.0, 0.0))


def _moved(body: Body, T: Array) -> Body:
    """A body that is stated in a frame, stated in the one in which that frame has the pose T."""
    xx, yy, zz, xy, yz, xz = body.inertia
    R = T[:3, :3]
    inertia = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    x, y, z = (float(v) for v in R @ np.array(body.com) + T[:3, 3])
    turned = [float(inertia[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return fixed_to_body(
        Body(0.0, (0.0, 0.0, 0.0), (0.0,) * 6),
        Body(body.mass, (x, y, z), (turned[0], turned[1], turned[2], turned[3], turned[4], turned[5])),
    )


def _home(robot: Robot) -> tuple[float, ...]:
    """Where it stands at first: what the cell says, else the usual."""
    return robot.home if robot.home is not None else usual_home(robot.source.model)


def usual_home(model: ArmModel) -> tuple[float, ...]:
    """Return where an arm stands of which no cell says it: a pose that its model names, or zeros within the limits."""
    for name in ("nominal", "home"):
        if name in model.poses:
            return model.poses[name]
    limits = Arm(model).limits
    span = limits.upper - limits.lower
    room = np.where(np.isfinite(span), BESIDE * span, 0.0)
    return tuple(float(q) for q in np.clip(np.zeros(len(span)), limits.lower + room, limits.upper - room))


def _driven(
    arm: Arm, robot: Robot, home: Array, path: Path, at: tuple[str | int, ...]
) -> tuple[Arm, str, tuple[str, ...]]:
    """The arm with its drives, what they are, and what was assumed."""
    asked = robot.drives
    if asked == "ideal":
        return arm, "ideal", ()
    try:
        if isinstance(asked, tuple):
            found = _with_motors(arm, asked)
            check_drives(found.model)
            _check_inertia(found)
            return found, "motors", ()
        if asked == "from_limits":
            return sized_drives(arm, home), "from_limits", ()
    except InputError as problem:
        raise CellError(f"{place_in(path, *at, 'drives')}: {problem}") from None
    return _driven_as_stated(arm, home)


def _driven_as_stated(arm: Arm, home: Array) -> tuple[Arm, str, tuple[str, ...]]:
    """What a model states, else drives from its limits, else ideal ones."""
    try:
        check_drives(arm.model)
        _check_inertia(arm)
    except ModelError:
        pass
    else:
        return arm, "motors", ()
    try:
        sized = sized_drives(arm, home)
    except ModelError as problem:
        return arm, "ideal", (f"its drives are ideal: {str(problem).partition(', so')[0]}",)
    return sized, "from_limits", ("its model states no motors; they are sized from its speed and torque limits",)


def _check_inertia(arm: Arm) -> None:
    if arm.model.bodies is None:
        why = f": {arm.model.no_inertia}" if arm.model.no_inertia else ""
        raise ModelError(
            f'arm {arm.model.name!r} states no inertia, so its motors cannot be simulated; use "ideal"{why}'
        )


def _with_motors(arm: Arm, tables: tuple[JointDrive, ...]) -> Arm:
    names = [joint.name for joint in arm.model.joints]
    for table in tables:
        if table.joint is not None and table.joint not in names:
            raise UnknownName("joint", table.joint, names)
    joints = tuple(_with_motor(joint, tables) for joint in arm.model.joints)
    return arm.remade(joints=joints)


def _with_motor(joint: Joint, tables: tuple[JointDrive, ...]) -> Joint:
    """The joint with the motor of the last table that is its own or everyone's."""
    mine = [table for table in tables if table.joint in (None, joint.name)]
    if not mine:
        return joint
    d = max(mine, key=lambda table: table.joint is not None)
    motor = Motor(
        gear_ratio=d.gear_ratio,
        rotor_inertia=d.rotor_inertia,
        torque_constant=d.torque_constant,
        resistance=d.resistance,
        inductance=d.inductance,
        max_voltage=d.supply,
        max_current=d.max_current,
        encoder_counts=d.counts_per_turn,
    )
    return dataclasses.replace(joint, motor=motor)


def _with_limits(arm: Arm, home: Array) -> tuple[Arm, tuple[str, ...]]:
    """The arm with the speed and acceleration limits that motions need, where its model states none."""
    inertia = np.full(arm.n, np.inf)
    if arm.model.bodies is not None:  # as floats: to compile it for one place takes longer than all the rest
        inertia = np.diagonal(np.array(mass_matrix(arm.model, bodies_of(arm.model), home.tolist()), dtype=float))
    slow: list[str] = []
    eager: list[str] = []
    joints = list(arm.model.joints)
    for i, b in zip(arm.model.independent, inertia, strict=True):
        limits, known, name = joints[i].limits, arm.model.limits(i), joints[i].name
        if not (0.0 < known.speed < math.inf):
            limits = dataclasses.replace(limits, speed=SLOW_TURN if joints[i].turns else SLOW_SLIDE)
            slow.append(name)
        speed = known.speed if 0.0 < known.speed < math.inf else limits.speed
        if not (0.0 < known.acceleration < math.inf):
            most = 0.5 * known.torque / b if 0.0 < known.torque < math.inf and 0.0 < b < math.inf else math.inf
            limits = dataclasses.replace(limits, acceleration=min(speed / RUN_UP, most))
            eager.append(name)
        joints[i] = dataclasses.replace(joints[i], limits=limits)
    if not slow and not eager:
        return arm, ()
    return arm.remade(joints=tuple(joints)), tuple(_assumed(slow, eager, arm.n))


def _assumed(slow: list[str], eager: list[str], joints: int) -> Iterator[str]:
    if slow:
        yield f"no speed limit of {_these(slow, joints)} is stated; 1 rad/s (0.25 m/s) is taken"
    if eager:
        yield (
            f"no acceleration limit of {_these(eager, joints)} is stated; taken is what reaches the speed limit in "
            f"{RUN_UP} s, or half the torque limit over the joint's inertia where that is less"
        )


def _these(names: list[str], joints: int) -> str:
    return "its joints" if len(names) == joints else ", ".join(names)


def _program(robot: Robot, turns: tuple[bool, ...], path: Path, at: tuple[str | int, ...]) -> Program | None:
    if robot.program is None:
        return None
    program = load_program(robot.program.file, robot.program.locations, turns=turns)
    try:
        start(program, entry=robot.program.entry)
    except ProgramFault as fault:
        raise CellError(f"{place_in(path, *at, 'program', 'entry')}: {fault}") from None
    return program


def _unreachable(arm: Arm, home: Array, robot: Robot, program: Program | None) -> tuple[str, ...]:
    if program is None or robot.program is None:
        return ()
    places = robot.program.locations or robot.program.file.with_suffix(".loc")
    return tuple(taught_problems(arm, home.tolist(), program, places))


def _gripper(hand: GripperTool) -> Gripper:
    width, thickness, _ = hand.finger
    return Gripper(hand.opening, width, thickness, hand.opening / max(hand.close_time, hand.open_time))


def _ground(cell: Cell, robot: Robot, height: float | None) -> Ground:
    """What lies under the tool: the surface nearest to the arm; under one that is carried at a height, the lowest."""
    if not cell.surface:
        return Ground()
    heights = [surface.pose.position[2] for surface in cell.surface]
    if height is not None:
        return Ground(height=min(heights) - height)
    x, y, _ = placement_pose(robot.pose)[:3, 3]
    apart = [_distance(placement_pose(s.pose), s.size, x, y) for s in cell.surface]
    return Ground(height=heights[int(np.argmin(apart))])


def _distance(T: Array, size: tuple[float, float], x: float, y: float) -> float:
    """Distance of a point of the floor from the middle of a surface, m."""
    middle = T @ np.array([size[0] / 2, size[1] / 2, 0.0, 1.0])
    return float(np.hypot(middle[0] - x, middle[1] - y))

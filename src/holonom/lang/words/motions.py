"""Instructions that move the arm or set how it moves. Millimetres, degrees and per cent become SI here."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from holonom.errors import ProgramFault
from holonom.lang import poses
from holonom.lang.machine import Array, Motion, MotionKind, Tolerance
from holonom.lang.vm.formats import shown
from holonom.lang.vm.state import Speed, Vm
from holonom.lang.words.builtin import Builtin, location, real, target
from holonom.lang.words.functions import dest
from holonom.spatial import inverse

__all__ = ["MOTIONS", "set_speed", "set_tolerance"]

_MM = 1e-3


def _send(vm: Vm, kind: MotionKind, place: Array, speed: Speed | None = None) -> bool:
    """Hand a motion to a location (4, 4) or a precision point (n,) to the machine; False: queue full."""
    settings = vm.state.settings
    chosen = speed or settings.next_speed or settings.speed
    pose = settings.base @ place @ inverse(settings.tool) if place.ndim == 2 else None
    motion = Motion(
        kind=kind,
        pose=pose,
        joints=place if place.ndim == 1 else None,
        speed=chosen.fraction * settings.monitor,
        speed_mps=chosen.mps * settings.monitor if chosen.mps is not None and kind == "line" else None,
        acceleration=settings.acceleration,
        configuration=settings.configuration,
        blend=settings.continuous,
        tolerance=settings.next_tolerance or settings.tolerance,
        line=vm.state.line,
    )
    taken = vm.machine.move(motion)
    if taken:
        settings.next_speed = settings.next_tolerance = None
        vm.state.busy_ticks = 0
    return taken


def _approach(vm: Vm, kind: MotionKind, place: Array, distance: float) -> bool:
    return _send(vm, kind, _drawn_back(place, distance))


def _depart(vm: Vm, kind: MotionKind, distance: float) -> bool:
    return _send(vm, kind, _drawn_back(dest(vm), distance))


def _drawn_back(place: Array, distance: float) -> Array:
    return place @ poses.shift(np.eye(4), 0.0, 0.0, -distance)


def _draw(vm: Vm, dx: float, dy: float, dz: float) -> bool:
    return _send(vm, "line", poses.shift(dest(vm), dx, dy, dz))


def _drive(vm: Vm, joint: float, change: float, speed: float) -> bool:
    if not vm.machine.idle():
        return False
    joints = vm.machine.goal().copy()
    if not (1 <= joint <= joints.size and joint.is_integer()):
        raise ProgramFault(f"DRIVE: no joint {shown(joint)}; this arm has joints 1 to {joints.size}")
    number = int(joint) - 1
    joints[number] += change * poses.joint_unit(vm.machine.turns()[number])
    return _send(vm, "joint", joints, Speed(_percent(speed, "the speed of DRIVE")))


def _ready(vm: Vm) -> bool:
    return _send(vm, "joint", vm.machine.ready_joints())


def _delay(vm: Vm, seconds: float) -> bool:
    state = vm.state
    if seconds < 0.0:
        raise ProgramFault(f"DELAY of {shown(seconds)} s; it takes 0 or more")
    if state.phase == 0:
        if not vm.machine.idle():
            return False
        state.phase, state.until = 1, vm.machine.time() + seconds
    return vm.machine.time() >= state.until - 1e-9


def _accelerate(vm: Vm, percent: float) -> bool:
    vm.state.settings.acceleration = _percent(percent, "ACCEL")
    return True


def _configure(part: str, value: str) -> object:
    def run(vm: Vm) -> bool:
        settings = vm.state.settings
        settings.configuration = replace(settings.configuration, **{part: value})
        return True

    return run


def _tool(vm: Vm, *place: Array) -> bool:
    vm.state.settings.tool = place[0] if place else np.eye(4)
    return True


def _base(vm: Vm, *place: Array) -> bool:
    vm.state.settings.base = place[0] if place else np.eye(4)
    return True


def set_speed(vm: Vm, value: float, words: frozenset[str]) -> None:
    """Set the speed for the next motion, with ALWAYS for all that follow, with MONITOR for the whole run."""
    settings = vm.state.settings
    if "MONITOR" in words:
        settings.monitor = _percent(value, "SPEED MONITOR")
        return
    if "MMPS" in words:
        if value <= 0.0:
            raise ProgramFault(f"SPEED {shown(value)} MMPS; it must be more than 0")
        speed = Speed(settings.speed.fraction, value * _MM)
    else:
        speed = Speed(_percent(value, "SPEED"))
    settings.next_speed = None if "ALWAYS" in words else speed
    if "ALWAYS" in words:
        settings.speed = speed


def set_tolerance(vm: Vm, value: Tolerance, always: bool) -> None:
    """Set how closely the next motion settles, or all that follow."""
    settings = vm.state.settings
    settings.next_tolerance = None if always else value
    if always:
        settings.tolerance = value


def _percent(value: float, what: str) -> float:
    if not 0.0 < value <= 100.0:
        raise ProgramFault(f"{what} is {shown(value)}; it takes more than 0 and at most 100 per cent")
    return value / 100.0


_DISTANCE = real("distance")
_STEPS = (real("dx", 0.0), real("dy", 0.0), real("dz", 0.0))
_JOINT = (real("joint"), real("change"), real("speed"))
_TABLE = (
    ("MOVE", (target(),), lambda vm, p: _send(vm, "joint", p), "go there, all joints arriving together"),
    ("MOVES", (target(),), lambda vm, p: _send(vm, "line", p), "go there on a straight line"),
    (
        "APPRO",
        (location(), _DISTANCE),
        lambda vm, p, d: _approach(vm, "joint", p, d),
        "go where the tool is drawn back `distance` mm along its own z axis",
    ),
    (
        "APPROS",
        (location(), _DISTANCE),
        lambda vm, p, d: _approach(vm, "line", p, d),
        "APPRO on a straight line",
    ),
    ("DEPART", (_DISTANCE,), lambda vm, d: _depart(vm, "joint", d), "draw the tool back along its own z axis"),
    ("DEPARTS", (_DISTANCE,), lambda vm, d: _depart(vm, "line", d), "DEPART on a straight line"),
    ("DRAW", _STEPS, _draw, "straight line by mm along the axes of the base frame"),
    (
        "DRIVE",
        _JOINT,
        _drive,
        "come to rest, then move one joint by degrees, or mm if it slides, at a speed in per cent",
    ),
    ("READY", (), _ready, "go to the READY position of the arm"),
    ("DELAY", (real("seconds"),), _delay, "come to rest and stay there"),
    ("BREAK", (), lambda vm: vm.machine.idle(), "wait until the arm is at rest: ends a continuous path"),
    ("ACCEL", (real("percent"),), _accelerate, "acceleration of the motions that follow"),
    ("TOOL", (location("tool", optional=True),), _tool, "tool transformation; without one, none"),
    ("BASE", (location("frame", optional=True),), _base, "frame of all locations in the world; without one, the world"),
    ("LEFTY", (), _configure("shoulder", "lefty"), "shoulder to the left, from the next motion on"),
    ("RIGHTY", (), _configure("shoulder", "righty"), "shoulder to the right"),
    ("ABOVE", (), _configure("elbow", "above"), "elbow above"),
    ("BELOW", (), _configure("elbow", "below"), "elbow below"),
    ("FLIP", (), _configure("wrist", "flip"), "wrist flipped"),
    ("NOFLIP", (), _configure("wrist", "noflip"), "wrist not flipped"),
)

MOTIONS = tuple(Builtin(*row) for row in _TABLE)

"""`BaseLog`: what happened to a simulated base, at 1 kHz, and the events in it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from holonom.mobile.drive.slip import SlipStatus
from holonom.signals import Event
from holonom.sim.base.records import BODY_GROUPS, FLAGGED, HELD, LOST, STATUS

__all__ = ["BaseLog", "log_of"]

Array = NDArray[np.float64]

PAUSE = 200  # ms


@dataclass(frozen=True, slots=True)
class BaseLog:
    """N samples of a base with m driven wheels; SI units, twists in base_link, poses in the world.

    Attributes
    ----------
    time
        (N,) s.
    wheels
        Names of the m wheels.
    pose, twist
        (N, 3) true.
    estimated_pose, estimated_twist
        (N, 3) as the controller believes.
    reference_pose, reference_twist
        (N, 3) as asked for at that time.
    rate
        (N,) part of the path's speed at which it is driven; below 1 once motors are lost that it would need.
    wheel_angles
        (N, m) of the wheels since the start, rad, true.
    counts
        (N, m) of their encoders since the start.
    wheel_speeds, measured_speeds, reference_speeds
        (N, m) of the wheels, rad/s: true, by the encoders' observers, commanded.
    currents, measured_currents, voltages
        (N, m) A, A, V.
    forces, cross_forces, loads, friction_limits
        (N, m) N: on the base along the drive direction and across it; wheel load; `mu N` at the peak.
    slip
        (N, m) rim faster than the floor, m/s, true.
    residuals
        (N, m) `m - D D^+ m` of the measured rim speeds, m/s.
    status, named
        (N,) codes of `SlipStatus`; (N, m) wheels named as slipping.
    dead, jammed
        (N, m) motors that the controller drives without; those of them that it takes for jammed.
    gyro, acceleration
        (N,) rad/s and (N, 2) m/s^2 as the IMU measures them.
    energy
        (N, 5) J since the start: supplied, armature heat, air-gap work, lost in motors and gears, lost on the floor.
    events
        What a reader of the log wants to know first.
    ended
        How the run ended: "done" at the end of the path, "jammed" where a jammed wheel stopped the base, "cut off"
        where it would have taken more than five times as long as the path.
    driven
        Part of the path's length that the reference had gone by then, 0 to 1.
    """

    time: Array
    wheels: tuple[str, ...]
    pose: Array
    twist: Array
    estimated_pose: Array
    estimated_twist: Array
    reference_pose: Array
    reference_twist: Array
    rate: Array
    wheel_angles: Array
    counts: NDArray[np.int64]
    wheel_speeds: Array
    measured_speeds: Array
    reference_speeds: Array
    currents: Array
    measured_currents: Array
    voltages: Array
    forces: Array
    cross_forces: Array
    loads: Array
    friction_limits: Array
    slip: Array
    residuals: Array
    status: NDArray[np.int64]
    named: NDArray[np.bool_]
    dead: NDArray[np.bool_]
    jammed: NDArray[np.bool_]
    gyro: Array
    acceleration: Array
    energy: Array
    events: tuple[Event, ...] = ()
    ended: str = "done"
    driven: float = 1.0

    @property
    def path_error(self) -> Array:
        """(N,) m, distance of the true place from where the reference is at that time."""
        error: Array = np.hypot(*(self.pose - self.reference_pose)[:, :2].T)
        return error

    @property
    def heading_error(self) -> Array:
        """(N,) rad, true heading less the reference's, in [-pi, pi)."""
        turn = self.pose[:, 2] - self.reference_pose[:, 2]
        error: Array = (turn + np.pi) % (2.0 * np.pi) - np.pi
        return error

    @property
    def flagged(self) -> NDArray[np.int64]:
        """(N,) index of the wheel named as slipping; -1 where none or two are."""
        one: NDArray[np.int64] = np.where(self.named.sum(axis=1) == 1, self.named.argmax(axis=1), -1)
        return one


def log_of(
    time: Array,
    body: NDArray[np.void],
    wheels: NDArray[np.void],
    said: NDArray[np.int64],
    names: Sequence[str],
    told: Sequence[Event] = (),
    *,
    residual: Array | None = None,
    ended: str = "done",
    driven: float = 1.0,
) -> BaseLog:
    """Arrays and events from the records of the compiled loop.

    `told` are events that the caller knows of; `residual` (m, m) is `1 - D D^+` times the wheels' radii (zero without).
    """
    status = np.ascontiguousarray(said[:, STATUS])
    named, dead, jammed = (_members(said[:, column], len(names)) for column in (FLAGGED, LOST, HELD))
    events = [
        *told,
        *_slip_events(time, status, said[:, FLAGGED], named, names),
        *_lost_events(time, dead, jammed, body["rate"], names),
    ]
    of_wheels = {name: wheels[name].reshape(len(wheels), -1)[:, : len(names)] for name in wheels.dtype.names or ()}
    columns = body.view(np.float64).reshape(len(body), -1)
    groups, first = {}, 0
    for name, fields in BODY_GROUPS.items():
        groups[name] = columns[:, first : first + len(fields)]
        first += len(fields)
    return BaseLog(
        time=time,
        wheels=tuple(names),
        pose=groups["pose"],
        twist=groups["twist"],
        estimated_pose=groups["estimated_pose"],
        estimated_twist=groups["estimated_twist"],
        reference_pose=groups["reference_pose"],
        reference_twist=groups["reference_twist"],
        rate=groups["rate"][:, 0],
        wheel_angles=of_wheels["angle"],
        counts=of_wheels["count"],
        wheel_speeds=of_wheels["speed"],
        measured_speeds=of_wheels["measured_speed"],
        reference_speeds=of_wheels["reference_speed"],
        currents=of_wheels["current"],
        measured_currents=of_wheels["measured_current"],
        voltages=of_wheels["voltage"],
        forces=of_wheels["force"],
        cross_forces=of_wheels["cross_force"],
        loads=of_wheels["load"],
        friction_limits=of_wheels["friction_limit"],
        slip=of_wheels["slip"],
        residuals=of_wheels["measured_speed"] @ (np.zeros((len(names),) * 2) if residual is None else residual.T),
        status=status,
        named=named,
        dead=dead,
        jammed=jammed,
        gyro=body["gyro"],
        acceleration=groups["acceleration"],
        energy=groups["energy"],
        events=tuple(sorted(events, key=lambda event: event.time)),
        ended=ended,
        driven=driven,
    )


def _members(sets: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    """(N, count) whether each wheel is in each set."""
    if not sets.any():
        return np.zeros((len(sets), count), np.bool_)
    members: NDArray[np.bool_] = (sets[:, None] >> np.arange(count)) & 1 == 1
    return members


def _slip_events(
    time: Array, status: NDArray[np.int64], flagged: NDArray[np.int64], named: NDArray[np.bool_], names: Sequence[str]
) -> list[Event]:
    """An event wherever the detector says something new; silence of less than `PAUSE` ends nothing."""
    slips = (status == SlipStatus.SLIP) | (status == SlipStatus.AMBIGUOUS)
    changed = np.flatnonzero((np.diff(status, prepend=0) != 0) | (np.diff(flagged, prepend=0) != 0))
    events: list[Event] = []
    said = ""
    for k in changed:
        if slips[k]:
            text = _slip_text([n for n, s in zip(names, named[k], strict=True) if s])
            if text != said:
                events.append(Event(float(time[k]), "warning", "slip detection", text))
            said = text
        elif said and not slips[k : k + PAUSE].any():
            events.append(Event(float(time[k]), "info", "slip detection", "no wheel slips any more"))
            said = ""
    return events


def _slip_text(named: list[str]) -> str:
    if not named:
        return "a wheel slips; which one is ambiguous"
    return f"{' and '.join(named)} {'slips' if len(named) == 1 else 'slip'}"


def _lost_events(
    time: Array, dead: NDArray[np.bool_], jammed: NDArray[np.bool_], rate: Array, names: Sequence[str]
) -> list[Event]:
    """When each motor was found lost, and how the base goes on."""
    events = []
    for name, lost, held in zip(names, dead.T, jammed.T, strict=True):
        if len(lost) and lost[-1]:
            text = f"the motor of {name} does not do as told; {_go_on(bool(held[-1]), float(rate[-1]))}"
            events.append(Event(float(time[int(lost.argmax())]), "error", "motor watch", text))
    return events


def _go_on(jammed: bool, rate: float) -> str:
    if jammed:
        return "it is jammed, the base stops"
    return "driving on without it" + (f", at {100.0 * rate:.0f} % of the speed" if 0.0 < rate < 0.999 else "")

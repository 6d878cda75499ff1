"""`BaseController`: keeps a path, follows velocities or holds; the plant, real or simulated, it never sees."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, real_array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.compiled import MEMORY
from holonom.control.path_laws.mpc import LEFT, LinearMpc
from holonom.devices.drive_signals import WheelSignals
from holonom.errors import ShapeError
from holonom.machine.base.balancing import leaning_path, pendulum_of
from holonom.machine.base.kernels import HOLD, PATH, RUNNING, VELOCITY, control_step
from holonom.machine.base.known import TICK, base_params, held_rows, known_wheel, max_rim_speed, wheel_loop
from holonom.machine.base.laws import fitted_law
from holonom.machine.base.params import BaseTask, Work
from holonom.machine.base.records import CONTROL_STATE, KNOWN_WHEEL, SEEN_WHEEL
from holonom.machine.base.settings import BaseSettings, Creep
from holonom.machine.base.steering_kernels import look_at_wheels
from holonom.machine.base.wheel_kernels import share_force
from holonom.mobile.base.wheel import KINDS
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive
from holonom.mobile.drive.slip_kernels import NO_SLIP, UNDETECTABLE
from holonom.trace.call.records import aligned_records, side_by_side
from holonom.trace.code.simd import WIDTH

__all__ = ["TICK", "BaseController"]


FOR_EVER = 1 << 40  # ms
NO_PATH, NO_LEAN = np.zeros((0, 9)), np.zeros((0, 3))


class BaseController:
    """The controller of a base. Mutable state: the records `state` and `states`, the arrays `work`, `task`.

    Parameters
    ----------
    base
        Wheels, mass and its distribution.
    drive
        Data sheets of motors, gears and encoders.
    settings
        Its parts and their numbers.
    creep
        What is known of gripping wheels where the settings do not say.

    Raises
    ------
    ModelError
        A base without mass, or one that no forces of its wheels can drive.
    """

    def __init__(
        self,
        base: WheelBase,
        drive: BaseDrive,
        settings: BaseSettings = BaseSettings(),
        *,
        creep: Creep = Creep(0.0, 1.0),
    ) -> None:
        self.base, self.drive, self.settings = base, drive, settings
        driven = [wheel for wheel in base.wheels if wheel.driven for _ in KINDS[wheel.kind].speeds(wheel)]
        self.radii = base.wheel_radii
        rows = np.ascontiguousarray(base.rest_coupling * [1.0, 1.0, base.radius])
        self.loop = wheel_loop(base, drive)
        """Tuned speed loop of the wheels, with its margins."""
        self.law = fitted_law(settings.law, base, settings.keeping, max_rim_speed(drive, self.radii))
        """How it keeps a path, within its limits; None where it moves along y at once."""
        self.params = base_params(base, drive, settings, self.law, settings.creep or creep, rows, self.radii)
        known = [
            known_wheel(wheel, row, most, drive, self.loop)
            for wheel, row, most in zip(driven, rows, self.params.max_force, strict=True)
        ]
        self.wheels = side_by_side(np.array(known, KNOWN_WHEEL))
        self.state = aligned_records(np.zeros(1, CONTROL_STATE), CONTROL_STATE)
        seen = np.zeros(len(driven), SEEN_WHEEL)
        seen["works"] = seen["cut"] = 1.0
        self.states = side_by_side(seen, works=0.0)
        estimate_rows = np.ascontiguousarray(np.vstack([rows, held_rows(base)]))
        lanes, trusted = WIDTH * len(self.states), len(estimate_rows)
        self.work = Work(
            rows, estimate_rows,
            np.ones(trusted), self.params.bearing.copy(), np.zeros((len(driven), 3)), np.zeros(max(lanes, trusted)),
            np.zeros(lanes), np.zeros(lanes), np.full(3, np.nan), np.zeros(9),
            np.zeros(len(base.wheels)), np.zeros((len(base.wheels), 2)), np.zeros(3), np.zeros(len(base.wheels)),
            np.zeros(trusted),
        )  # fmt: skip
        self.task = BaseTask(NO_PATH, NO_LEAN)
        self._planner: LinearMpc | None = None
        if self.params.steered is None:
            share_force(self.params.pull_rows, self.params.pull, self.work.weights, self.work.share, self.states)
        slip = self.state["slip"][0]
        for name in ("slack", "angular_slack", "held_slack", "held_angular_slack"):
            slip[name] = math.inf
        checked = self.params.detect or self.params.check is not None
        self.state["rate"] = self.state["goal"] = 1.0
        self.state["status"] = UNDETECTABLE if settings.slip is not None and not checked else NO_SLIP
        self.hold()

    def place(self, pose: ArrayLike, twist: ArrayLike = (0.0, 0.0, 0.0), *, signals: WheelSignals) -> None:
        """Tell it where it is, pose (3,) in odom, and how it moves, twist (3,) in base_link; it homes its counters.

        Raises
        ------
        ShapeError
            Not three finite numbers each; it goes on as before.
        """
        pose, twist = finite_array("pose", pose, (3,)), finite_array("twist", twist, (3,))
        state, states, ratio = self.state[0], self.states, self.wheels["gear"]["ratio"]
        for names, values in ((("x", "y", "theta"), pose), (("vx", "vy", "w"), twist)):
            for name, value in zip(names, values, strict=True):
                state[f"seen_{name}"] = value
        for name in ("vx", "vy", "w"):
            state[f"command_{name}"] = state[f"shaped_{name}"] = state[f"seen_{name}"]
        state["check_vx"], state["check_vy"] = twist[0], twist[1]
        state["rise_x"] = state["rise_y"] = 0.0
        state["rests"] = 0
        state["stands"] = 0 if self.params.balance is not None or np.any(twist) else 1
        if self.params.balance is not None:  # at rest it hangs on what its accelerometers show
            state["seen_pitch"] = -math.atan2(signals.inertial[1], signals.inertial[4])
            state["seen_pitch_rate"] = state["pitch_bias"] = state["trim"] = 0.0
            state["seen_along"] = twist[0]
        states["count"].flat[:] = (signals.counters + 0x8000) % 0x10000 - 0x8000
        states["seen_angle"] = states["counted"] = (states["count"] + 0.5) * self.wheels["encoder"]["resolution"]
        if self.params.steered is not None:
            self.work.swung[:], self.work.steering_rates[:] = signals.turned[: len(self.work.swung)], 0.0
            look_at_wheels(self.params.steered, signals, self.work, self.wheels)
        speeds = self.work.rows @ twist / self.radii
        states["seen_speed"].flat[: len(speeds)] = ratio.flat[: len(speeds)] * speeds
        self.hold()

    @property
    def pose(self) -> Array:
        """Where it believes to be (3,): x, y, theta of base_link in odom."""
        return np.array([self.state[name][0] for name in ("seen_x", "seen_y", "seen_theta")])

    @property
    def twist(self) -> Array:
        """How it believes to move (3,), in base_link."""
        return np.array([self.state[name][0] for name in ("seen_vx", "seen_vy", "seen_w")])

    @property
    def silence(self) -> str:
        """Why it stops although a velocity was asked for: a sentence, "" where it does not."""
        state, timeout = self.state[0], self.params.shaping.timeout
        moving = any(state[f"wanted_{name}"] != 0.0 for name in ("vx", "vy", "w"))
        if state["mode"] != VELOCITY or not moving or state["age"] * TICK <= timeout:
            return ""
        return f"the level above is silent: no velocity came for {1e3 * state['age'] * TICK:.0f} ms"

    @property
    def ending(self) -> int:
        """How far its path is: `RUNNING`, `DONE`, `STOPPED`."""
        return int(self.state["ended"][0])

    def follow_path(self, path: ArrayLike) -> None:
        """Keep a path (N, 9) from its first sample on: pose, twist and acceleration at 1 kHz.

        Raises
        ------
        ShapeError
            A path of another shape, empty or not finite.
        """
        rows = np.ascontiguousarray(real_array("a path", path))
        if rows.ndim != 2 or rows.shape[1] != 9 or len(rows) == 0 or not np.isfinite(rows).all():
            raise ShapeError(f"a path has shape {rows.shape}; it must be (N, 9) with N of at least 1, finite")
        self.task = BaseTask(rows, self._lean(rows))
        self._do(PATH)
        self.state["phase"] = self.state["law"] = 0.0
        self._planner = LinearMpc(self.law.settings) if isinstance(self.law, LinearMpc) else None

    def plan(self) -> int:
        """Plan anew where the law of the path plans and it is time; return the milliseconds that its plan lasts.

        Raises
        ------
        MissingExtra
        RunError
            There was no plan.
        """
        if self._planner is None:
            return FOR_EVER
        state = self.state[0]
        if state["mode"] != PATH:
            return FOR_EVER
        memory = state["law"][MEMORY:]
        if memory[LEFT] <= 0.0:
            before = Planar(*(float(state[f"command_{name}"]) for name in ("vx", "vy", "w")))
            pose = Planar(*self.pose.tolist())
            self._planner.plan_into(memory, self.task.path, float(state["phase"]), pose, before)
        return int(memory[LEFT])

    def follow_velocity(self, twist: Sequence[float] | Array, about: Sequence[float] | Array = (0.0, 0.0)) -> None:
        """Follow a twist (3,) in base_link, m/s and rad/s, until the next one or until it is too old.

        It is taken to the nearest one that the wheels can drive, within the limits of `ShapingSettings`.

        Parameters
        ----------
        twist : of the place `about`.
        about : (x, y), m in base_link: what is to move so, and what the base turns about without any speed.

        Raises
        ------
        ShapeError
            Not three finite numbers, or no place; what was asked for before goes on.
        """
        state = self.state
        vx, vy, w = _three(twist)
        x, y, _ = _three((*about, 0.0))
        finite = math.isfinite(vx + vy + w) and math.isfinite(x + y)
        if not finite:
            raise ShapeError(
                f"a twist is {twist!r} about {about!r}; it must be three finite numbers, vx, vy in m/s, w in rad/s, "
                "and a place, two in m"
            )
        vx, vy = vx + w * y, vy - w * x  # of base_link (`poses.twist_at`)
        if state["mode"][0] != VELOCITY:
            self._do(VELOCITY)
        state["wanted_vx"], state["wanted_vy"], state["wanted_w"], state["age"] = vx, vy, w, 0

    def hold(self) -> None:
        """Stop, and hold the pose where it is now."""
        self._do(HOLD)
        for name in ("x", "y", "theta"):
            self.state[f"hold_{name}"] = self.state[f"seen_{name}"]

    def _lean(self, path: Array) -> Array:
        """How a body that balances leans along a path (N, 9)."""
        if self.params.balance is None:
            return NO_LEAN
        return leaning_path(pendulum_of(self.base, self.drive, self.params.balance.gains.max_force), path[:, 6], TICK)

    def _do(self, mode: int) -> None:
        state = self.state
        for name in ("ahead_of", "led_rate", "led_change", "led_turn_rate", "led_turn_change"):
            state[name] = 0.0
        state["led"], state["led_turn"] = state["seen_along"], state["seen_w"]
        state["mode"], state["ended"] = mode, RUNNING
        for name in ("integral_x", "integral_y", "integral_theta"):
            state[name] = 0.0
        for speed, change in (("vx", "ax"), ("vy", "ay"), ("w", "aw")):
            state[f"shaped_{speed}"], state[f"shaped_{change}"] = state[f"command_{speed}"], 0.0

    def step(self, signals: WheelSignals) -> None:
        """One millisecond: from what `signals` holds of the sensors to the voltages in it."""
        control_step(self.params, self.task, signals, self.state, self.wheels, self.states, self.work)


def _three(twist: Sequence[float] | Array) -> tuple[float, float, float]:
    """Return three numbers, NaN where they are none."""
    try:
        vx, vy, w = twist
        return float(vx), float(vy), float(w)
    except (TypeError, ValueError):
        return math.nan, math.nan, math.nan

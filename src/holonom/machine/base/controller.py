"""`BaseController`: keeps a path, follows velocities or holds; the plant, real or simulated, it never sees."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, real_array
from holonom.control import ServoAxis
from holonom.control.base.force_kernels import Body
from holonom.control.base.kernels import EstimateParams, WatchParams
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.control.base.tuning import WheelLoop, tune_wheel
from holonom.devices import tracking_params
from holonom.devices.drive_signals import WheelSignals
from holonom.errors import ShapeError
from holonom.machine.base.balance_kernels import BalanceParams
from holonom.machine.base.balancing import balance_params, leaning_path, pendulum_of
from holonom.machine.base.kernels import HOLD, PATH, RUNNING, VELOCITY, control_step
from holonom.machine.base.params import BaseParams, BaseTask, Work
from holonom.machine.base.records import CONTROL_STATE, KNOWN_WHEEL, SEEN_WHEEL
from holonom.machine.base.settings import KEEP, BaseSettings, Creep, slip_settings
from holonom.machine.base.steering_kernels import SteeredParams, look_at_wheels
from holonom.machine.base.wheel_kernels import share_force
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.base.dynamics import inertia_over_mass
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import GRAVITY, BaseDrive, base_mass, rest_loads, roller_cosines, standing_wheels
from holonom.mobile.drive.coupling import coupling_at_rest
from holonom.mobile.drive.slip import SlipSettings, detectable, slip_params
from holonom.mobile.drive.slip_kernels import BOUND, NO_SLIP, UNDETECTABLE, SlipParams
from holonom.trace.call.records import aligned_records, side_by_side
from holonom.trace.code.simd import WIDTH

__all__ = ["TICK", "BaseController"]


TICK = 1e-3
"""Sample time of all loops of a base, s."""
RESERVE = 0.85  # part of the largest force that a slowed-down path may need; the rest is for errors
RATE_CHANGE = 1.0  # 1/s, how fast a path is slowed down
COULOMB_SMOOTHING = 2.0  # rad/s of the motor, below which friction that is fed forward goes over into its opposite
FIRST = {"both": (1.0, 1.0, 1.0), "path": (1.0, 1.0, 0.03), "heading": (0.03, 0.03, 1.0)}
"""Weights of force and torque / R, where lost motors cannot make both."""
LEANING_PULL = 5.0  # m/s2 that wheels correct the estimate of a body by whose accelerometers lean with it
LEAST_LOAD = 1e-3  # part of the weight below which a wheel carries nothing to speak of
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
        self.loop = _wheel_loop(base, drive)
        """Tuned speed loop of the wheels, with its margins."""
        self.params = _params(base, drive, settings, settings.creep or creep, rows, self.radii)
        known = [
            _known_wheel(wheel, row, most, drive, self.loop)
            for wheel, row, most in zip(driven, rows, self.params.max_force, strict=True)
        ]
        self.wheels = side_by_side(np.array(known, KNOWN_WHEEL))
        self.state = aligned_records(np.zeros(1, CONTROL_STATE), CONTROL_STATE)
        seen = np.zeros(len(driven), SEEN_WHEEL)
        seen["works"] = seen["cut"] = 1.0
        self.states = side_by_side(seen, works=0.0)
        estimate_rows = np.ascontiguousarray(np.vstack([rows, base.sliding_matrix()]))
        lanes, trusted = WIDTH * len(self.states), len(estimate_rows)
        self.work = Work(
            rows, estimate_rows,
            np.ones(trusted), self.params.bearing.copy(), np.zeros((len(driven), 3)), np.zeros(max(lanes, trusted)),
            np.zeros(lanes), np.zeros(lanes), np.full(3, np.nan), np.zeros(9),
        )  # fmt: skip
        self.task = BaseTask(NO_PATH, NO_LEAN)
        if self.params.steered is None:
            share_force(self.params.pull_rows, self.params.pull, self.work.weights, self.work.share, self.states)
        slip = self.state["slip"][0]
        for name in ("slack", "angular_slack", "held_slack", "held_angular_slack"):
            slip[name] = math.inf
        self.state["rate"] = self.state["goal"] = 1.0
        self.state["status"] = UNDETECTABLE if settings.slip is not None and not self.params.detect else NO_SLIP
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
        if self.params.balance is not None:  # at rest it hangs on what its accelerometers show
            state["seen_pitch"] = -math.atan2(signals.inertial[1], signals.inertial[4])
            state["seen_pitch_rate"] = state["pitch_bias"] = state["trim"] = 0.0
            state["seen_along"] = twist[0]
        states["count"].flat[:] = (signals.counters + 0x8000) % 0x10000 - 0x8000
        states["seen_angle"] = states["counted"] = (states["count"] + 0.5) * self.wheels["encoder"]["resolution"]
        if self.params.steered is not None:
            look_at_wheels(self.params.steered, signals, self.work.rows, self.work.estimate_rows, self.wheels)
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
        self.state["phase"] = 0.0

    def follow_velocity(self, twist: Sequence[float] | Array) -> None:
        """Follow a twist (3,) in base_link, m/s and rad/s, until the next one or until it is too old.

        It is taken to the nearest one that the wheels can drive, within the limits of `ShapingSettings`.

        Raises
        ------
        ShapeError
            Not three finite numbers; what was asked for before goes on.
        """
        state = self.state
        vx, vy, w = _three(twist)
        finite = math.isfinite(vx + vy + w)
        if not finite:
            raise ShapeError(f"a twist is {twist!r}; it must be three finite numbers: vx, vy in m/s, w in rad/s")
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


def _params(
    base: WheelBase, drive: BaseDrive, settings: BaseSettings, creep: Creep, rows: Array, radii: Array
) -> BaseParams:
    mass, each = base_mass(base), _wheel_of_row(base)
    loads, cosines = rest_loads(base)[each], roller_cosines(base)[each]
    bearing = np.maximum(loads, LEAST_LOAD * mass * GRAVITY)
    most = _max_force(drive, radii, cosines * bearing, settings.friction)
    coupling = coupling_at_rest(base)
    inverse = np.linalg.pinv(coupling.velocity)
    slip = settings.slip if not (base.steered or base.balances) and detectable(coupling) else None
    if isinstance(slip, str):
        slip = slip_settings(settings.sensors, drive, float(radii.max()))
    slipping = slip_params(coupling, slip) if slip is not None else _no_slip_params(len(rows))
    motor, gear = drive.motor, drive.gear
    force_per_ampere = motor.torque_constant * gear.ratio * gear.efficiency / radii
    drivable = base.steerable
    first = np.array(FIRST[settings.keep]) * [1.0, 1.0, 1.0 if settings.keep == "both" else 1.0 / base.radius]
    scale = np.array([1.0, 1.0, base.radius])
    momentum = mass * inertia_over_mass(base.radius, base.alpha, base.com) * np.outer(scale, scale)
    return BaseParams(
        keeping=settings.keeping.params(TICK),
        shaping=settings.shaping.params(TICK),
        estimate=_estimate_params(base, settings),
        traction=(settings.traction or TractionSettings()).params(TICK),
        watch=_watch_params(base, settings),
        slip=slipping,
        steered=_steered_params(base, drive) if base.steered else None,
        balance=_balance(base, drive, settings, most),
        drivable=np.ascontiguousarray(drivable),
        residual=np.eye(len(rows)) - coupling.velocity @ inverse,
        inverse=np.ascontiguousarray(inverse),
        quiet=_quiet(slip, slipping),
        grip_per_ampere=np.append(force_per_ampere / (cosines * bearing * creep.grip), np.zeros(-len(rows) % WIDTH)),
        creep=np.append(creep.slope * creep.grip / cosines, np.zeros(-len(rows) % WIDTH)),
        body=Body(mass, base.alpha * mass * base.radius**2, *base.com.tolist()),
        pull_rows=np.ascontiguousarray(rows @ drivable * first),
        pull=np.ascontiguousarray(first[:, None] * drivable.T),
        momentum=np.ascontiguousarray(momentum),
        keep=KEEP.index(settings.keep),
        max_force=most,
        bearing=bearing / bearing.mean(),
        max_rim=motor.no_load_speed / abs(gear.ratio) * float(radii.min()),
        path_force=RESERVE * most,
        rate_change=RATE_CHANGE,
        sideways=moves_sideways(base),
        detect=slip is not None,
        control_traction=settings.traction is not None,
        compensate=settings.watch is not None,
    )


def _balance(base: WheelBase, drive: BaseDrive, settings: BaseSettings, most: Array) -> BalanceParams | None:
    """What keeps a body up, with the largest forces (m,) of its rims."""
    if not base.balances or settings.balance is None:
        return None
    return balance_params(base, drive, settings.balance, float(most.sum()), TICK)


def _wheel_of_row(base: WheelBase) -> list[int]:
    """Which driven wheel each driven row belongs to: a ball has two."""
    driven = [wheel for wheel in base.wheels if wheel.driven]
    return [k for k, wheel in enumerate(driven) for _ in KINDS[wheel.kind].speeds(wheel)]


def _estimate_params(base: WheelBase, settings: BaseSettings) -> EstimateParams:
    """Wheels that skid do not tell how fast the base turns, so nothing of the gyro's zero."""
    params = settings.estimate.params(TICK)
    if base.balances:  # its accelerometers lean with it
        params = params._replace(max_pull=LEANING_PULL)
    return params._replace(bias_gain=0.0) if any(wheel.kind == "skid" for wheel in base.wheels) else params


def _watch_params(base: WheelBase, settings: BaseSettings) -> WatchParams:
    """Wheels under a body that balances stand and turn as it needs: one that stands is not jammed."""
    params = (settings.watch or WatchSettings()).params(TICK)
    return params._replace(jam_patience=math.inf) if base.balances else params


def _steered_params(base: WheelBase, drive: BaseDrive) -> SteeredParams:
    """Wheels of a base that steers; their lanes in the signals are those of `standing_wheels`."""
    standing = [wheel.name for wheel in standing_wheels(base)]
    slides = [k for k, wheel in enumerate(base.wheels) if wheel.name in base.sliding_names]
    radius = base.turning_radius
    return SteeredParams(
        places=np.array([(*wheel.acting, wheel.heading) for wheel in base.wheels]),
        limits=np.array([math.inf if wheel.max_steering is None else wheel.max_steering for wheel in base.wheels]),
        lanes=np.array([standing.index(w.name) if w.kind == "steered" else -1 for w in base.wheels], dtype=np.int64),
        driven=np.array([k for k, wheel in enumerate(base.wheels) if wheel.driven], dtype=np.int64),
        sliding=np.array(slides, dtype=np.int64),
        curvature=1.0 / max(radius, 1e-9),
        ahead=drive.steering.lag,
    )


def _no_slip_params(count: int) -> SlipParams:
    """Params of a detector that is not asked."""
    return SlipParams(
        1.0, 1.0, np.zeros((count, 4)), np.zeros((1, 5 + 3 * count)), 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0, -1, 1, 1, 1
    )


def _quiet(slip: SlipSettings | None, params: SlipParams) -> float:
    """Bound of the detector on the square sum of the residual, (m/s)^2, where it is one number for all wheels."""
    if slip is None or params.redundancy <= 0 or not isinstance(slip.noise, float):
        return -1.0
    return float(params.hypotheses[0, BOUND]) * slip.noise**2


def _max_force(drive: BaseDrive, radii: Array, loads: Array, friction: float) -> Array:
    """Force (m,), N, along its rim that each wheel can be asked for: its motor's, or what an assumed friction carries.

    `loads` are times the cosines of the rollers' angles.
    """
    motor, gear = drive.motor, drive.gear
    torque = motor.torque_constant * min(motor.max_current, motor.max_voltage / motor.resistance)
    return np.asarray(np.minimum(abs(gear.ratio) * gear.efficiency * torque / radii, friction * loads))


def _wheel_loop(base: WheelBase, drive: BaseDrive) -> WheelLoop:
    """Tune for the largest share of the base that the wheels carry in any of its motions."""
    coupling = coupling_at_rest(base)
    S = coupling.motions
    inertia = S.T @ inertia_over_mass(base.radius, base.alpha, base.com) @ S * base_mass(base)
    mobile = np.linalg.svd(coupling.velocity @ S @ np.linalg.inv(np.linalg.cholesky(inertia)).T, compute_uv=False)
    share = 1.0 / float(mobile[mobile > 1e-6 * mobile[0]].min()) ** 2 * float(max(w.radius for w in base.wheels)) ** 2
    at_motor = 1.0 / drive.gear.ratio**2
    motor = drive.motor
    axis = ServoAxis(
        resistance=motor.resistance,
        inductance=motor.inductance,
        torque_constant=motor.torque_constant,
        back_emf_constant=motor.back_emf_constant,
        inertia=at_motor * (drive.inertia + share),
        max_voltage=motor.max_voltage,
        max_current=motor.max_current,
        max_speed=motor.no_load_speed,
        counts_per_rev=drive.encoder.counts_per_rev,
        viscous=drive.friction.viscous,
    )
    return tune_wheel(axis, at_motor * drive.inertia, dt=TICK)


def _known_wheel(
    wheel: Wheel, row: Sequence[float], most: float, drive: BaseDrive, loop: WheelLoop
) -> tuple[object, ...]:
    """The motor as the plant's own step has it, half a millisecond: what is known of it does not depend on steps."""
    return (
        *row, wheel.radius, math.cos(wheel.roller_angle), most, drive.inertia, drive.motor.torque_constant,
        tuple(drive.motor.armature(TICK)), tuple(drive.friction.params(COULOMB_SMOOTHING)), tuple(drive.gear.params()),
        tuple(drive.encoder.params()), tuple(tracking_params(loop.observer_bandwidth, TICK)), tuple(loop.speed),
    )  # fmt: skip

"""What a base's controller knows: its params, from wheels, mass, data sheets and settings."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from holonom.arrays import Array
from holonom.control import ServoAxis
from holonom.control.base.force_kernels import Body
from holonom.control.base.inertial_check import CheckParams, PushParams
from holonom.control.base.kernels import EstimateParams, WatchParams
from holonom.control.base.shaping_kernels import AxisShape
from holonom.control.base.skid_kernels import SkidParams
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.control.base.tuning import WheelLoop, tune_wheel
from holonom.devices import tracking_params
from holonom.machine.base.balance_kernels import BalanceParams
from holonom.machine.base.balancing import balance_params
from holonom.machine.base.laws import Law, path_law_call
from holonom.machine.base.params import BaseParams
from holonom.machine.base.settings import KEEP, BaseSettings, Creep, slip_settings
from holonom.machine.base.steering_kernels import SteeredParams
from holonom.mobile.base.drivable import moves_sideways, skids
from holonom.mobile.base.dynamics import inertia_over_mass
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import GRAVITY, BaseDrive, base_mass, rest_loads, roller_cosines, standing_wheels
from holonom.mobile.drive.coupling import coupling_at_rest
from holonom.mobile.drive.slip import SlipSettings, detectable, slip_params
from holonom.mobile.drive.slip_kernels import BOUND, SlipParams
from holonom.mobile.equations.wheels import sliding_row, unit
from holonom.trace.code.simd import WIDTH

__all__ = ["TICK", "base_params", "held_rows", "known_wheel", "max_rim_speed", "wheel_loop"]

TICK = 1e-3
"""Sample time of all loops of a base, s."""
RESERVE = 0.85  # part of the largest force that a slowed-down path may need; the rest is for errors
RATE_CHANGE = 1.0  # 1/s, how fast a path is slowed down
COULOMB_SMOOTHING = 2.0  # rad/s of the motor, below which friction that is fed forward goes over into its opposite
FIRST = {"both": (1.0, 1.0, 1.0), "path": (1.0, 1.0, 0.03), "heading": (0.03, 0.03, 1.0)}
"""Weights of force and torque / R, where lost motors cannot make both."""
SHARP = 0.6  # of the slip at which friction saturates: a skidding wheel slips far beyond where it is linear
LEANING_PULL = 5.0  # m/s2 that wheels correct the estimate of a body by whose accelerometers lean with it
SURE, LEVEL = 6.0, 0.02  # deviations that noise is not beyond; m/s2 that no slope is
PUSHING = ("fixed", "steered", "swedish", "skid")
"""Kinds of wheels that one motor turns, and whose push is what its torque does not turn them with."""
SKIDDING_IDLE = 3.0  # how much longer wheels that skid, and drag each other, may push nothing
LEAST_LOAD = 1e-3  # part of the weight below which a wheel carries nothing to speak of


def base_params(
    base: WheelBase, drive: BaseDrive, settings: BaseSettings, law: Law | None, creep: Creep, rows: Array, radii: Array
) -> BaseParams:
    """Params of a controller's compiled step; rows (m, 3) and wheel radii (m,), m, of the driven rims."""
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
        law=path_law_call(law, TICK),
        estimate=_estimate_params(base, settings),
        traction=(settings.traction or TractionSettings()).params(TICK),
        watch=_watch_params(base, settings),
        slip=slipping,
        check=_check_params(base, settings, drivable),
        pushes=_push_params(base, settings),
        steered=_steered_params(base, drive) if base.steered else None,
        balance=_balance(base, drive, settings, most),
        drivable=np.ascontiguousarray(drivable),
        residual=np.eye(len(rows)) - coupling.velocity @ inverse,
        inverse=np.ascontiguousarray(inverse),
        quiet=_quiet(slip, slipping),
        grip_per_ampere=np.append(force_per_ampere / (cosines * bearing * creep.grip), np.zeros(-len(rows) % WIDTH)),
        skid=_skid_params(base, creep, mass, loads),
        creep_across=creep.slope / GRAVITY,
        creep=np.append(creep.slope * creep.grip / cosines, np.zeros(-len(rows) % WIDTH)),
        body=Body(mass, base.alpha * mass * base.radius**2, *base.com.tolist()),
        pull_rows=np.ascontiguousarray(rows @ drivable * first),
        pull=np.ascontiguousarray(first[:, None] * drivable.T),
        momentum=np.ascontiguousarray(momentum),
        keep=KEEP.index(settings.keep),
        max_force=most,
        bearing=bearing / bearing.mean(),
        max_rim=max_rim_speed(drive, radii),
        path_force=RESERVE * most,
        rate_change=RATE_CHANGE,
        level=1.5 * abs(settings.sensors.accelerometer_bias) + LEVEL,
        level_noise=SURE * settings.sensors.accelerometer_noise,
        freedoms=_freedoms(base, rows, drivable),
        lever=base.radius,
        sideways=moves_sideways(base),
        detect=slip is not None,
        control_traction=settings.traction is not None and not skids(base.wheels),  # whose wheels slip to turn
        compensate=settings.watch is not None,
    )


def max_rim_speed(drive: BaseDrive, radii: Array) -> float:
    """Speed that the slowest rim reaches, m/s."""
    return drive.motor.no_load_speed / abs(drive.gear.ratio) * float(radii.min())


def _wheel_of_row(base: WheelBase) -> list[int]:
    """Which driven wheel each driven row belongs to: a ball has two."""
    driven = [wheel for wheel in base.wheels if wheel.driven]
    return [k for k, wheel in enumerate(driven) for _ in KINDS[wheel.kind].speeds(wheel)]


def _estimate_params(base: WheelBase, settings: BaseSettings) -> EstimateParams:
    """Wheels that skid do not tell how fast the base turns, so nothing of the gyro's zero."""
    params = settings.estimate.params(TICK)
    if base.balances:  # its accelerometers lean with it
        params = params._replace(max_pull=LEANING_PULL)
    return params._replace(bias_gain=0.0) if skids(base.wheels) else params


def _check_params(base: WheelBase, settings: BaseSettings, drivable: Array) -> CheckParams | None:
    """Of wheels that roll, under a body that stands; omni bases have their spare wheel, or nothing that tells."""
    omni = not base.steered and np.linalg.matrix_rank(drivable, tol=1e-9) == 3
    omni = omni or any(wheel.powered_castor for wheel in base.wheels)
    if settings.check is None or settings.slip is None or omni or base.balances or skids(base.wheels):
        return None
    return settings.check.params(TICK)


def _push_params(base: WheelBase, settings: BaseSettings) -> PushParams | None:
    """Of any base that stands; driven castors push by their pivots' motors, too, and balls turn as two drives do."""
    known = all(wheel.kind in PUSHING and not wheel.powered_castor for wheel in base.wheels if wheel.driven)
    if settings.check is None or settings.slip is None or base.balances or not known:
        return None
    params = settings.check.pushes(TICK)
    return params._replace(idle=SKIDDING_IDLE * params.idle) if skids(base.wheels) else params


def _freedoms(base: WheelBase, rows: Array, drivable: Array) -> int:
    """Motions that must be driven: of omni bases none in particular, of wheels that steer the one along them."""
    if base.steered:
        return 1
    rank = int(np.linalg.matrix_rank(rows @ drivable / [1.0, 1.0, base.radius], tol=1e-6))
    return 0 if rank == 3 else rank


def _balance(base: WheelBase, drive: BaseDrive, settings: BaseSettings, most: Array) -> BalanceParams | None:
    """What keeps a body up, with the largest forces (m,) of its rims."""
    if not base.balances or settings.balance is None:
        return None
    return balance_params(base, drive, settings.balance, float(most.sum()), TICK)


def _watch_params(base: WheelBase, settings: BaseSettings) -> WatchParams:
    """Wheels under a body that balances stand and turn as it needs: one that stands is not jammed."""
    params = (settings.watch or WatchSettings()).params(TICK)
    return params._replace(jam_patience=math.inf) if base.balances else params


def _skid_params(base: WheelBase, creep: Creep, mass: float, loads: Array) -> SkidParams:
    """Of a base that turns as its wheels skid; nothing where others roll, or wheels are not known to creep."""
    wheels = [wheel for wheel in base.wheels if wheel.driven] if creep.slope > 0.0 else []
    if not all(wheel.kind == "skid" for wheel in base.wheels):
        wheels = []
    grip = creep.grip * loads[: len(wheels)] / mass
    rows = np.array([(wheel.x, wheel.y, g) for wheel, g in zip(wheels, grip, strict=True)], dtype=float).reshape(-1, 3)
    return SkidParams(rows, SHARP * creep.slope * creep.grip, *base.com.tolist())


def _steered_params(base: WheelBase, drive: BaseDrive) -> SteeredParams:
    """Wheels of a base that steers; their lanes in the signals are those of `standing_wheels`."""
    standing = [wheel.name for wheel in standing_wheels(base)]
    slides = [k for k, wheel in enumerate(base.wheels) if wheel.name in base.sliding_names]
    castors = [k for k, wheel in enumerate(base.wheels) if wheel.powered_castor]
    radius = base.turning_radius
    return SteeredParams(
        places=np.array([(*wheel.acting, wheel.heading) for wheel in base.wheels]),
        limits=np.array([math.inf if wheel.max_steering is None else wheel.max_steering for wheel in base.wheels]),
        lanes=np.array([standing.index(w.name) if w.steers else -1 for w in base.wheels], dtype=np.int64),
        driven=np.array([k for k, wheel in enumerate(base.wheels) if wheel.driven], dtype=np.int64),
        sliding=np.array([*slides, *castors], dtype=np.int64),
        levers=np.array([wheel.castor_offset if wheel.powered_castor else 0.0 for wheel in base.wheels]),
        pull=_pivots_pull(base),
        curvature=1.0 / max(radius, 1e-9),
        reach=max(math.hypot(wheel.x, wheel.y) for wheel in base.wheels),
        turning=AxisShape(math.inf, drive.steering.max_rate, drive.steering.max_torque / drive.steering.inertia),
        dt=TICK,
        ahead=drive.steering.lag,
    )


def held_rows(base: WheelBase) -> Array:
    """(s, 3) rows, at rest, of directions in which wheels do not slide: sideways, and across driven castors."""
    rows = [sliding_row(w.x, w.y, *unit(w.axle)) + np.array([0.0, 0.0, w.castor_offset]) for w in base.wheels
            if w.powered_castor]  # fmt: skip
    return np.vstack([base.sliding_matrix(), np.array(rows, dtype=float).reshape(-1, 3)])


def _pivots_pull(base: WheelBase) -> Array:
    """(G^T G)^-1 (3, 3) of the pivots' velocities per twist, where every driven wheel is a castor and several are."""
    driven = [wheel for wheel in base.wheels if wheel.driven]
    G = np.array([row for w in driven for row in ((1.0, 0.0, -w.y), (0.0, 1.0, w.x))])
    if not all(wheel.powered_castor for wheel in driven) or np.linalg.matrix_rank(G) < 3:
        return np.zeros((3, 3))
    return np.ascontiguousarray(np.linalg.inv(G.T @ G))


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


def wheel_loop(base: WheelBase, drive: BaseDrive) -> WheelLoop:
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


def known_wheel(
    wheel: Wheel, row: Sequence[float], most: float, drive: BaseDrive, loop: WheelLoop
) -> tuple[object, ...]:
    """The motor as the plant's own step has it, half a millisecond: what is known of it does not depend on steps."""
    return (
        *row, wheel.radius, math.cos(wheel.roller_angle), most, drive.inertia, drive.motor.torque_constant,
        tuple(drive.motor.armature(TICK)), tuple(drive.friction.params(COULOMB_SMOOTHING)), tuple(drive.gear.params()),
        tuple(drive.encoder.params()), tuple(tracking_params(loop.observer_bandwidth, TICK)), tuple(loop.speed),
    )  # fmt: skip

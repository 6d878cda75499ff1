"""What the compiled step of a base's controller takes: its parameters, inputs and memory, as tuples of arrays."""

from __future__ import annotations

from typing import NamedTuple

from holonom.arrays import Array
from holonom.control.base.force_kernels import Body
from holonom.control.base.inertial_check import CheckParams, PushParams
from holonom.control.base.kernels import EstimateParams, KeepingParams, TractionParams, WatchParams
from holonom.control.base.shaping_kernels import ShapingParams
from holonom.control.base.skid_kernels import SkidParams
from holonom.control.path_laws.compiled import LawCall
from holonom.machine.base.balance_kernels import BalanceParams
from holonom.machine.base.steering_kernels import SteeredParams
from holonom.mobile.drive.slip_kernels import SlipParams

__all__ = ["BaseParams", "BaseTask", "Work"]


class BaseParams(NamedTuple):
    """The controller: params of its steps, what it knows of the base, and what is switched on."""

    keeping: KeepingParams
    shaping: ShapingParams
    law: LawCall  # of a path, where it cannot move along y at once
    estimate: EstimateParams
    traction: TractionParams
    watch: WatchParams
    skid: SkidParams
    slip: SlipParams
    check: CheckParams | None  # of wheels without a spare one; None: they are not checked by inertia
    pushes: PushParams | None  # None: what wheels push is not watched
    steered: SteeredParams | None  # None: no wheel steers
    balance: BalanceParams | None  # None: its body does not balance
    drivable: Array  # (3, 3) twist to the nearest one that drags no wheel, once those that steer have turned
    residual: Array  # (m, m) 1 - D D^+
    inverse: Array  # (3, m) D^+: (vx, vy, R w) per rim speed
    quiet: float  # square sum of the residual, (m/s)^2, up to which nothing slips; below 0: ask the detector always
    grip_per_ampere: Array  # (m,) part of its grip that a motor pushes with per ampere; zeros up to whole fours
    creep: Array  # (m,) m/s that a rim slips with all its grip, were it to grow linearly; zeros up to whole fours
    creep_across: float  # s, that wheels which do not slide creep against an acceleration
    body: Body
    pull_rows: Array  # (m, 3) rims per motion that wheels allow, weighted by what is kept where not all can be
    pull: Array  # (3, 3) force on base_link to the same weighted motions: what wheels take up sideways is left out
    momentum: Array  # (3, 3) momentum and angular momentum about base_link per twist
    keep: int  # BOTH, PATH or HEADING, where lost motors leave only one of them
    max_force: Array  # (m,) N that each wheel is asked for, along its rim
    bearing: Array  # (m,) weights of the wheels in the allocation of force: what each carries, over the mean
    max_rim: float  # m/s that a wheel reaches
    path_force: Array  # (m,) N that a path which is slowed down may need of each wheel
    rate_change: float  # 1/s, how fast the path may be slowed down
    level: float  # m/s2 of its accelerometers at rest, up to which the floor is taken for level; and of one sample
    level_noise: float
    freedoms: int  # motions that its motors must drive, or it stops; 0: it does what is left
    lever: float  # m, by which turning counts among them
    sideways: bool  # whether it can move along y at once
    detect: bool  # slip detection: leave the slipping wheel out of estimate and allocation
    control_traction: bool
    compensate: bool  # watch the motors, allocate without the dead


class BaseTask(NamedTuple):
    """What the level above gave: the rest of a path; a twist is in the state, with its age."""

    path: Array  # (N, 9) pose, twist, acceleration at 1 kHz; (0, 9) without one
    lean: Array  # (N, 3) of a body that balances: pitch, its rate, force that fit it; (0, 3) of others


class Work(NamedTuple):
    """Arrays of the controller: `rows`, `trust`, `weights`, `share`, `last`, `steering_rates`, `swung` are kept."""

    rows: Array  # (m, 3) rim speeds per (vx, vy, w), as the wheels are steered
    estimate_rows: Array  # (m + k, 3) the same, and k directions in which no wheel lets the base move
    trust: Array  # (m + k,) which wheels are believed, and the directions in which none moves
    weights: Array  # (m,) how much they are asked for force
    share: Array  # (m, 3) their rim forces per force on the base
    rims: Array  # rim speeds, m/s; zeros for the k directions
    gripping: Array  # (4 n,) the same of the wheels, less what a gripping wheel creeps
    last: Array  # (4 n,) that of the sample before
    acceleration: Array  # (3,)
    now: Array  # (9,) reference
    steering_rates: Array  # (n,) rad/s, of the angles that are asked for
    held: Array  # (n, 2) where each steered wheel stands though it should not, rad, and for how long, s
    pin: Array  # (3,) direction in which a stuck wheel does not slide
    swung: Array  # (n,) rad, where driven castors are believed to stand
    swinging: Array  # (k,) m/s across of the contacts of driven castors, as they swing; 0 of wheels that do not

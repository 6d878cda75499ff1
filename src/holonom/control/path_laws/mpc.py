"""Linear model predictive control of a base on its path: a quadratic program over the next second."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from holonom.arrays import Array
from holonom.control.base.kernels import Planar
from holonom.control.path_laws.contract import (
    CommandLimits,
    LawSettings,
    error_of,
    limited,
)
from holonom.errors import MissingExtra, OutOfLimits, RunError, ShapeError
from holonom.registry import Method, check_fields, parameter
from holonom.trace.code.loops import loop

__all__ = ["LEFT", "MPC", "LinearMpc", "MpcSettings", "QuadraticProgram", "planned_step"]

TICK = 1e-3  # s, of a path's samples
SPEED, RATE, LEFT = 2, 3, 4
"""Places in the memory (8,): what is planned for this period, m/s and rad/s, and ms until it must be planned anew."""
_FAR = 1e20  # what OSQP takes for infinite


@dataclass(frozen=True, slots=True, kw_only=True)
class MpcSettings(LawSettings):
    """Linear MPC; equations, stability and limits in `LinearMpc`.

    Raises
    ------
    OutOfLimits
        A number outside its range; a period that is no whole number of ms.
    """

    period: float = parameter(0.05, meaning="in which it plans anew", unit="s", least=TICK, most=1.0)
    horizon: int = parameter(20, meaning="periods that it looks ahead", least=2, most=200)
    error_along: float = parameter(0.1, meaning="error that weighs as much as `effort_speed`", unit="m", above=0.0)
    error_across: float = parameter(0.05, meaning="error that weighs as much as `effort_turn`", unit="m", above=0.0)
    error_heading: float = parameter(
        0.3, meaning="heading error that weighs as much as `effort_turn`", unit="rad", above=0.0
    )
    effort_speed: float = parameter(0.5, meaning="correction of the speed", unit="m/s", above=0.0)
    effort_turn: float = parameter(1.5, meaning="correction of the turning rate", unit="rad/s", above=0.0)
    end_weight: float = parameter(10.0, meaning="of the last error against the others", least=1.0)

    def __post_init__(self) -> None:
        check_fields(self)
        if abs(self.period / TICK - round(self.period / TICK)) > 1e-6:
            raise OutOfLimits(f"MpcSettings: period is {self.period} s; it must be a whole number of ms")

    def params(self, dt: float) -> CommandLimits:
        """Limits of a command that lasts for a time, s; params of `planned_step`."""
        return self.limits(dt)


@loop(error_model="numpy")
def planned_step(
    params: CommandLimits, path: Array, phase: float, now: Array, pose: Planar, twist: Planar, before: Planar,
    memory: Array,
) -> Planar:  # fmt: skip
    """What was planned last, from `memory`, within limits; arguments as `PathLaw` says. It counts the ms down."""
    memory[LEFT] -= 1.0
    return limited(params, before, memory[SPEED], memory[RATE])


class QuadraticProgram(NamedTuple):
    """Least `x.P x/2 + q.x` with `low <= A x <= high`; x: errors e_1 to e_H (3 each), commands u_0 to u_(H-1) (2)."""

    P: Array
    q: Array
    A: Array
    low: Array
    high: Array


class LinearMpc:
    """Plans commands over a horizon; needs the extra `mpc` (OSQP).

    Parameters
    ----------
    settings : weights, horizon, limits.

    Notes
    -----
    Klancar & Skrjanc, *Tracking-error model-based predictive control for mobile robots in real time*, Robotics and
    Autonomous Systems 55, 2007; solved by Stellato et al., *OSQP*, 2020. The errors in the reference's axes, linearised
    about it, `e_x' = w_r e_y + v - v_r`, `e_y' = -w_r e_x + v_r e_theta`, `e_theta' = w - w_r`, one Euler step a
    period; least sum of squared errors and corrections over the horizon, under the limits of speed, turning rate,
    acceleration, turn acceleration and curvature (`|w| <= kappa |v|` on the side to which the reference drives; a base
    that is still rolling the other way keeps that side until it can have stopped). The last command held, or braked to
    rest, is always allowed: there is always a plan.

    Stability: by a long horizon and the weight of its end, not by a terminal set: the horizon must be longer than the
    base takes to stop and than the errors take to die out; small errors (below about half a radian). Curvature of the
    reference must leave some of the turning limit over to correct with.
    """

    step = staticmethod(planned_step)
    """Its compiled step as a `PathLaw`, between two plans."""

    def __init__(self, settings: MpcSettings) -> None:
        self.settings = settings
        self._solver: Any = None

    def __deepcopy__(self, memo: object) -> LinearMpc:
        """A planner of the same settings, whose solver begins anew."""
        return LinearMpc(self.settings)

    def plan(self, path: Array, phase: float, pose: Planar, before: Planar) -> Array:
        """Commands (H, 3), m/s, 0, rad/s, each for a period.

        Parameters
        ----------
        path, phase, pose, before
            As `PathLaw` says; `before` must be within the limits.

        Raises
        ------
        MissingExtra, ShapeError, OutOfLimits
        RunError
            The solver gave up.
        """
        osqp = _osqp()
        import scipy.sparse as sp  # heavy: on first use

        program = self.program(path, phase, pose, before)
        H = self.settings.horizon
        if self._solver is None:
            self._pattern = np.nonzero(_pattern(H).T)  # by columns, as OSQP keeps them
            columns, rows = self._pattern
            A = sp.csc_matrix((program.A[rows, columns], (rows, columns)), shape=program.A.shape)
            self._solver = osqp.OSQP()
            self._solver.setup(
                sp.csc_matrix(program.P), program.q, A, program.low, program.high,
                verbose=False, eps_abs=1e-6, eps_rel=1e-6, max_iter=20000, polishing=True,
            )  # fmt: skip
        else:
            columns, rows = self._pattern
            self._solver.update(q=program.q, l=program.low, u=program.high, Ax=program.A[rows, columns])
        found = self._solver.solve(raise_error=False)
        if found.info.status not in ("solved", "solved inaccurate"):
            raise RunError(f"mpc: no plan, OSQP says {found.info.status!r}; state a longer period or wider limits")
        limits = self.settings.params(self.settings.period)
        commands = np.zeros((H, 3))
        for k, (v, w) in enumerate(found.x[3 * H :].reshape(H, 2)):
            before = limited(limits, before, v, w)  # what a solver's tolerance is over
            commands[k] = before
        return commands

    def check_library(self) -> None:
        """Raise `MissingExtra` where OSQP is not installed."""
        _osqp()

    def plan_into(self, memory: Array, path: Array, phase: float, pose: Planar, before: Planar) -> None:
        """Plan the next period into the memory (8,) of `planned_step`; raises as `plan` does.

        A last command beyond the limits is taken as the nearest within.
        """
        s = self.settings
        v = min(max(before.x, -s.max_speed), s.max_speed)
        most = s.max_turn_rate if math.isinf(s.max_curvature) else min(s.max_turn_rate, abs(v) * s.max_curvature)
        w = min(max(before.turn, -most), most)
        memory[SPEED], _, memory[RATE] = self.plan(path, phase, pose, Planar(v, 0.0, w))[0]
        memory[LEFT] = round(s.period / TICK)

    def program(self, path: Array, phase: float, pose: Planar, before: Planar) -> QuadraticProgram:
        """The quadratic program of `plan`, dense, for whoever solves it otherwise."""
        s, H = self.settings, self.settings.horizon
        if path.ndim != 2 or path.shape[1] != 9 or not np.isfinite([phase, *pose, *before]).all():
            raise ShapeError(
                f"mpc: path has shape {path.shape}, phase, pose and command are {phase}, {pose}, {before}; it must be "
                "(N, 9), and they finite"
            )
        _check_command(s.params(s.period), before)
        speed, turn = self._reference(path, phase)
        at = path[min(max(round(phase), 0), len(path) - 1)]
        e = error_of(at, pose)
        c, d = math.cos(e.turn), math.sin(e.turn)
        first = np.array([-c * e.along - d * e.across, d * e.along - c * e.across, -e.turn])  # in the reference's axes
        A, rows = _pattern(H), 3 * H
        low, high = np.zeros(len(A)), np.zeros(len(A))
        for k in range(H):
            step = np.eye(3) + s.period * np.array([[0, turn[k], 0], [-turn[k], 0, speed[k]], [0, 0, 0]])
            here = slice(3 * k, 3 * k + 3)
            drift = s.period * np.array([speed[k], 0.0, turn[k]])
            if k:
                A[here, 3 * k - 3 : 3 * k] = -step
                low[here] = high[here] = -drift
            else:
                low[here] = high[here] = step @ first - drift
            A[3 * k, rows + 2 * k] = A[3 * k + 2, rows + 2 * k + 1] = -s.period
        bound = np.array([s.max_speed, s.max_turn_rate])
        change = s.period * np.array([s.max_acceleration, s.max_turn_acceleration])
        last = np.array([before.x, before.turn])
        for k in range(H):
            at_ = 3 * H + 4 * k
            low[at_ : at_ + 2], high[at_ : at_ + 2] = -bound, bound
            low[at_ + 2 : at_ + 4], high[at_ + 2 : at_ + 4] = -change, change
        low[3 * H + 2 : 3 * H + 4] += last
        high[3 * H + 2 : 3 * H + 4] += last
        for k, side in enumerate(self._sides(speed, before)):
            curve = 7 * H + 2 * k
            if math.isfinite(s.max_curvature):
                A[curve : curve + 2, rows + 2 * k] = side * s.max_curvature
                high[curve : curve + 2] = _FAR
            else:
                low[curve : curve + 2], high[curve : curve + 2] = -_FAR, _FAR
        effort = np.array([s.effort_speed, s.effort_turn]) ** -2.0
        error = np.array([s.error_along, s.error_across, s.error_heading]) ** -2.0
        weights = np.concatenate([np.tile(error, H), np.tile(effort, H)])
        weights[3 * H - 3 : 3 * H] *= s.end_weight
        q = np.zeros(5 * H)
        q[3 * H :] = -np.tile(effort, H) * np.column_stack([speed, turn]).ravel()
        return QuadraticProgram(np.diag(weights), q, A, np.maximum(low, -_FAR), np.minimum(high, _FAR))

    def _reference(self, path: Array, phase: float) -> tuple[Array, Array]:
        """Mean speed and turning rate (H,) of the reference in each period."""
        ratio = round(self.settings.period / TICK)
        at = np.clip(round(phase) + np.arange(self.settings.horizon * ratio), 0, len(path) - 1)
        rows = path[at][:, [3, 5]].reshape(-1, ratio, 2).mean(axis=1)
        return rows[:, 0], rows[:, 1]

    def _sides(self, speed: Array, before: Planar) -> Array:
        """To which side (-1, 1) the base drives in each period: as the reference, once it can have stopped."""
        s = self.settings
        way = np.sign(np.where(np.abs(speed) > 1e-6, speed, 0.0))
        for k in range(1, len(way)):
            way[k] = way[k] or way[k - 1]
        for k in range(len(way) - 2, -1, -1):
            way[k] = way[k] or way[k + 1]
        way[way == 0.0] = 1.0
        if before.x:
            slowest = max(
                abs(before.x) / (s.period * s.max_acceleration),
                abs(before.turn) / (s.period * s.max_turn_acceleration),
            )
            way[: math.ceil(slowest - 1e-9)] = math.copysign(1.0, before.x)
        return way


def _pattern(H: int) -> Array:
    """Rows of the constraints with ones where numbers go: motion (3 H), bounds and changes (4 H), curvature (2 H)."""
    A = np.zeros((9 * H, 5 * H))
    A[: 3 * H, : 3 * H] = np.eye(3 * H)
    for k in range(H):
        u = 3 * H + 2 * k
        if k:
            A[3 * k : 3 * k + 3, 3 * k - 3 : 3 * k] = 1.0
        A[3 * k, u] = A[3 * k + 2, u + 1] = 1.0
        A[3 * H + 4 * k : 3 * H + 4 * k + 2, u : u + 2] = np.eye(2)
        A[3 * H + 4 * k + 2 : 3 * H + 4 * k + 4, u : u + 2] = np.eye(2)
        if k:
            A[3 * H + 4 * k + 2 : 3 * H + 4 * k + 4, u - 2 : u] = -np.eye(2)
        A[7 * H + 2 * k : 7 * H + 2 * k + 2, u : u + 2] = [[1.0, -1.0], [1.0, 1.0]]
    return A


def _check_command(limits: CommandLimits, before: Planar) -> None:
    size = max(abs(before.x) / limits.speed, abs(before.turn) / limits.turn_rate)
    if size > 1.0 + 1e-9 or abs(before.turn) * limits.radius > abs(before.x) * (1.0 + 1e-9) + 1e-9:
        raise OutOfLimits(
            f"mpc: the last command is {before.x} m/s, {before.turn} rad/s; it must be within {limits.speed} m/s, "
            f"{limits.turn_rate} rad/s, a turning radius of {limits.radius} m"
        )


def _osqp() -> Any:
    """The library.

    Raises
    ------
    MissingExtra
    """
    try:
        import osqp
    except ImportError:
        raise MissingExtra("mpc", "OSQP", "mpc") from None
    return osqp


MPC = Method(
    "a quadratic program over the next second, limits as constraints; plans at its own period (extra `mpc`)",
    LinearMpc,
    "Klancar & Skrjanc, Robotics and Autonomous Systems 55, 2007; OSQP: Stellato et al., 2020",
    MpcSettings,
)

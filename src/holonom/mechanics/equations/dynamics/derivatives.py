"""Derivatives of inverse and forward dynamics by one recursion (Singh, Russell & Wensing, RA-L 7(2), 2022).

Seen from what joint j carries, turning it by dq moves the carrier back: the velocity of every carried body changes by
S'_j = v x S_j and its acceleration by S''_j = a x S_j + v x S'_j, v and a being the carrier's. The force on a body
answers linearly, with I S'' + 2 B S'; the torque of a joint sums that over all that both joints carry.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

from holonom.mechanics.equations.dynamics.carried import (
    Carried,
    Chain,
    Twist,
    accelerations,
    carried,
    chain,
    coriolis,
    coriolis_transposed,
    inert,
    moving,
    of_bodies,
    plus,
    power,
    times,
    wrench_of_motion,
)
from holonom.mechanics.equations.dynamics.composite_body import independent, joint_inertia, with_rotors
from holonom.mechanics.equations.dynamics.coriolis import joint_coriolis
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.newton_euler import friction_slope, friction_torque
from holonom.mechanics.equations.kinematics import gather, spread
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matmul, scale
from holonom.model import ArmModel
from holonom.numeric.small import factor_ldl, solve_factored
from holonom.trace import Number

__all__ = [
    "Derivatives",
    "forward_dynamics_column",
    "forward_dynamics_columns",
    "forward_dynamics_derivatives",
    "inverse_dynamics_derivatives",
]

Rows = list[list[Number]]


class Derivatives(NamedTuple):
    """Rows (n, n) of the derivatives with respect to q, to qd, and to qdd (inverse) or tau (forward)."""

    q: Rows
    qd: Rows
    last: Rows


class _Body(NamedTuple):
    """Sums over all that a joint carries, and the wrench that moves it."""

    sums: Carried
    wrench: Twist


def inverse_dynamics_derivatives(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, qdd: Vector, *, friction: bool = False
) -> Derivatives:
    """d tau / d(q, qd, qdd); the last is the mass matrix."""
    c = chain(model, q, qd)
    each = of_bodies(c, bodies)
    a = accelerations(c, spread(model, qd, rates=True), spread(model, qdd, rates=True))
    return _derivatives(c, carried(model, each), _wrenches(c, each, a), a, qd, friction)


def forward_dynamics_derivatives(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, tau: Vector, *, friction: bool = False
) -> Derivatives:
    """d qdd / d(q, qd, tau) = (-B^-1 dtau/dq, -B^-1 dtau/dqd, B^-1) at the motion that the torques cause."""
    found, factor = _at_the_motion(model, bodies, q, qd, tau, friction)
    inverse = _inverse(factor)
    minus = [scale(-1.0, row) for row in inverse]
    return Derivatives(matmul(minus, found.q), matmul(minus, found.qd), inverse)


def forward_dynamics_columns(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, tau: Vector, *, friction: bool = False
) -> tuple[list[Number], list[Number]]:
    """The same in columns, which `forward_dynamics_column` makes: what they share, and what they start from.

    That is the factor of B, and dtau/dq, dtau/dqd and 1, one below the other.
    """
    found, factor = _at_the_motion(model, bodies, q, qd, tau, friction)
    unit: Rows = [[float(i == k) for k in range(len(q))] for i in range(len(q))]
    return [entry for row in factor for entry in row], [entry for row in (*found.q, *found.qd, *unit) for entry in row]


def forward_dynamics_column(shared: Vector, own: Vector) -> list[list[Number]]:
    """A column of each of the derivatives."""
    n = len(own) // 3
    ends = [k * (k + 1) // 2 for k in range(n + 1)]
    factor = [shared[begin:end] for begin, end in itertools.pairwise(ends)]
    by_q, by_qd, by_tau = (solve_factored(factor, own[n * k : n * k + n]) for k in range(3))
    return [scale(-1.0, by_q), scale(-1.0, by_qd), by_tau]


def _at_the_motion(
    model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, tau: Vector, friction: bool
) -> tuple[Derivatives, Rows]:
    """The inverse dynamics' derivatives at the motion that torques cause, and the factor of B."""
    c = chain(model, q, qd)
    each = of_bodies(c, bodies)
    sums = carried(model, each)
    rates = spread(model, qd, rates=True)
    rest = _wrenches(c, each, accelerations(c, rates, [0.0] * len(rates)))
    losses = [friction_torque(j.friction, u) if friction else 0.0 for j, u in zip(model.joints, rates, strict=True)]
    bias = gather(model, [power(S, f) + loss for S, f, loss in zip(c.axis, rest, losses, strict=True)])
    factor = factor_ldl(independent(model, with_rotors(model, joint_inertia(c, sums))))
    qdd = solve_factored(factor, [t - b for t, b in zip(tau, bias, strict=True)])
    a = accelerations(c, rates, spread(model, qdd, rates=True))
    return _derivatives(c, sums, _wrenches(c, each, a), a, qd, friction), factor


def _wrenches(c: Chain, each: Sequence[Carried], a: Sequence[Twist]) -> list[Twist]:
    """Wrench that moves all that each joint carries."""
    found = [wrench_of_motion(body, v, a_i) for body, v, a_i in zip(each, c.velocity, a[1:], strict=True)]
    for i in reversed(range(len(found))):
        if (parent := c.model.parent(i)) >= 0:
            found[parent] = plus(found[parent], found[i])
    return found


def _by_position(c: Chain, sums: Sequence[Carried], wrenches: Sequence[Twist], a: Sequence[Twist]) -> Rows:
    """Dtau/dq over all joints."""
    n = len(c.axis)
    swing = [  # S''
        plus(moving(a[c.model.parent(i) + 1], c.axis[i]), moving(c.carrier[i], c.axis_rate[i])) for i in range(n)
    ]
    D: Rows = [[0.0] * n for _ in range(n)]
    for i in range(n):
        S, f, all_ = c.axis[i], wrenches[i], sums[i]
        row, turned = inert(all_.inertia, S), scale(2.0, coriolis_transposed(all_, S))
        turn = Twist(add(cross(S.w, f.w), cross(S.v, f.v)), cross(S.w, f.v))  # S x* f: the wrench turns with the joint
        column = plus(plus(inert(all_.inertia, swing[i]), times(2.0, coriolis(all_, c.axis_rate[i]))), turn)
        j = i
        while j >= 0:
            D[i][j] = power(swing[j], row) + dot(c.axis_rate[j].w, turned)
            if j != i:
                D[j][i] = power(c.axis[j], column)
            j = c.model.parent(j)
    return D


def _derivatives(
    c: Chain, sums: Sequence[Carried], wrenches: Sequence[Twist], a: Sequence[Twist], qd: Vector, friction: bool
) -> Derivatives:
    """Together: the bias is quadratic in qd, so dtau/dqd is 2 C, and friction's slope."""
    model = c.model
    by_speed = [scale(2.0, row) for row in joint_coriolis(c, sums)]
    if friction:
        for i, (joint, rate) in enumerate(zip(model.joints, spread(model, qd, rates=True), strict=True)):
            by_speed[i][i] = by_speed[i][i] + friction_slope(joint.friction, rate)
    parts = (_by_position(c, sums, wrenches, a), by_speed, with_rotors(c.model, joint_inertia(c, sums)))
    return Derivatives(*(independent(model, part) for part in parts))


def _inverse(factor: Rows) -> Rows:
    """Inverse of a symmetric positive definite matrix, given its factor; its upper triangle is computed."""
    n = len(factor)
    columns = [solve_factored(factor, [float(i == k) for i in range(n)]) for k in range(n)]
    return [[columns[max(i, k)][min(i, k)] for k in range(n)] for i in range(n)]

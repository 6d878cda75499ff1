"""Coriolis matrix by Christoffel symbols, without differentiating B (Echeandia & Wensing 2021).

c_ij = 1/2 sum_k (db_ij/dq_k + db_ik/dq_j - db_jk/dq_i) qd_k (specification 2.1), so that Bdot - 2 C is skew-symmetric.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.carried import (
    STILL,
    Carried,
    Chain,
    Twist,
    carried,
    chain,
    coriolis,
    coriolis_transposed,
    in_motion,
    inert,
    of_bodies,
    of_body,
    plus,
    power,
)
from holonom.mechanics.equations.dynamics.composite_body import independent
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.kinematics import spread
from holonom.mechanics.equations.vectors import Vector, dot
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["christoffel", "christoffel_column", "christoffel_columns", "coriolis_matrix", "joint_coriolis"]


def coriolis_matrix(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector) -> list[list[Number]]:
    """C(q, qd), (n, n); C qd are the centrifugal and Coriolis torques."""
    c = chain(model, q, qd)
    return independent(model, joint_coriolis(c, carried(model, of_bodies(c, bodies))))


def joint_coriolis(c: Chain, sums: Sequence[Carried]) -> list[list[Number]]:
    """C over all joints, mimics apart: S_i . (I S'_j + B S_j) where joint j carries joint i, S' the axis' rate."""
    n = len(c.axis)
    C: list[list[Number]] = [[0.0] * n for _ in range(n)]
    for i in range(n):
        all_ = sums[i]
        row, turned = inert(all_.inertia, c.axis[i]), coriolis_transposed(all_, c.axis[i])
        column = plus(inert(all_.inertia, c.axis_rate[i]), coriolis(all_, c.axis[i]))
        j = i
        while j >= 0:
            C[i][j] = power(c.axis_rate[j], row) + dot(c.axis[j].w, turned)
            if j != i:
                C[j][i] = power(c.axis[j], column)
            j = c.model.parent(j)
    return C


def christoffel(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[list[list[Number]]]:
    """c_ijk, symmetric in j and k: C is linear in qd, so C(q, e_k) is the layer k."""
    n = len(model.independent)
    layers = [coriolis_matrix(model, bodies, q, [float(j == k) for j in range(n)]) for k in range(n)]
    return [[[layers[max(j, k)][i][min(j, k)] for k in range(n)] for j in range(n)] for i in range(n)]


def christoffel_columns(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> tuple[list[Number], list[Number]]:
    """The same in layers k, which `christoffel_column` makes: what they share, and the speeds that each starts from.

    That is where the joints and the bodies are, and the unit matrix.
    """
    n = len(model.independent)
    c = chain(model, q, [0.0] * n)
    shared: list[Number] = [x for S in c.axis for x in (*S.w, *S.v)]
    for body in of_bodies(c, bodies):
        m, h, S = body.inertia
        shared += [m, *h, *S[0], *S[1][1:], S[2][2]]
    return shared, [float(j == k) for j in range(n) for k in range(n)]


def christoffel_column(model: ArmModel, shared: Vector, own: Vector) -> list[list[Number]]:
    """C(q, e_k), given what the layers share and e_k."""
    n = len(model.joints)
    axes = [Twist(shared[k : k + 3], shared[k + 3 : k + 6]) for k in range(0, 6 * n, 6)]
    c = in_motion(model, [], axes, STILL.v, spread(model, own, rates=True))
    each = []
    for k, v in enumerate(c.velocity):
        m, hx, hy, hz, xx, xy, xz, yy, yz, zz = shared[6 * n + 10 * k : 6 * n + 10 * k + 10]
        each.append(of_body(Inertial(m, [hx, hy, hz], [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), v))
    return independent(model, joint_coriolis(c, carried(model, each)))

"""B(q)^-1 r in a number of operations that grows with the joints, not with their cube (Featherstone 2008, ch. 7).

What a joint carries resists it with its articulated-body inertia: the bodies', less what their free joints let go.
"""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.carried import Chain, Twist, chain, of_bodies, plus, power, times
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.rotors import reflected_inertia
from holonom.mechanics.equations.vectors import Vector, dot
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["solve_inertia"]


def solve_inertia(model: ArmModel, bodies: Sequence[Inertial], q: Vector, torque: Vector) -> list[Number]:
    """Accelerations x with B x = torque, reflected rotor inertias included; without mimics or rotor coupling."""
    c = chain(model, q, [0.0] * len(model.joints))
    held, rotor = [_spatial(b.inertia) for b in of_bodies(c, bodies)], reflected_inertia(model)
    n = len(model.joints)
    pull = [Twist([0.0] * 3, [0.0] * 3) for _ in range(n)]
    U: list[Twist] = list(pull)
    left: list[Number] = [0.0] * n
    share: list[Number] = [0.0] * n
    for i in reversed(range(n)):
        S = c.axis[i]
        U[i] = _times(held[i], S)
        share[i] = 1.0 / (power(S, U[i]) + rotor[i])
        left[i] = torque[i] - power(S, pull[i])
        if (parent := model.parent(i)) >= 0:
            _release(held[parent], held[i], U[i], share[i])
            pull[parent] = plus(pull[parent], plus(pull[i], times(left[i] * share[i], U[i])))
    return _outward(c, U, left, share)


def _outward(c: Chain, U: Sequence[Twist], left: Vector, share: Vector) -> list[Number]:
    x: list[Number] = []
    a: list[Twist] = []
    for i, S in enumerate(c.axis):
        parent = c.model.parent(i)
        carrier = a[parent] if parent >= 0 else None
        x.append(share[i] * (left[i] if carrier is None else left[i] - power(carrier, U[i])))
        own = times(x[i], S)
        a.append(own if carrier is None else plus(carrier, own))
    return x


def _spatial(body: Inertial) -> list[list[Number]]:
    """The 6x6 inertia [I [h]x; [h]x^T m 1] that takes (w, v) to (moment, force)."""
    m, h, rotational = body.m, body.h, body.rotational()
    H: list[list[Number]] = [[0.0, -h[2], h[1]], [h[2], 0.0, -h[0]], [-h[1], h[0], 0.0]]
    top = [[*rotational[i], *H[i]] for i in range(3)]
    return top + [[H[0][i], H[1][i], H[2][i], *(m if j == i else 0.0 for j in range(3))] for i in range(3)]


def _times(inertia: Sequence[Vector], S: Twist) -> Twist:
    product = [dot(row, [*S.w, *S.v]) for row in inertia]
    return Twist(product[:3], product[3:])


def _release(parent: list[list[Number]], child: Sequence[Vector], U: Twist, share: Number) -> None:
    """Add to the parent what the child's free joint does not let go: I - U U^T / D."""
    u = [*U.w, *U.v]
    scaled = [share * value for value in u]
    for i in range(6):
        for j in range(i + 1):
            parent[i][j] = parent[j][i] = parent[i][j] + (child[i][j] - scaled[i] * u[j])

"""Energies and momenta of an arm (specification 2.1; Orin, Goswami & Lee 2013 for the centroidal ones)."""

from __future__ import annotations

from collections.abc import Sequence

from holonom.mechanics.equations.dynamics.carried import Chain, Twist, chain, inert, of_bodies, plus, power
from holonom.mechanics.equations.dynamics.composite_body import mass_matrix
from holonom.mechanics.equations.dynamics.inertia import Inertial
from holonom.mechanics.equations.dynamics.rotors import reflected_inertia, spin_axis
from holonom.mechanics.equations.kinematics import frames, split, spread
from holonom.mechanics.equations.vectors import Vector, add, cross, dot, matmul, matvec, scale, sub, transpose
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = ["centre_of_mass", "centroidal_momentum", "kinetic_energy", "momentum", "potential_energy"]


def kinetic_energy(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector) -> Number:
    """Sum over bodies and rotors of 1/2 m v^2 + 1/2 w I w, J."""
    c = chain(model, q, qd)
    links = [power(v, inert(b.inertia, v)) for b, v in zip(of_bodies(c, bodies), c.velocity, strict=True)]
    return 0.5 * (_total(links) + _rotor_energy(c, spread(model, qd, rates=True)))


def _rotor_energy(c: Chain, rates: Vector) -> Number:
    """Twice the energy of the rotors beyond that of the locked ones."""
    energy = _total([k * u * u for k, u in zip(reflected_inertia(c.model), rates, strict=True)])
    for i, rate in enumerate(rates):
        if (spin := spin_axis(c.model, i)) is not None:
            R, _ = c.frames[c.model.parent(i)]
            energy = energy + 2.0 * rate * dot(matvec(R, spin), c.carrier[i].w)
    return energy


def potential_energy(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> Number:
    """Minus the sum of m g0 . p, J; zero where every body lies in the world's origin."""
    return -dot(model.gravity, _first_moment(model, bodies, q))


def centre_of_mass(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[Number]:
    """Common centre of mass in the world, (3,) m."""
    return scale(1.0 / _total([b.m for b in bodies]), _first_moment(model, bodies, q))


def _first_moment(model: ArmModel, bodies: Sequence[Inertial], q: Vector) -> list[Number]:
    """Sum of m p in the world."""
    total: list[Number] = [0.0, 0.0, 0.0]
    for body, (R, p) in zip(bodies, frames(model, q)[1:-1], strict=True):
        total = add(total, add(scale(body.m, p), matvec(R, body.h)))
    return total


def momentum(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector) -> list[Number]:
    """Generalised momentum B qd, (n,)."""
    return matvec(mass_matrix(model, bodies, q), qd)


def centroidal_momentum(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector) -> list[Number]:
    """Linear momentum and angular momentum about the common centre of mass, in the world, (6,); rotors locked."""
    c = chain(model, q, qd)
    each = of_bodies(c, bodies)
    L, P = Twist([0.0] * 3, [0.0] * 3)
    for body, v in zip(each, c.velocity, strict=True):
        L, P = plus(Twist(L, P), inert(body.inertia, v))
    first = [_total([b.inertia.h[k] for b in each]) for k in range(3)]
    about_centre = sub(L, scale(1.0 / _total([b.m for b in bodies]), cross(first, P)))
    R_w1, _ = frames(model, q)[1]
    R_wh = matmul(R_w1, transpose(split(model.joints[0].after)[0]))
    return [*matvec(R_wh, P), *matvec(R_wh, about_centre)]


def _total(values: Sequence[Number]) -> Number:
    total: Number = 0.0
    for value in values:
        total = total + value
    return total

"""The arm as the drives feel it: forward dynamics with a payload at the tool and a table under it (traced).

Free of joint friction: friction sits at the motors (`holonom.devices`).
"""

from __future__ import annotations

from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.inertia import merged, point_mass
from holonom.mechanics.equations.vectors import Vector, add, dot, matvec, tvec
from holonom.mechanics.kernels.movable import check_movable
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import ArmModel
from holonom.trace import Kernel, Number, compile, less, maximum, select

__all__ = ["plant_kernel"]


def plant_kernel(model: ArmModel) -> Kernel:
    """Inputs q, qd, tau (n), payload (mass, centre of mass in the tool frame), ground (height, stiffness, damping).

    Outputs qdd (n), contact (1): the normal force of the ground on the tool point, N.

    Raises
    ------
    MissingInertia
        A joint that moves no mass, rotors counted.
    """
    check_movable(model)
    n = len(model.joints)
    bodies = bodies_of(model)
    R_tool, p_tool = kinematics.split(model.tool)

    def equation(q: Vector, qd: Vector, tau: Vector, payload: Vector, ground: Vector) -> tuple[Vector, Vector]:
        c = add(matvec(R_tool, payload[1:4]), p_tool)
        loaded = [*bodies[:-1], merged(bodies[-1], point_mass(payload[0], c))]
        contact = _ground_force(model, q, qd, ground)
        R_wt, _ = kinematics.frames(model, q)[-1]
        # The ground pushes the tool up: the arm exerts the opposite on its environment.
        wrench = [*tvec(R_wt, [0.0, 0.0, -contact]), 0.0, 0.0, 0.0]
        qdd = forward_dynamics.forward_dynamics(model, loaded, q, qd, tau, wrench_tool=wrench)
        return qdd, [contact]

    return compile(
        equation,
        {"q": n, "qd": n, "tau": n, "payload": 4, "ground": 3},
        {"qdd": n, "contact": 1},
        name=f"{model.name}_plant",
    )


def _ground_force(model: ArmModel, q: Vector, qd: Vector, ground: Vector) -> Number:
    """Spring and damper below the ground's height, never pulling."""
    height, stiffness, damping = ground
    depth = height - kinematics.frames(model, q)[-1][1][2]
    n = len(qd)
    rise = dot(kinematics.jacobian(model, q, "world")[2 * n : 3 * n], qd)
    force = maximum(stiffness * depth - damping * rise, 0.0)
    return select(less(0.0, depth), force, 0.0)

"""An arm under a control law, as one equation: what a simulation integrates.

The plant may differ from the model that the law knows: a payload, other masses, other friction. These are inputs
(`parameters`), so that one compiled equation serves every variation of the arm.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from holonom.mechanics.equations import kinematics
from holonom.mechanics.equations.dynamics.forward_dynamics import forward_dynamics
from holonom.mechanics.equations.dynamics.inertia import Inertial, merged, point_mass
from holonom.mechanics.equations.dynamics.newton_euler import coulomb_torque, inverse_dynamics
from holonom.mechanics.equations.vectors import Vector, add, matvec, scale, sub, tvec
from holonom.model import ArmModel
from holonom.trace import Number

__all__ = [
    "LAWS",
    "LawEquation",
    "breakaway",
    "closed_loop",
    "parameter_fields",
    "parts_of",
    "varied_bodies",
    "width_of",
]


def _torque(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, reference: Vector, gains: Vector,
            friction: bool) -> list[Number]:  # fmt: skip
    """The reference is the torque."""
    return list(reference)


def _pd_gravity(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, reference: Vector, gains: Vector,
                friction: bool) -> list[Number]:  # fmt: skip
    """tau = kp (q_r - q) + kd (qd_r - qd) + g(q) (Siciliano 8.5.1)."""
    still = [0.0] * len(q)
    return add(_correction(q, qd, reference, gains), inverse_dynamics(model, bodies, q, still, still))


def _computed_torque(model: ArmModel, bodies: Sequence[Inertial], q: Vector, qd: Vector, reference: Vector,
                     gains: Vector, friction: bool) -> list[Number]:  # fmt: skip
    """tau = B(q) u + C(q, qd) qd + g(q), u = qdd_r + kd (qd_r - qd) + kp (q_r - q) (Siciliano 8.5.2).

    Friction is fed forward along the reference, so that it does not chatter at rest.
    """
    n = len(q)
    u = add(reference[2 * n :], _correction(q, qd, reference, gains))
    tau, speed = inverse_dynamics(model, bodies, q, qd, u), reference[n : 2 * n]
    return add(tau, _friction(model, speed, speed, [1.0] * len(model.joints))) if friction else tau


def _correction(q: Vector, qd: Vector, reference: Vector, gains: Vector) -> list[Number]:
    n = len(q)
    position, speed = sub(reference[:n], q), sub(reference[n : 2 * n], qd)
    return [gains[i] * position[i] + gains[n + i] * speed[i] for i in range(n)]


@dataclass(frozen=True, slots=True)
class LawEquation:
    """Torques of a law, how many numbers per joint its reference has, and how many gains."""

    torque: Callable[..., list[Number]]
    reference: int
    gains: int


LAWS: Mapping[str, LawEquation] = {
    "torque": LawEquation(_torque, 1, 0),
    "pd_gravity": LawEquation(_pd_gravity, 3, 2),
    "computed_torque": LawEquation(_computed_torque, 3, 2),
}


def parameter_fields(model: ArmModel, options: Mapping[str, Any]) -> dict[str, int]:
    """Names and widths of the parameters, in their order: gains of the law, then what varies."""
    n, joints = len(model.independent), len(model.joints)
    widths = {"payload": 4, "masses": joints, "friction": joints}
    fields = {"gains": LAWS[options["law"]].gains * n} | {name: widths[name] for name in options["varied"]}
    return fields | ({"wrench": 6} if options["wrench_frame"] else {})


def varied_bodies(model: ArmModel, bodies: Sequence[Inertial], part: Mapping[str, Vector]) -> list[Inertial]:
    """Bodies with their masses scaled (`masses`, a factor each) and a point mass at the tool (`payload`: m, c)."""
    found = list(bodies)
    if "masses" in part:
        found = [Inertial(k * b.m, scale(k, b.h), [scale(k, row) for row in b.S])
                 for k, b in zip(part["masses"], found, strict=True)]  # fmt: skip
    if "payload" in part:
        R, p = kinematics.split(model.tool)
        load = point_mass(part["payload"][0], add(matvec(R, part["payload"][1:]), p))
        found[model.tool_joint] = merged(found[model.tool_joint], load)
    return found


def closed_loop(
    model: ArmModel,
    bodies: Sequence[Inertial],
    options: Mapping[str, Any],
    state: tuple[Vector, Vector],
    reference: Vector,
    part: Mapping[str, Vector],
    slip: Vector,
) -> tuple[list[Number], list[Number]]:
    """Joint accelerations, and the law's torques; `part` maps each of `parameter_fields` to its numbers.

    Coulomb friction acts against `slip`, whatever the speeds: an integrator holds its direction over a step. It is zero
    where `slip` is.
    """
    q, qd = state
    tau = LAWS[options["law"]].torque(model, bodies, q, qd, reference, part["gains"], options["friction"])
    drive = tau
    if options["friction"]:
        factors = part.get("friction", [1.0] * len(model.joints))
        drive = sub(tau, _friction(model, qd, slip, factors))
    wrench = None
    if options["wrench_frame"]:
        wrench = _in_tool(model, q, part["wrench"], options["wrench_frame"])
    return forward_dynamics(model, varied_bodies(model, bodies, part), q, qd, drive, wrench_tool=wrench), tau


def breakaway(model: ArmModel, qd: Vector, part: Mapping[str, Vector]) -> list[Number]:
    """Coulomb torques at the speeds qd against motion in the positive direction, then in the negative one (2 n)."""
    factors = part.get("friction", [1.0] * len(model.joints))
    forward, backward = (_coulomb(model, qd, [way] * len(qd), factors) for way in (1.0, -1.0))
    return [*forward, *(-1.0 * f for f in backward)]


def width_of(fields: Mapping[str, int]) -> int:
    """Count of all parameters, at least one."""
    return max(sum(fields.values()), 1)


def parts_of(fields: Mapping[str, int], parameters: Vector) -> dict[str, Vector]:
    """The parameters by their names."""
    part, first = {}, 0
    for name, count in fields.items():
        part[name], first = parameters[first : first + count], first + count
    return part


def _friction(model: ArmModel, qd: Vector, slip: Vector, factors: Vector) -> list[Number]:
    rates = kinematics.spread(model, qd, rates=True)
    viscous = [
        0.0 if j.friction is None else k * j.friction.viscous * u
        for k, j, u in zip(factors, model.joints, rates, strict=True)
    ]
    return add(kinematics.gather(model, viscous), _coulomb(model, qd, slip, factors))


def _coulomb(model: ArmModel, qd: Vector, slip: Vector, factors: Vector) -> list[Number]:
    rates, slips = kinematics.spread(model, qd, rates=True), kinematics.spread(model, slip, rates=True)
    each = zip(factors, model.joints, rates, slips, strict=True)
    return kinematics.gather(model, [k * coulomb_torque(j.friction, u, s) for k, j, u, s in each])


def _in_tool(model: ArmModel, q: Vector, wrench: Vector, frame: str) -> list[Number]:
    if frame == "tool":
        return list(wrench)
    R, _ = kinematics.frames(model, q)[-1]
    return [*tvec(R, wrench[:3]), *tvec(R, wrench[3:])]

"""An arm whose numbers are letters: lengths, masses, moments and ratios that are not zero are inputs of a graph."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any, cast

import numpy as np

from holonom.mechanics.equations.dynamics.inertia import Inertial, merged, point_mass
from holonom.mechanics.equations.dynamics.regressor import from_parameters, to_parameters
from holonom.mechanics.equations.kinematics import joint_motion
from holonom.mechanics.equations.vectors import sub
from holonom.mechanics.kernels.placement import bodies_of
from holonom.model import ArmModel, Joint, Motor, Transform
from holonom.trace import Graph, Number

__all__ = ["Letters", "symbolic_bodies", "symbolic_model"]

NEGLIGIBLE = 1e-12  # smaller lengths and moments are none


class Letters:
    """Makes an input of the graph for each number, and keeps what stands for what.

    `renamed` gives letters other names; `values` holds the number of each.
    """

    def __init__(self, graph: Graph, renamed: Mapping[str, str]) -> None:
        self._graph, self._renamed = graph, renamed
        self.values: dict[str, float] = {}
        self.proposed: set[str] = set()

    def renamed(self, name: str) -> str:
        """What a letter is called."""
        return self._renamed.get(name, name)

    def __call__(self, name: str, value: float) -> Number:
        """The letter for a number; 0 stays 0."""
        if abs(value) < NEGLIGIBLE:
            return 0.0
        self.proposed.add(name)
        name = self.renamed(name)
        self.values[name] = float(value)
        return self._graph.input(name, 0)


def symbolic_model(model: ArmModel, letter: Letters) -> ArmModel:
    """The arm with letters for lengths (a, b, d along x, y, z), gear ratios k, rotor inertias Im and gravity g.

    Angles between axes stay numbers. A length before a joint's motion is primed where the one after has its letter.
    """
    strength = float(np.linalg.norm(model.gravity))
    g = letter("g", strength)
    gravity = [g * round(x / strength, 12) if x else 0.0 for x in model.gravity]
    joints = tuple(_joint(joint, i + 1, letter) for i, joint in enumerate(model.joints))
    changes: dict[str, Any] = {
        "joints": joints,
        "gravity": tuple(gravity),
        "base": _lengths(model.base, ("x0", "y0", "z0"), letter),
        "tool": _lengths(model.tool, ("xt", "yt", "zt"), letter),
    }
    return dataclasses.replace(model, **changes)


def _joint(joint: Joint, i: int, letter: Letters) -> Joint:
    after = [f"{axis}{i}" for axis in "abd"]
    taken = [abs(row[3]) > NEGLIGIBLE for row in joint.after[:3]]
    before = [f"{axis}{i}_0" if used else f"{axis}{i}" for axis, used in zip("abd", taken, strict=True)]
    motor = joint.motor
    if motor is not None:
        k, inertia = letter(f"k{i}", motor.gear_ratio), letter(f"Im{i}", motor.rotor_inertia)
        motor = Motor(cast("float", k), cast("float", inertia), axis=motor.axis)
    return dataclasses.replace(
        joint, before=_lengths(joint.before, before, letter), after=_lengths(joint.after, after, letter), motor=motor
    )


def _lengths(T: Transform, names: list[str] | tuple[str, ...], letter: Letters) -> Transform:
    rows = [(*row[:3], letter(name, row[3])) for row, name in zip(T[:3], names, strict=True)]
    return cast("Transform", (*rows, T[3]))


def symbolic_bodies(model: ArmModel, lettered: ArmModel, letter: Letters) -> list[Inertial]:
    """Links with letters for masses m, centres of mass cx, cy, cz and moments Ixx, ... about these.

    A centre of mass is measured from the joint's own point (not from the frame's origin, which a Denavit-Hartenberg
    table puts at the link's far end), along the link frame's axes.
    """
    bodies = []
    for i, body in enumerate(bodies_of(model)):
        m, *h = (float(v) for v in to_parameters(body)[:4])
        c = [x / m if m else 0.0 for x in h]
        reach, lettered_reach = (joint_motion(arm.joints[i], 0.0).p_after for arm in (model, lettered))
        k = i + 1
        place = [x + float(p) if m else 0.0 for x, p in zip(c, reach, strict=True)]
        from_joint = [letter(f"c{axis}{k}", x) for axis, x in zip("xyz", place, strict=True)]
        about = merged(body, Inertial(-m, [-x for x in h], [[-m * x * y for y in c] for x in c]))
        moments = zip(("xx", "xy", "yy", "xz", "yz", "zz"), to_parameters(about)[4:], strict=True)
        spread = from_parameters([0.0] * 4 + [letter(f"I{axes}{k}", float(v)) for axes, v in moments])
        bodies.append(merged(spread, point_mass(letter(f"m{k}", m), sub(from_joint, lettered_reach) if m else c)))
    return bodies

"""Which inertias a rigid body can have, and the inertia of several bodies fixed together."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np

from holonom.arrays import Array
from holonom.model.arm import Body
from holonom.model.urdf.elements import fault
from holonom.model.urdf.parts import UrdfLink

__all__ = ["check_inertias", "fixed_together"]


SLACK = 1e-9
"""Relative to the largest principal moment."""


def check_inertias(links: Iterable[UrdfLink], moving: set[str], check: bool | Literal["warn"]) -> None:
    """Refuse (or warn of) inertias that no body has; `moving` names the links that a joint can move."""
    for link in links:
        problem = "" if link.body is None else _problem(link.body, link.name in moving)
        if not problem or check is False:
            continue
        inertial = link.element.need("inertial", "")
        at = inertial.need("mass" if problem.startswith("no mass") else "inertia", "")
        error = fault(at, f"link {link.name!r} has {problem}; correct it, or read it as it is with check_inertia=False")
        if check != "warn":
            raise error
        warnings.warn(str(error), stacklevel=4)


def _problem(body: Body, moves: bool) -> str:
    """Principal moments a <= b <= c of a body: a >= 0 and a + b >= c, or a second moment is negative."""
    a, b, c = (float(x) for x in np.linalg.eigvalsh(_tensor(body)))
    moments = f"{a:.6g}, {b:.6g}, {c:.6g} kg m2"
    slack = SLACK * max(abs(a), abs(c))
    if a < -slack:
        return f"an inertia that is not positive: principal moments {moments}"
    if a + b < c - slack:
        return f"an inertia that no body has: principal moments {moments}, the two smaller less than the third together"
    if body.mass == 0 and c > 0 and moves:
        return f"no mass, but an inertia (principal moments {moments})"
    return ""


def _tensor(body: Body) -> Array:
    xx, yy, zz, xy, yz, xz = body.inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def fixed_together(parts: Sequence[tuple[Body, Array]]) -> Body:
    """Return bodies with their poses (4, 4) in a frame as one body in that frame (Steiner)."""
    if len(parts) == 1 and np.array_equal(parts[0][1], np.eye(4)):
        return parts[0][0]
    mass = sum(body.mass for body, _ in parts)
    centres = [T[:3, :3] @ np.array(body.com) + T[:3, 3] for body, T in parts]
    com = sum((body.mass * c for (body, _), c in zip(parts, centres, strict=True)), np.zeros(3)) / (mass or 1.0)
    I = np.zeros((3, 3))
    for (body, T), centre in zip(parts, centres, strict=True):
        d = centre - com
        I += T[:3, :3] @ _tensor(body) @ T[:3, :3].T + body.mass * (d @ d * np.eye(3) - np.outer(d, d))
    values = [float(I[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))]
    return Body(float(mass), (float(com[0]), float(com[1]), float(com[2])), (*values,))  # type: ignore[arg-type]

"""Which inertias a rigid body can have, and the inertia of several bodies fixed together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal, InvalidOperation
from typing import Literal

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError
from holonom.model.arm import Body
from holonom.model.urdf.check import Check
from holonom.model.urdf.elements import Element, placed
from holonom.model.urdf.parts import MOMENTS, UrdfLink

__all__ = ["CheckInertia", "check_inertias", "fixed_together"]

CheckInertia = bool | Literal["warn"]

SLACK = 1e-9
"""Relative to mass times size squared, and to the largest principal moment: what arithmetic may have left."""
SIZE = 0.01
"""m: the least size of a link."""
PRINTED = 0.01
"""Relative to the largest principal moment: the most that is put down to digits that the file does not print."""


def check_inertias(
    links: Iterable[UrdfLink], moving: set[str], sizes: Mapping[str, float], allow: CheckInertia, check: Check
) -> str:
    """Return why there are no dynamics, "" if nothing speaks against them.

    Parameters
    ----------
    links
        All links.
    moving
        The names of those that a joint can move, of a floating robot all.
    sizes
        How far from a link's origin the joints are that it carries, m.
    allow
        True: what no body has takes the dynamics away; "warn": it is taken with a warning; False: without one.

    Raises
    ------
    ModelError
        An inertia that no body has, where the check is strict and it is not allowed.
    """
    reasons = []
    for link in links:
        if link.body is None:
            problem, counts = link.problem, True
        else:
            what, counts = _impossible(link, link.body, link.name in moving, sizes.get(link.name, 0.0))
            at = _where(link.element, what)
            advice = "correct it, or read it as it is with check_inertia=False"
            problem = what and placed(at, f"link {link.name!r} has {what}; {advice}")
        allowed = allow is not True and link.body is not None
        if not problem or (allowed and allow is False):
            continue
        if check.strict and not allowed:
            raise ModelError(problem)
        check.remark(problem)
        if counts and not allowed and link.name in moving:
            reasons.append(problem)
    if not reasons:
        return ""
    return reasons[0] + (f" (and {len(reasons) - 1} more)" if len(reasons) > 1 else "")


def _where(link: Element, problem: str) -> Element:
    inertial = link.need("inertial", "")
    return inertial.need("mass" if problem.startswith("no mass") else "inertia", "")


def _impossible(link: UrdfLink, body: Body, moves: bool, size: float) -> tuple[str, bool]:
    """What is wrong with an inertia, and whether motions cannot be computed with it.

    Principal moments a <= b <= c of a body: a >= 0 and a + b >= c, or a second moment is negative.
    """
    a, b, c = (float(x) for x in np.linalg.eigvalsh(_tensor(body)))
    moments = f"{a:.6g}, {b:.6g}, {c:.6g} kg m2"
    largest = max(abs(a), abs(c))
    r = max(float(np.linalg.norm(body.com)), size, SIZE)
    slack = SLACK * (largest + body.mass * r**2) + min(_unprinted(link.element), PRINTED * largest)
    if a < -slack:
        return f"an inertia that is not positive: principal moments {moments}", True
    if a + b < c - slack:
        what = f"an inertia that no body has: principal moments {moments}, the two smaller less than the third together"
        return what, True
    if body.mass == 0 and c > slack and moves:
        return f"no mass, but an inertia (principal moments {moments})", False
    return "", False


def _unprinted(link: Element) -> float:
    """How far the moments of inertia may be from those that the file was printed from: half their last digits."""
    stated = link.need("inertial", "").need("inertia", "")
    total = 0.0
    for name in MOMENTS:
        try:
            exponent = Decimal(stated.word(name)).as_tuple().exponent
        except InvalidOperation:
            continue
        if isinstance(exponent, int) and exponent < 0:
            total += 0.5 * 10.0**exponent
    return total


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

"""A base from a URDF or xacro file: its wheels by their joints, its body by all links."""

from __future__ import annotations

import warnings
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from holonom.errors import ModelError, ModelWarning
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.urdf.places import Parts, parts_of
from holonom.mobile.urdf.recognise import (
    Found,
    candidates,
    driven_joints,
    nothing_found,
    recognised,
    skidding,
    stated_wheels,
)
from holonom.mobile.urdf.writer import Own, own_words
from holonom.model.load import robot_document
from holonom.model.urdf.check import Check, CheckMode

__all__ = ["load_base"]

_HANGS = 5e-3  # m, that a wheel may stand off the floor of the others without a word
_ONE_LINE = 1e-3  # m


def load_base(
    source: str | Path,
    wheels: str | Iterable[str] | Mapping[str, str | Mapping[str, Any]] | None = None,
    *,
    frame: str | None = None,
    wheel_radius: float | None = None,
    check: CheckMode = "warn",
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> WheelBase:
    """Return the base that a URDF or xacro file describes; meshes are never opened.

    Parameters
    ----------
    source : a file, or the text of a URDF (any string with a "<").
    wheels : joints that wheels turn on: names; or name -> kind ("fixed", "steered", "castor", "swedish", "skid",
        "spherical", "ball"); or name -> fields of `Wheel.at` (`kind`, `radius`, `roller_angle`, `driven`, ...), which a
        URDF cannot say. None: those that look like wheels, a guess, which a warning tells.
    frame : the link that is base_link; "base_link", "base_footprint", "base", "chassis" or the root unless given.
    wheel_radius : m, of wheels whose links have no cylinder or sphere.
    check : "warn": what is guessed is a warning; "strict": it is an error.
    packages, arguments : of a xacro file, as for `load_arm`.

    Returns
    -------
    WheelBase
        Wheels are called like their joints, in the order of the file; mass, centre of mass and inertia are those of all
        links while no joint has moved. `notes` says which joints were taken, as what, and what was guessed.

    Raises
    ------
    ModelError
        Not a URDF; no wheels, or none that drives; a wheel without a radius, or whose axle is not level; wheels that
        cannot roll together.
    UnknownName
        No such joint, link, kind or key.
    InputError

    Warns
    -----
    ModelWarning
        What was guessed.

    Notes
    -----
    A wheel below a joint with an upright axis is steered, or a castor where its axle trails behind a free pivot. Wheels
    with a transmission, a velocity interface of ros2_control or a drive plugin are driven; where a file has none, fixed
    wheels are, or all where all are steered. Fixed wheels on several axles skid (`skid_steer`): their effective track
    is taken for half as much again as the track. Two wheels on one axle without any other balance.
    """
    found_in = Check(check)
    robot = robot_document(source, found_in, packages=packages, arguments=arguments)
    parts = parts_of(robot, frame, found_in)
    own = own_words(robot)
    stated = stated_wheels(wheels) if wheels is not None else dict(own.wheels)
    names = list(stated) or candidates(parts)
    if not names:
        raise nothing_found(parts)
    base = _base(parts, names, stated, own, wheel_radius, found_in)
    if wheels is None and not own.wheels:
        found_in.note(robot, f"wheels are guessed: {base.notes[0]}; state wheels= where that is wrong")
    for note in found_in.notes:
        warnings.warn(note, ModelWarning, stacklevel=2)
    base.notes += found_in.notes
    return base


def _base(
    parts: Parts, names: list[str], stated: Mapping[str, Mapping[str, Any]], own: Own, wheel_radius: float | None,
    check: Check,
) -> WheelBase:  # fmt: skip
    rolling = [name for name in names if name not in parts.joints or parts.joints[name].moves]
    driven = driven_joints(parts)
    first = [recognised(parts, name, stated.get(name, {}), driven, None, wheel_radius) for name in rolling]
    floor = min((one.height - one.wheel.radius for one in first), default=None)
    found = {one.joint.name: one for one in first}
    for name in names:
        if name not in found:
            found[name] = recognised(parts, name, stated.get(name, {}), driven, floor, wheel_radius)
    taken = [found[name] for name in names]
    if not own.wheels:
        taken = skidding(_with_motors(taken, driven, stated, check))
    floor = min(one.height - one.wheel.radius for one in taken)
    for one in taken:
        gap = one.height - one.wheel.radius - floor
        if gap > _HANGS:
            check.note(one.joint.element, f"wheel {one.joint.name!r} hangs {1e3 * gap:.0f} mm above the others' floor")
    own_base = own.base or {"balances": _balances(taken)}
    return WheelBase(
        [one.wheel for one in taken], name=own.name or parts.robot.attributes.get("name") or "base",
        notes=("; ".join(one.told() for one in taken),), **_groups(taken, own), **own_base,
        **_body(parts, floor, check),
    )  # fmt: skip


def _with_motors(
    taken: list[Found], driven: Collection[str], stated: Mapping[str, Mapping[str, Any]], check: Check
) -> list[Found]:
    """Where a file says of no wheel what drives it: fixed wheels are driven, or all where all are steered."""
    if any(one.wheel.driven for one in taken):
        return taken
    fixed = [one for one in taken if one.wheel.kind in ("fixed", "swedish", "skid")]
    able = fixed or [one for one in taken if one.wheel.kind == "steered"]
    made = [one for one in able if "driven" not in stated.get(one.joint.name, {})]
    if not made:
        return taken
    names = ", ".join(repr(one.joint.name) for one in made)
    check.note(
        made[0].joint.element, f"no transmission, ros2_control or plugin drives a wheel: {names} count as driven"
    )
    return [replace(one, wheel=replace(one.wheel, driven=True)) if one in made else one for one in taken]


def _balances(taken: list[Found]) -> bool:
    """Whether the wheels stand on one line along their axles."""
    if any(one.wheel.kind != "fixed" for one in taken) or len(taken) < 2:
        return False
    heading = taken[0].wheel.heading
    along = [one.wheel.x * np.cos(heading) + one.wheel.y * np.sin(heading) for one in taken]
    return float(np.ptp(along)) < _ONE_LINE


def _groups(taken: list[Found], own: Own) -> dict[str, Any]:
    """Wheels on one pivot, and those that the file says are steered together."""
    groups = dict(own.groups)
    pivots: dict[str, list[str]] = {}
    for one in taken:
        if one.pivot is not None and one.wheel.kind == "steered":
            pivots.setdefault(one.pivot.name, []).append(one.wheel.name)
    groups |= {name: members for name, members in pivots.items() if len(members) > 1 and not own.groups}
    return {"steering_groups": groups} if groups else {}


def _body(parts: Parts, floor: float, check: Check) -> dict[str, Any]:
    """Mass, centre of mass and inertia as `WheelBase` takes them."""
    body = parts.body()
    if body is None:
        return {}
    x, y, z = body.com
    height = z - floor
    if height < 0.0:
        raise ModelError(
            f"{parts.robot.source}: the centre of mass lies {-height:.3g} m below the floor that the wheels stand on; "
            "see <inertial> origins and wheel radii"
        )
    xx, yy, zz, xy, yz, xz = body.inertia
    inertia = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    made: dict[str, Any] = {"mass": body.mass, "com": (x, y), "com_height": height}
    low, middle, high = np.linalg.eigvalsh(inertia).tolist()
    if low > 0.0 and high <= (low + middle) * (1.0 + 1e-9):
        return {**made, "inertia": inertia}
    check.doubt(
        parts.robot,
        f"the links make an inertia of principal moments {low:.4g}, {middle:.4g}, {high:.4g} kg m2, which no body has",
        "a disc about the wheels is taken", instead="see <inertia> of the links",
    )  # fmt: skip
    return made

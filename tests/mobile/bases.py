"""Bases for the tests: one of each arrangement, and Hypothesis strategies for random ones."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import assume
from hypothesis import strategies as st

from holonom.mobile.arrangements import (
    ackermann,
    bicycle,
    differential,
    dual_ackermann,
    mecanum,
    omni,
    rocker6,
    segway,
    skid_steer,
    sphere,
    swerve,
    synchro,
    tricycle,
)
from holonom.mobile.base import WheelBase
from holonom.mobile.base.wheel import Wheel


def presets() -> dict[str, WheelBase]:
    """One base of every arrangement, and a few that are less even."""
    return {
        "differential": differential(0.3, 0.05),
        "unequal": differential(0.3, (0.05, 0.052)),
        "tricycle": tricycle(1.2, 0.8, 0.15),
        "ackermann": ackermann(2.5, 1.5, 0.3),
        "synchro": synchro(0.25, 0.06),
        "omni3": omni(n=3, radius=0.2, wheel_radius=0.05),
        "soccer": omni(np.radians([57, 135, 225, 303]), radius=0.08, wheel_radius=0.027, mass=2.5, com_height=0.04),
        "mecanum": mecanum(0.4, 0.3, 0.05),
        "swerve": swerve(wheelbase=0.5, track=0.4, wheel_radius=0.05),
        "sphere": sphere(0.11),
        "bicycle": bicycle(1.1, 0.3),
        "dual_ackermann": dual_ackermann(0.5, 0.4, 0.05),
        "skid_steer": skid_steer(0.3, 0.35, 0.06),
        "segway": segway(0.4, 0.1),
        "rocker6": rocker6(0.8, 0.6, 0.1),
    }


lengths = st.floats(0.05, 2.0)
places = st.tuples(*2 * [st.integers(-2000, 2000).map(lambda mm: 1e-3 * mm)])
angles = st.floats(-math.pi, math.pi)
radii = st.floats(0.02, 0.5)
twists = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)).map(np.array)


@st.composite
def wheels(draw, kind: str, *, driven: bool | None = None) -> Wheel:
    """A wheel of a kind, anywhere, with any heading."""
    x, y = draw(places)
    special = {}
    if kind == "swedish":
        special["roller_angle"] = draw(st.floats(-1.2, 1.2))
    if kind == "castor":
        special["castor_offset"] = draw(st.floats(0.02, 0.3)) * draw(st.sampled_from([-1.0, 1.0]))
    turned = kind != "castor" and (draw(st.booleans()) if driven is None else driven)
    return Wheel.at(kind, x, y, draw(angles), radius=draw(radii), driven=turned, **special)


@st.composite
def omni_bases(draw, least: int = 3, most: int = 6) -> WheelBase:
    """Driven Swedish wheels that can move the base every way."""
    found = draw(st.lists(wheels("swedish", driven=True), min_size=least, max_size=most))
    base = WheelBase(found, name="random omni", alpha=draw(st.floats(0.2, 1.5)))
    singular = np.linalg.svd(base.velocity_coupling, compute_uv=False)
    assume(singular[-1] > 0.05 * singular[0])
    return base


@st.composite
def axled_bases(draw) -> WheelBase:
    """Driven fixed wheels on one axle, with castors and balls: any differential drive."""
    x, y = draw(places)
    psi = draw(angles)
    along = draw(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=3).filter(lambda a: max(a) - min(a) > 0.1))
    found = [
        Wheel.at("fixed", x - a * math.sin(psi), y + a * math.cos(psi), psi, radius=draw(radii), driven=True)
        for a in along
    ]
    found += draw(st.lists(st.one_of(wheels("castor"), wheels("spherical", driven=False)), max_size=2))
    return WheelBase(found, name="random axle")


@st.composite
def steered_bases(draw) -> WheelBase:
    """Two to four steered wheels that stand apart, some driven, perhaps with castors."""
    found = draw(st.lists(wheels("steered", driven=True), min_size=2, max_size=3))
    found += draw(st.lists(wheels("steered", driven=False), max_size=1))
    spots = np.array([(w.x, w.y) for w in found])
    apart = np.linalg.norm(spots[:, None] - spots[None], axis=-1) + 9.0 * np.eye(len(spots))
    assume(apart.min() > 0.2)
    return WheelBase([*found, *draw(st.lists(wheels("castor"), max_size=1))], name="random steered")


def any_base() -> st.SearchStrategy[WheelBase]:
    """Any of the random bases."""
    return st.one_of(omni_bases(), axled_bases(), steered_bases())

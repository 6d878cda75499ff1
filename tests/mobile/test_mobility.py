"""Degrees of mobility, and the wheels that conflict."""

import itertools
import re

import numpy as np
import pytest
from bases import any_base, presets, twists, wheels
from hypothesis import assume, given
from hypothesis import strategies as st

from holonom.errors import ModelError
from holonom.mobile.base import WheelBase
from holonom.mobile.base.mobility import Mobility, degrees_of_freedom, is_holonomic, mobility
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.poses import integrated

PUBLISHED = {  # Siegwart & Nourbakhsh, fig. 3.14, and Campion, Bastin & d'Andrea-Novel 1996
    "differential": (2, 0, 2),
    "unequal": (2, 0, 2),
    "tricycle": (1, 1, 2),
    "ackermann": (1, 1, 2),
    "synchro": (1, 1, 2),
    "omni3": (3, 0, 3),
    "soccer": (3, 0, 3),
    "mecanum": (3, 0, 3),
    "swerve": (1, 2, 3),
    "sphere": (2, 0, 2),
    "bicycle": (1, 1, 2),
    "dual_ackermann": (1, 2, 3),
    "skid_steer": (2, 0, 2),
    "segway": (2, 0, 2),
    "rocker6": (1, 1, 2),
}


@pytest.mark.parametrize("name", sorted(PUBLISHED))
def test_published_degrees(name):
    base = presets()[name]
    assert mobility(base) == Mobility(*PUBLISHED[name])
    assert is_holonomic(base) == (PUBLISHED[name][0] == 3 or name == "sphere")
    assert degrees_of_freedom(base) == (2 if name in ("synchro", "sphere") else 3)  # these two never turn


def test_omni_steer_and_skid_steer():
    ball = Wheel.at("spherical", 0.3, 0.0, radius=0.05)
    lone = WheelBase([Wheel.at("steered", 0.0, 0.0, radius=0.1, driven=True), ball])
    assert mobility(lone) == (2, 1, 3)  # Siegwart & Nourbakhsh: omni-steer
    two = [Wheel.at("steered", x, 0.0, radius=0.1, driven=True, name=str(x)) for x in (0.3, -0.3)]
    assert mobility(WheelBase(two)) == (1, 2, 3)  # two-steer
    skid = WheelBase([Wheel.at("fixed", x, y, radius=0.1, driven=True) for x in (0.2, -0.2) for y in (0.2, -0.2)])
    assert mobility(skid) == (1, 0, 1)  # four fixed wheels only roll straight without skidding


@given(any_base(), twists)
def test_mobility_is_three_minus_the_rank_of_the_sliding_rows(base, v):
    """Of a generic steering: a special one, such as axles on one line, may leave more."""
    dm, ds, dM = mobility(base)
    assert dM == dm + ds
    if not base.sliding_names:
        assert dm == 3
        return
    left = []
    for twist in (v, *np.random.default_rng(0).normal(size=(4, 3))):
        xi = base.feasible(twist)
        contacts = [np.hypot(xi[0] - xi[2] * w.y, xi[1] + xi[2] * w.x) for w in base.wheels if w.kind == "steered"]
        if np.linalg.norm(xi) > 0.05 and min(contacts, default=1.0) > 0.02:
            C1 = base.sliding_matrix(base.steering(xi)) * [1.0, 1.0, 1.0 / base.radius]
            left.append(3 - np.linalg.matrix_rank(C1, tol=1e-7))
    assume(left)
    assert dm == min(left)


def held(message):
    return re.findall(r"'([^']*)'", message.split(" cannot roll")[0])


@given(st.lists(wheels("fixed"), min_size=3, max_size=6), st.lists(wheels("steered"), max_size=2))
def test_conflicting_wheels_are_a_smallest_set(fixed, steered):
    ball = Wheel.at("spherical", 0.0, 0.0, radius=0.1, driven=True, name="ball")
    named = [
        Wheel.at(w.kind, w.x, w.y, w.heading, radius=w.radius, name=f"w{k}") for k, w in enumerate(fixed + steered)
    ]
    rows = np.array([[np.cos(w.axle), np.sin(w.axle), w.x * np.sin(w.axle) - w.y * np.cos(w.axle)] for w in named])
    for few in itertools.combinations(range(len(fixed)), 3):
        assume(abs(np.linalg.det(rows[list(few)])) > 1e-3)
    with pytest.raises(ModelError, match="cannot roll together") as problem:
        WheelBase([*named, ball])
    guilty = [w for w in named if w.name in held(str(problem.value))]
    assert len(guilty) == 3
    assert all(w.kind == "fixed" for w in guilty)
    with pytest.raises(ModelError, match="cannot roll together"):
        WheelBase([*guilty, ball])
    for pair in itertools.combinations(guilty, 2):
        WheelBase([*pair, ball])  # without any one of them the others can


def test_axles_that_miss_say_by_how_much():
    axle = [Wheel.at("fixed", 0.0, y, radius=0.1, driven=True, name=n) for n, y in (("left", 0.3), ("right", -0.3))]
    front = Wheel.at("fixed", 1.0, 0.0, 0.3, radius=0.1, name="front")
    WheelBase([*axle, front])  # its axle meets theirs in a point: the base can turn about it
    skewed = Wheel.at("fixed", 0.05, -0.3, 0.0, radius=0.1, name="right")
    with pytest.raises(ModelError, match=r"'left', 'right', 'front' cannot .* miss by 0\.0\d+ m.*castor"):
        WheelBase([axle[0], skewed, front])


def test_wheels_that_steer_together_may_conflict():
    fixed = [Wheel.at("fixed", 0.0, y, radius=0.1, driven=True, name=n) for n, y in (("left", 0.3), ("right", -0.3))]
    fronts = [Wheel.at("steered", 1.0, y, radius=0.1, name=f"front {n}") for n, y in (("left", 0.3), ("right", -0.3))]
    together = WheelBase([*fixed, *fronts], steering_groups={"rod": ["front left", "front right"]})
    assert mobility(together) == (1, 0, 1)  # parallel fronts fit a fixed axle only straight ahead
    with pytest.raises(ModelError, match="cannot roll together"):
        WheelBase(
            [*fixed, *fronts, Wheel.at("fixed", 1.0, 0.0, 0.2, radius=0.1, name="middle")],
            steering_groups={"rod": ["front left", "front right"]},
        )
    pairs = {"front": ["fl", "fr"], "rear": ["rl", "rr"]}
    corners = [("fl", 0.5, 0.3), ("fr", 0.5, -0.3), ("rl", -0.5, 0.3), ("rr", -0.5, -0.3)]
    crab = WheelBase(
        [Wheel.at("steered", x, y, radius=0.1, driven=True, name=n) for n, x, y in corners], steering_groups=pairs
    )
    assert mobility(crab) == (1, 1, 2)  # both pairs have to be parallel: it goes anywhere and never turns


def fixed(*places, driven=True):
    return WheelBase([Wheel.at("fixed", x, y, psi, radius=0.1, driven=driven) for x, y, psi in places])


@pytest.mark.parametrize(
    ("base", "dm", "dof"),
    [
        (fixed((1.0, 0.0, 0.0), (0.0, 1.0, np.pi / 2)), 1, 1),  # crossing axles: it turns about one point
        (fixed((0.2, 0.2, 0.0), (-0.2, -0.2, 0.0)), 1, 1),  # parallel axles: straight on
        (fixed((0.3, 0.1, 0.7)), 2, 3),  # a single wheel: parks sideways
    ],
)
def test_wheels_whose_constraints_are_integrable_are_holonomic(base, dm, dof):
    assert (mobility(base).dm, degrees_of_freedom(base)) == (dm, dof)
    assert is_holonomic(base) == (dm == dof)


def test_steering_counts_among_what_can_be_reached():
    ball = Wheel.at("spherical", 0.3, 0.0, radius=0.05)
    lone = WheelBase([Wheel.at("steered", 0.0, 0.0, radius=0.1, driven=True), ball])
    assert (degrees_of_freedom(lone), is_holonomic(lone)) == (3, False)


@given(any_base(), st.floats(-2.0, 2.0), st.floats(-2.0, 2.0), st.floats(-3.0, 3.0))
def test_freedom_does_not_depend_on_where_base_link_is(base, x, y, turn):
    c, s = np.cos(turn), np.sin(turn)
    moved = [
        Wheel.at(
            w.kind, x + c * w.x - s * w.y, y + s * w.x + c * w.y, w.heading + turn, radius=w.radius, driven=w.driven,
            roller_angle=w.roller_angle, castor_offset=w.castor_offset, name=w.name,
        )
        for w in base.wheels
    ]  # fmt: skip
    other = WheelBase(moved)
    assert degrees_of_freedom(other) == degrees_of_freedom(base)
    assert is_holonomic(other) == is_holonomic(base)
    assert mobility(base).dm <= degrees_of_freedom(base) <= 3


def test_degrees_of_freedom_are_those_of_driving_around():
    """Poses after random drives, steering in between: their spread has as many directions as was computed."""
    rng = np.random.default_rng(5)
    for name in ("differential", "synchro", "ackermann", "swerve", "omni3"):
        base = presets()[name]
        ends = []
        for _ in range(300):
            twists = base.feasible(rng.uniform(-1.0, 1.0, (12, 3)))
            ends.append(integrated([0.0, 0.0, 0.0], twists, 0.1)[-1])
        spread = np.linalg.svd(np.array(ends) - np.mean(ends, axis=0), compute_uv=False)
        assert np.count_nonzero(spread > 1e-3 * spread[0]) == degrees_of_freedom(base)

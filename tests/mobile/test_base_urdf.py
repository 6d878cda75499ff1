"""Bases from URDF files and back: numbers as drawn, kinds by how wheels hang, what cannot be read said."""

from __future__ import annotations

import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from base_runs import BASES

import holonom as hm
from holonom.errors import InputError, ModelError, ModelWarning, UnknownName
from holonom.mobile import WheelBase
from holonom.mobile.urdf import base_urdf, load_base

ROUND = '<cylinder radius="0.05" length="0.02"/>'
LIMITS = '<limit lower="-0.6" upper="0.5" effort="1" velocity="1"/>'


def wheel(
    name: str, xyz: str, parent: str = "base_link", *, shape: str = ROUND, axis: str = "0 1 0", kind: str = "continuous"
) -> str:
    collision = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    turning = f'<axis xyz="{axis}"/>' if kind != "fixed" else ""
    return (
        f'<link name="{name}_link">{collision}</link><joint name="{name}" type="{kind}"><origin xyz="{xyz}"/>'
        f'<parent link="{parent}"/><child link="{name}_link"/>{turning}</joint>'
    )


def pivot(name: str, xyz: str, *, kind: str = "revolute", limit: str = LIMITS) -> str:
    return (
        f'<link name="{name}_link"/><joint name="{name}" type="{kind}"><origin xyz="{xyz}"/>'
        f'<parent link="base_link"/><child link="{name}_link"/><axis xyz="0 0 1"/>{limit if kind == "revolute" else ""}'
        "</joint>"
    )


def robot(*parts: str, body: str = "") -> str:
    return f'<robot name="trolley"><link name="base_link">{body}</link>{"".join(parts)}</robot>'


PAIR = wheel("left_wheel", "0 0.15 0.05"), wheel("right_wheel", "0 -0.15 0.05")


def quietly(source: str, wheels=None, **options) -> WheelBase:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        return load_base(source, wheels, **options)


@pytest.mark.parametrize("kind", BASES)
def test_a_base_comes_back_from_its_own_file(kind: str, tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    spread = np.cov(rng.normal(size=(3, 8)))
    inertia = np.trace(spread) * np.eye(3) - spread
    made = BASES[kind]
    groups = {
        name: [made.wheels[i].name for i in members]
        for name, members in zip(made.steered, made.layout.groups, strict=True)
        if len(members) > 1
    }
    base = WheelBase(
        made.wheels,
        name="mine & yours",
        radius=made.radius,
        mass=7.0,
        com=(0.01, -0.02),
        com_height=0.11,
        inertia=inertia,
        suspension=made.suspension,
        balances=made.balances,
        steering_groups=groups,
    )
    path = tmp_path / "base.urdf"
    path.write_text(base_urdf(base), encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = hm.load_base(path)
    assert (again.name, again.driven, again.steered) == (base.name, base.driven, base.steered)
    assert (again.suspension, again.balances, again.mass) == (base.suspension, base.balances, base.mass)
    assert np.allclose(again.rest_coupling, base.rest_coupling, atol=1e-12)
    assert np.allclose(again.sliding_matrix(), base.sliding_matrix(), atol=1e-12)
    assert np.allclose(again.wheel_radii, base.wheel_radii)
    for one, other in zip(again.wheels, base.wheels, strict=True):
        assert (one.kind, one.max_steering, one.acts_at) == (other.kind, other.max_steering, other.acts_at)
        assert (one.castor_offset, one.roller_angle) == pytest.approx((other.castor_offset, other.roller_angle))
    assert np.allclose(again.inertia, base.inertia, atol=1e-12)
    assert np.allclose([*again.com, again.com_height], [0.01, -0.02, 0.11])


def test_a_small_robot_with_a_ball_and_axles_along_z() -> None:
    """As many files draw it: wheels turned by a rounded quarter turn, a fixed castor below another link."""
    side = (
        '<link name="wheel_{0}_link"><collision><geometry><cylinder length="0.018" radius="0.033"/></geometry>'
        '</collision><inertial><mass value="0.03"/>'
        '<inertia ixx="1e-5" ixy="0" ixz="0" iyy="1e-5" iyz="0" izz="2e-5"/></inertial></link>'
        '<joint name="wheel_{0}_joint" type="continuous"><origin xyz="0.0 {1} 0.023" rpy="-1.57 0 0"/>'
        '<parent link="base_link"/><child link="wheel_{0}_link"/><axis xyz="0 0 1"/></joint>'
    )
    text = (
        '<robot name="small"><link name="base_footprint"/><joint name="base_joint" type="fixed">'
        '<origin xyz="0 0 0.010"/><parent link="base_footprint"/><child link="base_link"/></joint>'
        '<link name="base_link"><inertial><origin xyz="0 0 0.05"/><mass value="0.8"/>'
        '<inertia ixx="2e-3" ixy="0" ixz="0" iyy="2e-3" iyz="0" izz="2e-3"/></inertial></link>'
        + side.format("left", "0.08")
        + side.format("right", "-0.08")
        + '<link name="caster_back_link"/><joint name="caster_back_joint" type="fixed"><origin xyz="-0.081 0 -0.004"/>'
        '<parent link="base_link"/><child link="caster_back_link"/></joint></robot>'
    )
    with pytest.warns(ModelWarning) as warned:
        base = load_base(text)
    told = " ".join(str(one.message) for one in warned)
    assert "'wheel_left_joint': driven fixed wheel, radius 0.033 m, at (0, 0.08) m" in told
    assert "no transmission" in told
    assert [w.kind for w in base.wheels] == ["fixed", "fixed", "spherical"]
    assert not base.balances
    assert base.mass == pytest.approx(0.86)
    assert base.com_height == pytest.approx((0.8 * 0.05 + 0.06 * 0.023) / 0.86 + 0.010, abs=1e-6)
    twist = base.twist([1.0, 3.0])
    assert twist == pytest.approx([0.033 * 2.0, 0.0, 0.033 * 2.0 / 0.16], abs=1e-6)
    assert base.wheels[2].radius == pytest.approx(0.010 - 0.004 - 0.0, abs=1e-9)
    assert base.notes[1:] == tuple(str(one.message) for one in warned)


def test_a_car() -> None:
    """Steered wheels by their pivots, limits by the narrower side, driven by what has a transmission."""
    text = robot(
        pivot("left_steering_hinge", "0.4 0.14 0.05"),
        wheel("left_front_wheel", "0 0.01 0", "left_steering_hinge_link"),
        pivot("right_steering_hinge", "0.4 -0.14 0.05"),
        wheel("right_front_wheel", "0 -0.01 0", "right_steering_hinge_link"),
        wheel("left_rear_wheel", "0 0.15 0.05"),
        wheel("right_rear_wheel", "0 -0.15 0.05"),
        *(f'<transmission name="{n}"><joint name="{n}_rear_wheel"/></transmission>' for n in ("left", "right")),
    )
    base = quietly(text)
    assert [(w.kind, w.driven) for w in base.wheels] == [("steered", False)] * 2 + [("fixed", True)] * 2
    assert base.wheels[0].max_steering == pytest.approx(0.5)
    expected = hm.mobile.ackermann(0.4, 0.3, 0.05, max_steering=0.5)
    assert base.turning_radius == pytest.approx(expected.turning_radius)
    assert np.allclose(base.steering([1.0, 0.0, 0.5]), expected.steering([1.0, 0.0, 0.5]))


def test_castors_trail_behind_free_pivots_and_skidding_axles() -> None:
    castor = pivot("castor_swivel", "-0.2 0 0.05", kind="continuous") + wheel(
        "castor_roll", "-0.04 0 0", "castor_swivel_link"
    )
    base = quietly(robot(*PAIR, castor))
    assert base.wheels[2].kind == "castor"
    assert base.wheels[2].castor_offset == pytest.approx(0.04)
    assert math.cos(base.wheels[2].heading) == pytest.approx(-1.0)
    four = [
        wheel(f"{n}_wheel", f"{x} {y} 0.05")
        for n, x, y in (("a", 0.2, 0.15), ("b", 0.2, -0.15), ("c", -0.2, 0.15), ("d", -0.2, -0.15))
    ]
    skid = quietly(robot(*four))
    same = hm.mobile.skid_steer(0.4, 0.3, 0.05)
    assert {w.kind for w in skid.wheels} == {"skid"}
    assert np.allclose(skid.rest_coupling / [1, 1, 1 / skid.radius], same.rest_coupling / [1, 1, 1 / same.radius])
    assert quietly(robot(*PAIR)).balances


def test_what_is_stated_wins() -> None:
    places = (("fl", 0.2, 0.15, 1), ("fr", 0.2, -0.15, -1), ("rl", -0.2, 0.15, -1), ("rr", -0.2, -0.15, 1))
    text = robot(*(wheel(f"{n}_wheel", f"{x} {y} 0.05", shape="") for n, x, y, _ in places))
    with pytest.raises(ModelError, match=r"fl_wheel.*no cylinder or sphere.*wheel_radius="):
        load_base(text)
    stated = {
        f"{n}_wheel": {"kind": "swedish", "roller_angle": -sign * math.pi / 4, "driven": True}
        for n, _, _, sign in places
    }
    base = load_base(text, stated, wheel_radius=0.05)
    same = hm.mobile.mecanum(0.4, 0.3, 0.05)
    assert np.allclose(
        np.abs(base.rest_coupling / [1, 1, 1 / base.radius]), np.abs(same.rest_coupling / [1, 1, 1 / same.radius])
    )
    assert quietly(robot(*PAIR, wheel("spare_wheel", "0.3 0 0.3")), ["left_wheel", "right_wheel"]).driven == (
        "left_wheel",
        "right_wheel",
    )
    assert quietly(robot(*PAIR), "left_wheel").driven == ("left_wheel",)


def test_motors_by_ros2_control_and_by_a_plugin() -> None:
    control = (
        '<ros2_control name="c"><joint name="left_wheel"><command_interface name="velocity"/></joint></ros2_control>'
    )
    plugin = (
        "<gazebo><plugin><left_joint>left_wheel</left_joint><right_joint>right_wheel</right_joint></plugin></gazebo>"
    )
    assert [w.driven for w in quietly(robot(*PAIR, control)).wheels] == [True, False]
    assert [w.driven for w in quietly(robot(*PAIR, plugin)).wheels] == [True, True]


BODY = (
    '<inertial><origin xyz="0 0 {z}"/><mass value="3"/>'
    '<inertia ixx="{x}" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
)
LIMIT = '<limit lower="0.1" upper="0.5" effort="1" velocity="1"/>'
OWN = '<holonom><wheel joint="left_wheel" name="l" kind="skid" acts_at="1 x"/></holonom>'
BAD: list[tuple[str, dict, type[Exception], str]] = [
    ("<sdf/>", {}, ModelError, "a URDF is a <robot>"),
    (robot(wheel("arm", "0 0 0", shape="")), {}, ModelError, "no joint looks like a wheel.*wheels=, of arm"),
    (robot(), {}, ModelError, "no joint that turns"),
    (robot(*PAIR), {"wheels": ["left_weel"]}, UnknownName, "did you mean 'left_wheel'"),
    (robot(*PAIR), {"wheels": {"left_wheel": "mecanum"}}, UnknownName, "kind of wheel 'mecanum'"),
    (robot(*PAIR), {"wheels": {"left_wheel": {"gamma": 1.0}}}, UnknownName, "key of the wheel"),
    (robot(*PAIR), {"wheels": 3}, InputError, "names of joints"),
    (robot(*PAIR), {"frame": "chassis"}, UnknownName, "link 'chassis'"),
    (robot(wheel("a_wheel", "0 0 0", axis="0 0 1")), {"wheels": "a_wheel"}, ModelError, "axle along.*level"),
    (robot(wheel("a_wheel", "0 0 0", shape='<sphere radius="0"/>')), {}, ModelError, "radius 0.0 m"),
    (robot(*PAIR, body=BODY.format(z=-1, x=1)), {}, ModelError, "below the floor"),
    (
        robot(pivot("s", "0 0 0", limit=LIMIT), wheel("s_wheel", "0 0 0.05", "s_link")),
        {},
        ModelError,
        "steers from 0.1 to 0.5",
    ),
    (
        robot(*PAIR),
        {"wheels": {f"{side}_wheel": {"driven": False} for side in ("left", "right")}},
        ModelError,
        "no driven wheel",
    ),
    (robot(*PAIR, OWN), {}, ModelError, "two finite numbers"),
    (robot(*PAIR), {"check": "strict", "packages": {}}, InputError, "packages="),
    (robot(*PAIR, body=BODY.format(z=0.1, x=5)), {"check": "strict"}, ModelError, "principal moments"),
]


@pytest.mark.parametrize(("text", "options", "kind", "words"), BAD, ids=[row[3] for row in BAD])
def test_bad_files(text: str, options: dict, kind: type[Exception], words: str) -> None:
    with pytest.raises(kind, match=words):
        quietly(text, **options)


def test_what_is_odd_is_noted() -> None:
    base = quietly(robot(*PAIR, wheel("third_wheel", "-0.2 0 0.09")))
    assert any("hangs 40 mm" in note for note in base.notes)
    base = quietly(robot(*PAIR, body=BODY.format(z=0.1, x=5)))
    assert any("which no body has: a disc about the wheels is taken" in note for note in base.notes)
    assert base.mass == 3.0


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match=r"none\.urdf"):
        hm.load_base(tmp_path / "none.urdf")

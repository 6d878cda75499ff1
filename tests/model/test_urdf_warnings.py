"""Files as strangers write them: read with a warning that names the line, refused where the check is strict."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest
from float_arm import fk, inverse_dynamics
from test_urdf import ARM, BAD, INERTIAL, LIMIT, inertia, joint, link, robot

from holonom.errors import MissingInertia, ModelError, ModelWarning, UnknownName
from holonom.mechanics import Arm
from holonom.model import Friction, JointLimits, Mimic, Motor, read_urdf

READ = {
    "xacro": None,
    "text after": "something after </robot>",
    "no limits": "states no position limits: it has none",
    "no slide limits": "states no position limits: it has none",
    "no position": "states no position limits: it has none",
    "no effort": 'needs effort="...".* it has no such limit',
    "swapped": "5.0 above the upper 2.0: they are taken the other way round",
    "speed": "velocity -3.0 and effort 4.0: what is negative is taken as no limit",
    "damping": "damping -1.0 and friction 0.0: what is negative is taken as 0",
    "misspelt": "which says nothing: it is passed over; was <origin> meant?",
    "twice": "has a second <limit>: the first is taken",
    "mimic": "mimics an unknown joint: .*: it moves on its own",
    "mimic itself": "they follow each other, so it moves on its own",
    "fixed mimic": None,
    "mimic chain": "it follows that one, with the factors multiplied",
    "mass": "the mass is -1.0 kg",
    "no mass": "<inertial> has no <mass>",
    "no inertia": "has no <inertia>",
    "missing moment": "needs ixy=",
    "not positive": "an inertia that is not positive",
    "triangle": "an inertia that no body has",
    "massless": "no mass, but an inertia",
    "transmission": "drives an unknown joint: .*: it is passed over",
    "gear": "<mechanicalReduction> is 0.0: it is passed over",
}
"""Of the files that a strict check refuses, those that are read, and what the warning says. (None: no joint moves.)"""


def told(text, **options):
    """The model and what was warned of."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = read_urdf(text, **options)
    assert all(one.category is ModelWarning for one in caught)
    assert tuple(str(one.message) for one in caught) == model.notes
    assert all(re.match(r"URDF text, line \d+: ", note) for note in model.notes)
    return model, " | ".join(model.notes)


@pytest.mark.parametrize("case", sorted(BAD))
def test_what_leaves_the_tree_whole_is_read_with_a_warning_and_all_else_refused(case):
    text, line, _ = BAD[case]
    said = READ.get(case)
    if said is None:
        with pytest.raises(ModelError):
            read_urdf(text)
        return
    model, notes = told(text)
    assert re.search(said, notes), notes
    assert f"line {line}: " in notes
    assert Arm(model).n >= 1


def test_what_is_taken_instead():
    def limits(inside):
        return told(robot(*ARM[:2], joint("j", "a", "b", inside)))[0].joints[0].limits

    assert limits("") == JointLimits()
    assert limits('<limit effort="4" velocity="3"/>') == JointLimits(speed=3, torque=4)
    assert limits('<limit lower="-1" upper="2"/>') == JointLimits(-1, 2)
    assert limits('<limit lower="2" upper="-1" effort="4" velocity="3"/>') == JointLimits(-1, 2, speed=3, torque=4)
    assert limits(LIMIT + LIMIT.replace("-1", "-9")) == JointLimits(-1, 2, speed=3, torque=4)
    damped = told(robot(*ARM[:2], joint("j", "a", "b", LIMIT + '<dynamics damping="-1" friction="2"/>')))[0]
    assert damped.joints[0].friction == Friction(0.0, 2.0, 2.0)
    axes = '<axis xyz="0 1 0"/><axis xyz="0 0 1"/>'
    turned = fk(told(robot(*ARM[:2], joint("j", "a", "b", LIMIT + axes)))[0], [0.5])
    np.testing.assert_allclose(turned[:3, :3] @ [0, 1, 0], [0, 1, 0], atol=1e-15)


def test_a_joint_that_follows_a_follower_follows_the_one_that_moves():
    follows = [LIMIT + f'<mimic joint="{joint}" multiplier="{m}" offset="{o}"/>' for joint, m, o in
               (("i", 2.0, 0.5), ("j", -3.0, 0.25))]  # fmt: skip
    model, notes = told(
        robot(
            *map(link, "abcd"), joint("i", "a", "b"), joint("j", "b", "c", follows[0]), joint("k", "c", "d", follows[1])
        )
    )
    assert "'k' mimics 'j', which mimics 'i'" in notes
    # q_k = -3 q_j + 0.25 = -3 (2 q_i + 0.5) + 0.25
    assert model.joints[2].mimic == Mimic(0, -6.0, -1.25)
    circle = [LIMIT + f'<mimic joint="{name}"/>' for name in "ji"]
    model, _ = told(robot(*map(link, "abc"), joint("i", "a", "b", circle[0]), joint("j", "b", "c", circle[1])))
    assert [j.mimic for j in model.joints] == [None, None]


def test_a_floating_joint_inside_a_tree_is_fixed_where_it_stands():
    free = joint("k", "b", "c", '<origin xyz="0 0 3"/>', "floating")
    model, notes = told(robot(*ARM, link("c"), free))
    assert "line 6: joint 'k' floats" in notes
    assert not model.floating
    np.testing.assert_array_equal(fk(model, [0.0])[:3, 3], [0, 0, 3])


MENDED = {
    "blank": ("\n\n<?xml version='1.0'?>", "", 1),
    "comment": ("", "<!-- a -- b --->", 5),
    "ampersand": ("", "<gazebo>a & b &amp; c</gazebo>", 5),
    "behind": ("", "</robot><robot>", 6),
}


@pytest.mark.parametrize("case", MENDED)
def test_xml_that_others_read_is_read(case):
    before, inside, line = MENDED[case]
    text = before + robot(*ARM, inside, joint("k", "b", "x", "", "fixed"), link("x"))
    if case == "behind":
        text = robot(*ARM, "", inside)
    model, notes = told(text)
    assert f"line {line}: not well-formed XML" in notes
    assert Arm(model).n == 1
    with pytest.raises(ModelError, match="not well-formed XML"):
        read_urdf(text, check="strict")
    again = text.replace("revolute", "ball")
    with pytest.raises(
        ModelError, match=f"line {again[: again.index('ball')].count(chr(10)) + 1}: joint 'j' has the unk"
    ):
        read_urdf(again)


def test_a_byte_order_mark_is_no_fault():
    assert read_urdf("\ufeff" + robot(*ARM)).notes == ()


FAULTY = {
    "not positive": inertia(ixy=2),
    "triangle": inertia(izz=2.1),
    "negative mass": inertia(-1),
    "no inertia": '<inertial><mass value="1"/></inertial>',
    "no moment": inertia().replace("ixy", "iyx"),
    "a word": inertia("heavy"),
}


@pytest.mark.parametrize("case", FAULTY)
def test_an_inertia_that_cannot_be_takes_the_dynamics_not_the_kinematics(case):
    model, _ = told(robot(ARM[0], link("b", FAULTY[case]), ARM[2]))
    assert model.bodies is None
    np.testing.assert_array_equal(fk(model, [0.0]), np.eye(4))
    with pytest.raises(MissingInertia, match=r"arm 'r' has kinematics only: URDF text, line \d+: "):
        inverse_dynamics(model, [0.0], [0.0], [0.0])
    base, notes = told(robot(link("a", FAULTY[case]), ARM[1], ARM[2]))  # it stands still: of no effect
    assert base.bodies is not None
    assert notes


def test_how_many_inertias_are_at_fault_is_said():
    links = [link(name, inertia(izz=9)) for name in "bcd"]
    model, _ = told(robot(link("a"), *links, joint("i", "a", "b"), joint("j", "b", "c"), joint("k", "c", "d")))
    assert model.no_inertia.startswith("URDF text, line 5: link 'b'")
    assert model.no_inertia.endswith("(and 2 more)")


@pytest.mark.parametrize(
    ("mass", "moments"),
    [
        (1.33687, {"ixx": 0, "iyy": 0, "izz": 0, "ixz": "2.40741e-35"}),  # the head of the iCub, as shipped
        (1.0, {"ixx": "0.333", "iyy": "0.333", "izz": "0.667"}),  # a plate, printed with three digits
        (1.0, {"ixx": "1.2345678e-3", "iyy": "1.2345678e-3", "izz": "2.4691357e-3"}),
        (1.0, {"ixx": "0.5", "iyy": "0.5", "izz": "1", "ixy": "0.5"}),  # a rod
    ],
)
def test_nothing_below_the_rounding_of_the_file_is_a_fault(mass, moments):
    model = read_urdf(robot(ARM[0], link("b", inertia(mass, **moments)), ARM[2]), check="strict")
    assert model.bodies is not None


def test_motors_under_actuator_transmission_and_joint():
    def motor(inside, more=""):
        start = '<transmission name="t">'
        model, notes = told(robot(*ARM[:2], joint("j", "a", "b", LIMIT + more), f"{start}{inside}</transmission>"))
        return model.joints[0].motor, notes

    gear, rotor = "<mechanicalReduction>50</mechanicalReduction>", "<motorInertia>1e-4</motorInertia>"
    assert motor(f'<joint name="j"/><actuator name="m">{gear}{rotor}</actuator>') == (Motor(50, 1e-4), "")
    assert motor(f'<joint name="j">{gear}{rotor}</joint><actuator name="m"/>') == (Motor(50, 1e-4), "")
    assert motor(f'<joint name="j">{gear}</joint><actuator name="m">{rotor}</actuator>') == (Motor(50, 1e-4), "")
    assert motor(f'<joint name="j"/>{gear}') == (Motor(50, 0.0), "")
    assert motor('<joint name="j"/>', rotor) == (Motor(1, 1e-4), "")
    other = gear.replace("50", "7")
    both, notes = motor(f'<joint name="j">{other}</joint><actuator name="m">{gear}</actuator>')
    assert both == Motor(50, 0.0)
    assert "line 5: <mechanicalReduction> is 7; <mechanicalReduction> of line 5, 50, is taken" in notes
    assert motor(f'<joint name="j"/><actuator name="m">{gear.replace("50", "fast")}</actuator>')[0] is None


def test_a_reduction_of_two_joints_is_named():
    two = '<transmission name="t"><joint name="i"/><joint name="j"/><mechanicalReduction>2</mechanicalReduction>'
    model, notes = told(robot(*map(link, "abc"), joint("i", "a", "b"), joint("j", "b", "c"), f"{two}</transmission>"))
    assert "transmission 't' drives 2 joints; its reduction is not read" in notes
    assert model.joints[0].motor is None


def test_the_way_to_check_is_one_of_two():
    with pytest.raises(UnknownName, match=r"no way to check a robot file .* 'loose'; there is strict, warn"):
        read_urdf(robot(*ARM), check="loose")


def test_a_link_of_no_size_whose_inertia_is_far_below_its_mass_is_read():
    """Slack follows mass times size squared: 1 kg with its centre 2 m off, moments of rounding."""
    moved = INERTIAL.replace("<mass", '<origin xyz="2 0 0"/><mass').replace('ixx="1"', 'ixx="-1e-12"')
    text = robot(ARM[0], link("b", moved.replace('iyy="1"', 'iyy="0"').replace('izz="1"', 'izz="0"')), ARM[2])
    assert read_urdf(text, check="strict").bodies is not None

"""What the URDF reader makes of a file, and every error: named by line, with what to do."""

from __future__ import annotations

import math
import re
import time

import numpy as np
import pytest
from float_arm import fk

from holonom.errors import InputError, ModelError, ModelWarning, UnknownName
from holonom.mechanics import Arm, load_arm
from holonom.model import Frame, Friction, JointLimits, Mimic, Motor, read_urdf

INERTIAL = '<inertial><mass value="2"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
LIMIT = '<limit lower="-1" upper="2" velocity="3" effort="4"/>'


def link(name, inside=""):
    return f'<link name="{name}">{inside}</link>'


def joint(name, parent, child, inside=LIMIT, kind="revolute"):
    return f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>{inside}</joint>'


def robot(*elements):
    """Each element on a line of its own, the first in line 2."""
    return '<robot name="r">\n' + "\n".join(elements) + "\n</robot>"


ARM = (link("a"), link("b", INERTIAL), joint("j", "a", "b"))


def test_a_joint_is_read_in_full():
    inside = (
        '<origin xyz="1 2 3" rpy="0 0 1.5707963268"/><axis xyz="0 0 2"/>'
        f'{LIMIT}<dynamics damping="0.5" friction="0.25"/>'
    )
    transmission = (
        '<transmission name="t"><joint name="j"/><actuator name="m"><mechanicalReduction>80</mechanicalReduction>'
        '<drake:rotor_inertia value="1e-4"/></actuator></transmission>'
    )
    model = read_urdf(robot(link("a"), link("b", INERTIAL), joint("j", "a", "b", inside), transmission))
    (only,) = model.joints
    assert (only.name, only.kind, only.parent) == ("j", "revolute", -1)
    assert only.before == ((0, -1, 0, 1), (1, 0, 0, 2), (0, 0, 1, 3), (0, 0, 0, 1))
    assert only.limits == JointLimits(-1, 2, speed=3, torque=4)
    assert only.friction == Friction(0.5, 0.25, 0.25)
    assert only.motor == Motor(80, 1e-4)
    assert model.bodies[0].mass == 2
    assert model.frames == (Frame("a", -1), Frame("b", 0))


def test_a_joint_turns_about_its_axis_wherever_it_points():
    for axis in ("0 1 0", "-1 0 0", "0 0 -3", "0.3 -0.5 0.2"):
        model = read_urdf(robot(*ARM[:2], joint("j", "a", "b", f'<axis xyz="{axis}"/>{LIMIT}')))
        unit = np.array(axis.split(), dtype=float)
        unit /= np.linalg.norm(unit)
        R = fk(model, [0.7])[:3, :3]
        np.testing.assert_allclose(R @ unit, unit, atol=1e-15)
        turned = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
        np.testing.assert_allclose(turned, unit * math.sin(0.7), atol=1e-15)


def test_fixed_links_become_frames_and_part_of_the_body():
    moved = INERTIAL.replace("<mass", '<origin xyz="0 0 1"/><mass')
    model = read_urdf(
        robot(
            *ARM,
            link("tool0", moved),
            joint("f", "b", "tool0", '<origin xyz="0 0 1"/>', "fixed"),
            link("camera"),
            joint("c", "a", "camera", '<origin xyz="0 5 0"/>', "fixed"),
        )
    )
    body = model.bodies[0]
    assert (body.mass, body.com) == (4, (0, 0, 1))  # 2 kg at 0, 2 kg at 1 + 1
    np.testing.assert_allclose(body.inertia, (6, 6, 2, 0, 0, 0))  # Steiner: 1 + 1 + 2 * 2 * 1^2
    frames = {frame.name: frame for frame in model.frames}
    assert frames["camera"].joint == -1
    assert frames["camera"].pose[1][3] == 5
    assert model.tool == frames["tool0"].pose
    np.testing.assert_array_equal(Arm(model).fk([0.0], frame="camera")[:3, 3], [0, 5, 0])


def test_joints_stand_behind_those_that_carry_them_else_in_document_order():
    model = read_urdf(
        robot(
            joint("j3", "c", "d"),
            joint("j1", "a", "b"),
            joint("j2", "b", "c"),
            joint("k", "a", "e"),
            *map(link, "abcde"),
        ),
        tip="d",
    )
    assert [(j.name, j.parent) for j in model.joints] == [("j1", -1), ("j2", 0), ("j3", 1), ("k", -1)]
    assert model.tip == 2


def test_continuous_prismatic_and_mimic_joints():
    follow = LIMIT + '<mimic joint="j1" multiplier="2" offset="0.5"/>'
    model = read_urdf(
        robot(
            *map(link, "abcd"),
            joint("j0", "a", "b", "", "continuous"),
            joint("j1", "b", "c", LIMIT, "prismatic"),
            joint("j2", "c", "d", follow),
        )
    )
    assert [j.kind for j in model.joints] == ["revolute", "prismatic", "revolute"]
    assert model.joints[0].limits == JointLimits()
    assert model.joints[2].mimic == Mimic(1, 2, 0.5)
    assert Arm(model).n == 2
    assert model.bodies is None


@pytest.mark.parametrize(
    ("names", "tip"),
    [
        ("left_tool0 finger", "left_tool0"),
        ("gripper_tcp tool0", "gripper_tcp"),
        ("ee_link tool0", "tool0"),
        ("hand finger", "hand"),
    ],
)
def test_the_tool_is_the_link_that_is_called_so(names, tip):
    hands = names.split()
    fixed = [joint(f"f{name}", "b", name, f'<origin xyz="0 0 {k + 1}"/>', "fixed") for k, name in enumerate(hands)]
    model = read_urdf(robot(*ARM, *map(link, hands), *fixed))
    assert model.tool[2][3] == hands.index(tip) + 1
    assert repr(Arm(model)) == f"Arm('r', n=1, tool={tip!r})"
    assert repr(Arm(model).with_tool(np.eye(4))) == "Arm('r', n=1)"


def test_a_tool_that_nothing_is_called_like_is_a_guess_that_is_told():
    fixed = [joint(f"f{name}", "b", name, f'<origin xyz="0 0 {k}"/>', "fixed") for k, name in enumerate(("catcp", "x"))]
    text = robot(*ARM, link("catcp"), link("x"), *fixed)
    told = r"line 5: no link is called like a tool: 'catcp' is taken .* say which link it is with tip= .*catcp, x\)"
    with pytest.warns(ModelWarning, match=told):
        assert read_urdf(text).tool_frame == "catcp"
    assert read_urdf(text, tip="x").notes == ()


def test_a_hand_not_its_finger_is_the_tool():
    links = list(map(link, ("plate", "left", "right", "left_end")))
    hand = joint("h", "b", "plate", '<origin xyz="0 0 5"/>', "fixed")
    fingers = joint("l", "plate", "left"), joint("r", "plate", "right", LIMIT + '<mimic joint="l"/>')
    end = joint("e", "left", "left_end", "", "continuous")
    with pytest.warns(ModelWarning, match="'plate' is taken for the tool, a guess"):
        model = read_urdf(robot(*ARM, *links, hand, *fingers, end))
    assert (model.tip, model.tool[2][3]) == (0, 5)
    longer = link("nail"), joint("m", "left_end", "nail", "", "continuous")
    with pytest.warns(ModelWarning, match="'nail' is taken for the tool, a guess"):
        assert read_urdf(robot(*ARM, *links, hand, *fingers, end, *longer)).tip == 4


def test_root_and_tip_are_links_of_choice():
    text = robot(*map(link, "abcd"), joint("j1", "a", "b"), joint("j2", "b", "c"), joint("j3", "c", "d"))
    model = read_urdf(text, root="b", tip="c")
    assert [j.name for j in model.joints] == ["j2", "j3"]
    assert model.tip == 0
    with pytest.raises(UnknownName, match="no link 'e'"):
        read_urdf(text, tip="e")
    with pytest.raises(UnknownName, match="no link 'e'"):
        read_urdf(text, root="e")
    for tip in ("a", "b"):
        with pytest.raises(ModelError, match="not moved by any joint"):
            read_urdf(text, root="b", tip=tip)


def test_meshes_are_not_opened():
    mesh = '<visual><geometry><mesh filename="package://nowhere/absent.stl"/></geometry></visual>'
    assert read_urdf(robot(link("a", mesh), link("b"), ARM[2])).name == "r"


def test_files(tmp_path):
    file = tmp_path / "arm.urdf"
    file.write_bytes(
        ('<?xml version="1.0" encoding="latin-1"?>' + robot(*ARM)).replace('"j"', '"jö"').encode("latin-1")
    )
    assert load_arm(file).model.joints[0].name == "jö"
    assert load_arm(str(file), tip="b").n == 1
    with pytest.raises(ModelError, match=r"absent\.urdf: cannot be read: No such file"):
        load_arm(tmp_path / "absent.urdf")
    with pytest.raises(InputError, match="packages= and arguments= are for xacro"):
        load_arm(file, packages={"p": tmp_path})
    with pytest.raises(InputError, match="are for files"):
        load_arm("puma560", tip="b")
    with pytest.raises(UnknownName, match=r"nor a file ending in \.urdf, \.xml, \.xacro"):
        load_arm("arm.txt")


def inertia(mass=1.0, **moments):
    values = {"ixx": 1, "iyy": 1, "izz": 1, "ixy": 0, "ixz": 0, "iyz": 0} | moments
    stated = " ".join(f'{key}="{value}"' for key, value in values.items())
    return f'<inertial>\n<mass value="{mass}"/>\n<inertia {stated}/></inertial>'


BAD = {
    "not XML": ("<robot", 1, "not well-formed XML"),
    "text after": (robot(*ARM) + "<robot/>", 5, "junk after document element"),
    "not a robot": ("<sdf/>", 1, "a URDF is a <robot>"),
    "no name": ("<robot><link/></robot>", 1, "<link> needs name="),
    "doctype": ("<!DOCTYPE robot SYSTEM 'x.dtd'><robot/>", 1, "DOCTYPE robot.*delete it"),
    "bomb": ('<!DOCTYPE r [\n<!ENTITY a "&#38;b;&#38;b;">]>\n<robot name="&a;"/>', 1, "entities"),
    "deep": ("<robot>" + "<a>" * 100 + "</a>" * 100 + "</robot>", 1, "more than 64 levels"),
    "xacro": (robot("<xacro:include/>"), 2, "this is xacro"),
    "no links": ('<robot name="r"></robot>', None, "no <link>"),
    "no joint": (robot(link("a")), 1, "no joint below link 'a' moves"),
    "all fixed": (robot(*ARM[:2], joint("j", "a", "b", "", "fixed")), 1, "no joint below link 'a' moves"),
    "second link": (robot(*ARM, link("a")), 5, "a second link 'a'; the first is in line 2"),
    "second joint": (robot(*ARM, link("c"), joint("j", "b", "c")), 6, "a second joint 'j'; the first is in line 4"),
    "unknown parent": (robot(*ARM[:2], joint("j", "x", "b")), 4, "unknown parent: no link 'x'; there is a, b"),
    "unknown child": (robot(*ARM[:2], joint("j", "a", "x")), 4, "unknown child: no link 'x'; there is a, b"),
    "no parent": (robot(*ARM[:2], '<joint name="j" type="fixed"/>'), 4, "joint 'j' has no <parent>"),
    "two roots": (robot(*ARM, link("c")), 5, r"more than one root: no joint carries 'a' \(line 2\), 'c' \(line 5\)"),
    "no root": (robot(*ARM, joint("k", "b", "a")), 4, "joint 'j' is part of a loop"),
    "ring apart": (
        robot(*ARM, link("c"), link("d"), joint("k", "c", "d"), joint("l", "d", "c")),
        7,
        "joint 'k' is part of a loop",
    ),
    "closed chain": (
        robot(*ARM, link("c"), joint("k", "b", "c"), joint("l", "a", "c")),
        7,
        r"link 'c' is carried by joint 'k' \(line 6\) and by 'l': a closed chain",
    ),
    "carries itself": (robot(*ARM, joint("k", "b", "b")), 5, "closed chain"),
    "type": (robot(*ARM[:2], joint("j", "a", "b", LIMIT, "revolut")), 4, "did you mean 'revolute'"),
    "no type": (robot(*ARM[:2], '<joint name="j"/>'), 4, "<joint> needs type="),
    "only floating": (robot(*ARM[:2], joint("j", "a", "b", "", "floating")), 1, "no joint below link 'a' moves"),
    "no limits": (robot(*ARM[:2], joint("j", "a", "b", "")), 4, "no position limits.*continuous"),
    "no slide limits": (robot(*ARM[:2], joint("j", "a", "b", "", "prismatic")), 4, "prismatic and states no position"),
    "no position": (
        robot(*ARM[:2], joint("j", "a", "b", '\n<limit effort="1" velocity="1"/>')),
        5,
        "states no position limits",
    ),
    "no effort": (robot(*ARM[:2], joint("j", "a", "b", '<limit lower="0" velocity="1"/>')), 4, "needs effort="),
    "swapped": (robot(*ARM[:2], joint("j", "a", "b", LIMIT.replace("-1", "5"))), 4, "5.0 above the upper 2.0; swap"),
    "speed": (robot(*ARM[:2], joint("j", "a", "b", LIMIT.replace("3", "-3"))), 4, "velocity -3.0 and effort 4.0"),
    "axis": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + '\n<axis xyz="0 0 0"/>')), 5, "has no direction"),
    "two numbers": (robot(*ARM[:2], joint("j", "a", "b", '<axis xyz="0 0"/>')), 4, 'xyz="0 0": three numbers'),
    "nan": (robot(*ARM[:2], joint("j", "a", "b", LIMIT.replace("-1", "nan"))), 4, 'lower="nan": a finite number'),
    "garbage": (robot(*ARM[:2], joint("j", "a", "b", LIMIT.replace("-1", "1_0"))), 4, 'lower="1_0": a finite number'),
    "huge": (robot(*ARM[:2], joint("j", "a", "b", LIMIT.replace("-1", "-1e999"))), 4, "a finite number"),
    "damping": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + '<dynamics damping="-1"/>')), 4, "damping -1.0"),
    "misspelt": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + '<orgin xyz="0 0 1"/>')), 4, "did you mean <origin>"),
    "twice": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + LIMIT)), 4, "has a second <limit>"),
    "mimic": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + '<mimic joint="x"/>')), 4, "mimics an unknown joint: .*'x'"),
    "mimic itself": (robot(*ARM[:2], joint("j", "a", "b", LIMIT + '<mimic joint="j"/>')), 4, "which mimics 'j'"),
    "fixed mimic": (
        robot(*ARM[:2], joint("j", "a", "b", '<mimic joint="x"/>', "fixed")),
        4,
        "is fixed and cannot mimic",
    ),
    "mimic chain": (
        robot(
            *map(link, "abcd"),
            joint("i", "a", "b"),
            joint("j", "b", "c", LIMIT + '<mimic joint="i"/>'),
            joint("k", "c", "d", LIMIT + '<mimic joint="j"/>'),
        ),
        8,
        "'k' mimics 'j', which mimics 'i'; name the joint that moves on its own",
    ),
    "mass": (robot(link("a", inertia(-1)), *ARM[1:]), 3, "the mass is -1.0 kg"),
    "no mass": (robot(link("a", "<inertial/>"), *ARM[1:]), 2, "<inertial> has no <mass>"),
    "no inertia": (robot(link("a", '<inertial><mass value="1"/></inertial>'), *ARM[1:]), 2, "has no <inertia>"),
    "missing moment": (robot(link("a", inertia().replace("ixy", "iyx")), *ARM[1:]), 4, "needs ixy="),
    "not positive": (robot(link("a", inertia(ixy=2)), *ARM[1:]), 4, "link 'a' has an inertia that is not positive"),
    "triangle": (robot(link("a", inertia(izz=2.1)), *ARM[1:]), 4, "link 'a' has an inertia that no body has"),
    "massless": (robot(ARM[0], link("b", inertia(0)), ARM[2]), 4, "link 'b' has no mass, but an inertia"),
    "transmission": (
        robot(*ARM, '<transmission name="t"><joint name="x"/></transmission>'),
        5,
        "transmission 't' drives an unknown joint: no joint 'x'",
    ),
    "gear": (
        robot(
            *ARM, '<transmission name="t"><joint name="j"/><mechanicalReduction>0</mechanicalReduction></transmission>'
        ),
        5,
        "a gear ratio is not 0",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_files_are_refused_by_line(case):
    text, line, message = BAD[case]
    with pytest.raises(ModelError, match=f"(?s){message}") as caught:
        read_urdf(text, check="strict")
    where = "URDF text: " if line is None else f"URDF text, line {line}[:,]"
    assert re.match(where, str(caught.value)), str(caught.value)


def test_a_bomb_takes_no_time_and_a_large_file_is_not_read():
    entities = "".join(f'<!ENTITY a{k} "{f"&a{k - 1};" * 10}">' for k in range(1, 30))
    start = time.perf_counter()
    with pytest.raises(ModelError, match="document type"):
        read_urdf(f'<!DOCTYPE r [<!ENTITY a0 "x">{entities}]><robot name="&a29;"/>')
    assert time.perf_counter() - start < 1.0
    with pytest.raises(ModelError, match="at most 16777216 are read"):
        read_urdf("<robot>" + " " * 2**24)


def test_impossible_inertia_can_be_asked_for():
    text = robot(ARM[0], link("b", inertia(izz=2.1)), ARM[2])
    with pytest.warns(ModelWarning, match="no body has"):
        assert read_urdf(text, check_inertia="warn").bodies[0].inertia[2] == 2.1
    assert read_urdf(text, check_inertia=False).bodies[0].inertia[2] == 2.1


def test_an_inertia_without_mass_counts_where_it_is_asked_for():
    """As in the file of the Franka Panda that pybullet ships: a link without mass, fixed to the last one."""
    fixed = (
        '<joint name="f" type="fixed"><parent link="b"/><child link="c"/><origin rpy="0 0 1.5707963267948966"/></joint>'
    )
    text = robot(link("a"), link("b", inertia(2.0)), link("c", inertia(0.0, ixx=0.5)), joint("j", "a", "b"), fixed)
    with pytest.raises(ModelError, match="link 'c' has no mass, but an inertia"):
        read_urdf(text, check="strict")
    (body,) = read_urdf(text, check_inertia=False).bodies
    np.testing.assert_allclose([body.mass, *body.inertia[:3]], [2.0, 2.0, 1.5, 2.0], rtol=0.0, atol=1e-15)
    assert read_urdf(robot(ARM[0], link("b", inertia(izz=2.0)), ARM[2])).bodies[0].inertia[2] == 2.0

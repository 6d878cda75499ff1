"""Which link is the tool, where a file does not say: on robots as shipped, by what their makers call the tool."""

from __future__ import annotations

import warnings
from pathlib import Path

import pytest
from shipped import shipped_robots
from test_urdf import ARM, LIMIT, joint, link, robot

from holonom.errors import ModelWarning
from holonom.mechanics import load_arm
from holonom.model import read_urdf

TOOLS = {
    "ur3_robot": "tool0", "ur5_robot": "tool0", "ur10_robot": "tool0", "ur3_gripper": "tool0",
    "irb140": "tool0", "irb140QT": "tool0", "kr210l150": "tool0", "kr16_2": "tool0", "kr120r2500pro": "tool0",
    "lbr_iiwa_14_r820": "tool0", "panda": "panda_hand_tcp", "panda_collision": "panda_hand_tcp", "xarm7": "link_eef",
    "kinova": "j2s6s200_end_effector", "anymal-kinova": "j2s6s200_end_effector", "so100": "gripper",
    "z1": "gripperStator", "borinot_flying_arm_2": "flying_arm_2__ee", "hextilt_flying_arm_5": "flying_arm_5__gripper",
}  # fmt: skip
"""What the tool's frame is in the makers' drivers and planning set-ups."""
NO_TOOL = ("camera", "optical", "wheel", "finger", "thumb", "_sc", "imu", "rotor")
ONLY_SUCH = {"iris", "finger_edu"}
"""Robots of which nothing else moves."""


@pytest.mark.parametrize("name", sorted(TOOLS))
def test_tools_of_arms_as_shipped(name, shipped):
    for file in shipped(name):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            arm = load_arm(file)
        assert arm.model.tool_frame == TOOLS[name]
        assert f"tool={TOOLS[name]!r}" in repr(arm)


@pytest.fixture
def shipped(data_folder):
    found = shipped_robots(data_folder)

    def named(name: str) -> list[Path]:
        files = [file for file in found if file.stem == name]
        if not files:
            pytest.skip(
                f"no {name}.urdf: neither in the data folder nor by the packages example-robot-data and rtb-data"
            )
        return files

    return named


def test_no_shipped_robot_gets_a_camera_a_wheel_or_a_finger(data_folder):
    for file in shipped_robots(data_folder):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            try:
                model = read_urdf(file)
            except ValueError:  # nothing in it moves
                continue
        assert not any(word in model.tool_frame.lower() for word in NO_TOOL) or file.stem in ONLY_SUCH, file.name


def chain(*names, start=ARM):
    """Links fixed one by one to the end of an arm, 0.1 m apart."""
    links = list(map(link, names))
    fixed = [
        joint(f"to_{name}", "b", name, f'<origin xyz="0 0 {0.1 * (k + 1)}"/>', "fixed") for k, name in enumerate(names)
    ]
    return robot(*start, *links, *fixed)


@pytest.mark.parametrize(
    ("names", "tool"),
    [
        ("end_effector_link camera_link camera_depth_frame camera_color_frame tool_frame", "tool_frame"),  # Kinova gen3
        ("fr3_link7_sc fr3_link8 fr3_link8_sc", "fr3_link8"),  # Franka fr3 without a hand
        ("fr3_link8 fr3_hand fr3_hand_sc fr3_hand_tcp fr3_leftfinger", "fr3_hand_tcp"),
        ("EndEffector_Link", "EndEffector_Link"),
        ("iiwa_link_ee iiwa_link_ee_kuka", "iiwa_link_ee"),
        ("link_grasp_center link_wrist", "link_grasp_center"),
        ("WristYawIMULink plate", "plate"),
        ("gripper_left_wheel_link laser_scan0 body_end", "body_end"),
        ("panda_grasptarget panda_hand", "panda_grasptarget"),
    ],
)
def test_names_of_tools(names, tool):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ModelWarning)
        assert read_urdf(chain(*names.split())).tool_frame == tool


def test_two_that_are_called_alike_are_a_guess():
    text = chain("left_tool0", "right_tool0")
    with pytest.warns(ModelWarning, match=r"several links are called like a tool: 'left_tool0' .*left_tool0, right_"):
        read_urdf(text)
    same = text.replace('xyz="0 0 0.2"', 'xyz="0 0 0.1"')
    assert read_urdf(same).notes == ()  # in one place


def test_one_end_is_no_guess_and_a_jaw_on_a_gripper_no_tool():
    assert read_urdf(chain("plate")).notes == ()
    with pytest.warns(ModelWarning, match="'gripper_base' is taken"):
        read_urdf(robot(*ARM, link("gripper_base"), link("mover"), joint("f", "b", "gripper_base", "", "fixed"),
                        joint("m", "gripper_base", "mover", LIMIT)))  # fmt: skip


def test_where_only_fingers_move_one_is_the_tool():
    with pytest.warns(ModelWarning, match="'left_finger' is taken for the tool, a guess"):
        read_urdf(robot(link("palm"), link("left_finger"), link("right_finger"), joint("l", "palm", "left_finger"),
                        joint("r", "palm", "right_finger")))  # fmt: skip

"""Every arm and every arrangement of wheels in a cell: read, built, drawn, checked."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from cell_files import ABOUT, built, drawn, write

from holonom import load_arm
from holonom.app.cell import load_cell
from holonom.app.cell.build.job import refuse_unsimulated
from holonom.app.cell.check import check_cell
from holonom.app.report import Box
from holonom.app.report.attachments import cell_facts
from holonom.app.rig.wheel_frames import wheel_frames, wheel_poses
from holonom.errors import CellError
from holonom.mechanics import Arm
from holonom.mobile.methods import ARRANGEMENTS
from holonom.model import preset_names

URDFS = (
    "example_robot_data/ur10_robot.urdf", "example_robot_data/ur3_robot.urdf", "example_robot_data/ur5_robot.urdf",
    "pybullet/model.urdf", "rtb_data/al5d_robot.urdf", "rtb_data/irb140.urdf", "rtb_data/kr210l150.urdf",
    "rtb_data/lbr_iiwa_14_r820.urdf", "rtb_data/puma560_robot.urdf",
)  # fmt: skip


@pytest.mark.parametrize("name", [*preset_names(), *URDFS])
def test_every_arm_is_built_and_drawn(name: str, tmp_path: Path, data_folder: Path) -> None:
    source = str(data_folder / "robots" / "urdf" / name) if "/" in name else name
    path = write(tmp_path, f"{ABOUT}[[robot]]\nmodel = '{source}'\nprogram = 'wave.arps'\n")
    job = built(path)
    arm, model = job.arms[0], load_arm(source)
    assert (arm.drives == "ideal") == (model.model.bodies is None or bool("ideal" in "".join(job.notes)))
    limits = arm.arm.limits
    assert (limits.speed > 0.0).all()
    assert np.isfinite([limits.speed, limits.acceleration]).all()
    assert (limits.acceleration > 0.0).all()
    assert ((limits.lower <= arm.home) & (arm.home <= limits.upper)).all()
    np.testing.assert_allclose(arm.arm.fk(arm.home), model.fk(arm.home), atol=1e-12)
    drawn(job)
    frames = [shape.frame for shape in job.scene.shapes]
    assert {f"link{i + 1}" for i in range(model.n)} <= {*frames, "link6" if name == "puma560" else ""}
    answer = check_cell(path)
    assert answer.data["motions"] == 2
    assert answer.data["drives"] == arm.drives


@pytest.mark.parametrize("name", [name for name in URDFS if "puma" not in name])
def test_tubes_reach_from_joint_to_joint(name: str, tmp_path: Path, data_folder: Path) -> None:
    """What is drawn of an arm goes where its links go: bars end where the next joint is, at any pose."""
    source = data_folder / "robots" / "urdf" / name
    job = built(write(tmp_path, f"{ABOUT}[[robot]]\nmodel = '{source}'\ndrives = 'ideal'\n"))
    arm = Arm(load_arm(source).model)
    frames = arm.frames(np.linspace(-0.4, 0.5, arm.n))
    axes = {i: frames[i + 1][:3, 3] for i in range(arm.n)}  # of URDF links: the joint's own place
    for shape in job.scene.shapes:
        if shape.frame.startswith("link") and getattr(shape, "rounded", False):
            i = int(shape.frame[4:]) - 1
            T = frames[i + 1]
            start, end = (T[:3, :3] @ np.array(p) + T[:3, 3] for p in (shape.start, shape.end))
            np.testing.assert_allclose(start, axes[i], atol=1e-9)
            if i + 1 < arm.n:
                np.testing.assert_allclose(end, axes[i + 1], atol=1e-9)


@pytest.mark.parametrize("name", ["ur5e", "scara", "three_joint"])
def test_tubes_reach_from_frame_to_frame(name: str, tmp_path: Path) -> None:
    """With standard Denavit-Hartenberg frames a link goes from the frame before its own to its own, or to the tool."""
    job = built(write(tmp_path, f"{ABOUT}[[robot]]\nmodel = '{name}'\ndrives = 'ideal'\n"))
    arm = load_arm(name)
    frames = arm.frames(np.linspace(0.1, 0.15, arm.n))
    bars = [shape for shape in job.scene.shapes if shape.frame.startswith("link") and getattr(shape, "rounded", False)]
    assert bars
    for bar in bars:
        i = int(bar.frame[4:])
        T = frames[i]
        start, end = (T[:3, :3] @ np.array(p) + T[:3, 3] for p in (bar.start, bar.end))
        if arm.model.joints[i - 1].kind == "revolute" and bar.colour == "#eef1f5":
            np.testing.assert_allclose(start, frames[i - 1][:3, 3], atol=1e-9)
            assert min(np.linalg.norm(end - frames[k][:3, 3]) for k in (i, -1)) < 1e-9


EXTRA = {"omni": "n = 3\n", "swerve": 'wheelbase = "0.4m"\ntrack = "0.3m"\n'}
HEIGHTS = {"segway": "300mm"}


def base_text(kind: str, drives: str = "") -> str:
    required = [field for field in ARRANGEMENTS[kind].fields if field.required]
    keys = "".join(f'{field.name} = "{field.parameter.example}m"\n' for field in required)
    return (
        f'{ABOUT}[[robot]]\narrangement = "{kind}"\nmass = "20kg"\nheight = "{HEIGHTS.get(kind, "10mm")}"\n'
        f"{keys}{EXTRA.get(kind, '')}{drives}"
    )


@pytest.mark.parametrize("kind", ARRANGEMENTS)
def test_every_arrangement_is_read_built_and_drawn(kind: str, tmp_path: Path) -> None:
    path = write(tmp_path, base_text(kind))
    cell, job = load_cell(path), built(path)
    base = job.bases[0]
    assert base.base.name == kind
    drawn(job)
    shapes = [shape for shape in job.scene.shapes if shape.frame != "world"]
    assert len(shapes) >= 4 + len(base.base.wheels)
    refuse_unsimulated(cell, path)
    assert set(wheel_frames(base.base)) <= {shape.frame for shape in shapes}
    assert "note: " + kind not in check_cell(path).text.replace("no motors", "") or "cannot" not in "".join(job.notes)


def test_wheels_one_by_one(tmp_path: Path) -> None:
    path = write(
        tmp_path,
        f"""{ABOUT}[[robot]]
mass = "20kg"
wheels = [
  {{ kind = "fixed", x = "0m", y = "0.2m", radius = "80mm", driven = true, name = "left" }},
  {{ kind = "fixed", x = "0m", y = "-0.2m", radius = "80mm", driven = true, name = "right" }},
  {{ kind = "spherical", x = "0.2m", y = "0m", radius = "20mm" }},
]
""",
    )
    base = built(path).bases[0].base
    assert base.driven == ("left", "right")
    np.testing.assert_allclose(base.wheel_speeds([0.8, 0.0, 0.0]), [10.0, 10.0])
    text = path.read_text("utf-8").replace(
        'kind = "spherical", x = "0.2m", y = "0m", radius = "20mm"',
        'kind = "spherical", x = "0.2m", y = "0m", radius = "20mm", driven = true',
    )
    with pytest.raises(CellError, match=r"cell.toml:6: robot\[0\].wheels: these wheels cannot be simulated yet"):
        refuse_unsimulated(load_cell(write(tmp_path, text)), path)


@pytest.mark.parametrize("kind", ["differential", "omni", "mecanum"])
@pytest.mark.parametrize("drives", ['drives = "ideal"\n', 'drives = "from_limits"\n', ""])
def test_drives_of_a_base_reach_its_limits(kind: str, drives: str, tmp_path: Path) -> None:
    limits = '[robot.limits]\nspeed = "1.5m/s"\nacceleration = "1.2m/s2"\n'
    job = built(write(tmp_path, base_text(kind, drives + limits)))
    base = job.bases[0]
    assert base.drives == ("ideal" if "ideal" in drives else "from_limits")
    assert len(job.notes) == (0 if drives else 1)
    fastest = np.abs(base.base.wheel_speeds([1.5, 0.0, 0.0])).max()
    motor = base.drive.motor
    assert motor.no_load_speed / base.drive.gear.ratio >= 1.3 * fastest * (1 - 1e-12)
    force = motor.torque_constant * motor.max_current * base.drive.gear.ratio * len(base.base.driven)
    assert force / base.base.wheel_radii.max() == pytest.approx(1.5 * 2.0 * 20.0 * 1.2)


def test_a_castor_on_the_line_of_the_axle_carries_nothing_and_the_path_is_checked(tmp_path: Path) -> None:
    """The load of a castor behind an axle that bears all of the mass is 0 give or take an ulp."""
    way = 'path = { shape = "waypoints", points = [["0m", "0m"], ["1m", "0m"]], '
    way += 'speed = "0.5m/s", acceleration = "0.3m/s2" }'
    for track in ("300mm", "400mm", "700mm"):
        wheels = f'arrangement = "differential"\ntrack = "{track}"\nwheel_radius = "80mm"\nmass = "60kg"\n'
        assert check_cell(write(tmp_path, f"{ABOUT}[[robot]]\n{wheels}{way}\n")).data["warnings"] == []


def test_controllers_of_ideal_joints_are_said_to_do_nothing(tmp_path: Path) -> None:
    laws = "controllers = ['cascade', 'computed_torque']\n"
    job = built(write(tmp_path, f"{ABOUT}[[robot]]\nmodel = 'ur5e'\ndrives = 'ideal'\n{laws}hold = '1s'\n"))
    assert len(job.arms[0].settings) == 1
    assert "ur5e: its controllers do nothing: ideal joints follow their commands" in job.notes


def test_several_arms_run_under_one_controller_each_and_say_so(tmp_path: Path) -> None:
    arms = "[[robot]]\nname = 'a'\nmodel = 'ur5e'\ncontrollers = ['cascade', 'computed_torque']\nhold = '1s'\n"
    arms += "[[robot]]\nname = 'b'\nmodel = 'ur5e'\npose = ['2m', '0m', '0m', '0deg', '0deg', '0deg']\nhold = '1s'\n"
    notes = built(write(tmp_path, f"{ABOUT}{arms}")).notes
    assert "a: it runs under computed torque only; controllers are compared in cells of one arm" in notes


def test_limits_that_say_nothing_about_a_path_are_named(tmp_path: Path) -> None:
    way = 'path = { shape = "circle", size = "1m", speed = "0.5m/s", acceleration = "0.3m/s2" }\n'
    limits = 'limits = { speed = "1m/s", jerk = "1m/s3", timeout = "1s" }\n'
    notes = built(write(tmp_path, base_text("omni") + way + limits)).notes
    assert any(note.endswith("limits of jerk, timeout are of velocities, not of a path") for note in notes)


def test_levels_that_are_slow_slow_the_law_down_and_say_so(tmp_path: Path) -> None:
    levels = "{ supervisor = '100ms', model = '10ms', servo = '1ms' }"
    job = built(write(tmp_path, f"{ABOUT}[[robot]]\nmodel = 'puma560'\nlevels = {levels}\nprogram = 'wave.arps'\n"))
    assert job.arms[0].settings[0].bandwidth == pytest.approx(10.0)
    assert any("bandwidth of its computed torque is 10 rad/s" in note for note in job.notes)


@pytest.mark.parametrize("kind", ARRANGEMENTS)
def test_the_deck_covers_the_wheels_and_the_frame_on_it(kind: str, tmp_path: Path) -> None:
    job = built(write(tmp_path, base_text(kind)))
    base = job.bases[0]
    own = [shape for shape in job.scene.shapes if shape.frame in ("base_link", "body")]
    boxes = [shape for shape in own if isinstance(shape, Box)]
    top, overview = base.frames["top"][2, 3], job.scene.views[0]
    if len(boxes) > 1:  # a base that is longer than wide, and no mark alone
        plate = boxes[1]
        middle, half = plate.pose[:2, 3], 0.5 * np.array(plate.size[:2])
        assert any(box.pose[2, 3] + 0.5 * box.size[2] == pytest.approx(top) for box in boxes)
        assert all((np.abs(middle - (w.x, w.y)) <= half + 1e-9).all() for w in base.base.wheels)
        size = float(half.max())
    else:
        deck = max((shape for shape in own if hasattr(shape, "end")), key=lambda shape: shape.end[2])
        middle, size = np.array(deck.end[:2]), deck.radius
        assert top == pytest.approx(deck.end[2])
        assert all(np.hypot(*(middle - (w.x, w.y))) < size for w in base.base.wheels)
    assert np.linalg.norm(middle) < size
    assert np.linalg.norm(np.array(overview.eye) - overview.target) > 2.0 * size


POSES = 'poses = [["0m", "0m", "0deg"], ["0m", "0.8m", "0deg"]], radius = "0.6m", '
SPEEDS = 'speed = "0.5m/s", acceleration = "0.3m/s2"'


def pose_path(shape: str, keys: str) -> str:
    return base_text("differential") + f'path = {{ shape = "{shape}", {keys} {SPEEDS} }}\n'


@pytest.mark.parametrize("shape", ["dubins", "reeds_shepp"])
def test_a_path_from_pose_to_pose_is_planned_along_its_tangent(shape: str, tmp_path: Path) -> None:
    file = write(tmp_path, pose_path(shape, POSES + 'origin = ["1m", "2m"],'))
    assert check_cell(file).data["warnings"] == []
    path = built(file).bases[0].task.path
    np.testing.assert_allclose(path.pose[[0, -1], :2], [[1.0, 2.0], [1.0, 2.8]], atol=1e-9)
    assert not path.twist[:, 1].any()
    assert (path.twist[:, 0].min() < 0.0) == (shape == "reeds_shepp")


@pytest.mark.parametrize(
    ("shape", "keys", "message"),
    [
        ("dubins", 'size = "1m",', "takes poses and radius and no points or size"),
        ("reeds_shepp", POSES + 'heading = "fixed",', "takes its headings from its poses"),
        ("circle", 'size = "1m", radius = "1m",', "takes size and no points or poses or radius"),
        ("dubins", POSES.replace("0.6m", "0m"), "radius"),
        ("dubins", POSES.replace("0.8m", "0m"), "all the same"),
    ],
)
def test_a_path_from_pose_to_pose_that_is_none_is_refused(shape: str, keys: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(CellError, match=message):
        built(write(tmp_path, pose_path(shape, keys)))


def test_driven_castors_are_built_and_drawn_where_they_touch_the_floor(tmp_path: Path) -> None:
    """Without `[steering]` their motors swing them fast enough for the base's speed."""
    wheels = ", ".join(
        f'{{ kind = "castor", x = "{x}m", y = "{y}m", heading = "180deg", radius = "50mm", castor_offset = "40mm", '
        "driven = true }"
        for x, y in ((0.2, 0.0), (-0.1, 0.17), (-0.1, -0.17))
    )
    limits = '[robot.limits]\nspeed = "1m/s"\nacceleration = "1m/s2"\n'
    job = built(write(tmp_path, f'{ABOUT}[[robot]]\nmass = "8kg"\nwheels = [{wheels}]\n{limits}'))
    drawn(job)
    base = job.bases[0]
    assert base.drive.steering.max_rate > 1.0 / 0.04
    turned = np.array([0.5, -1.0, 2.0])
    frames = wheel_poses(base.base, np.eye(4), np.zeros(3), turned)
    for wheel, angle, T in zip(base.base.wheels, turned, frames, strict=True):
        heading = wheel.heading + angle
        expected = [wheel.x + 0.04 * np.cos(heading), wheel.y + 0.04 * np.sin(heading), 0.05]
        assert T[:3, 3] == pytest.approx(expected)


def test_steps_of_the_floor_are_drawn(tmp_path: Path) -> None:
    step = '[[floor.steps]]\nposition = ["2m", "1m"]\nheight = "15mm"\nrise = "90deg"\n'
    job = built(write(tmp_path, base_text("differential") + step))
    (found,) = cell_facts(job).steps
    corners = np.array(found.corners)
    assert found.name == "step, 15 mm"
    assert corners[:, 1].min() == pytest.approx(1.0)  # it begins at the edge, across the way
    assert np.ptp(corners[:, 0]) > 2.0 * max(abs(w.y) for w in job.bases[0].base.wheels)
    assert corners[:, 0].mean() == pytest.approx(2.0)
    assert any(getattr(shape, "text", "") == found.name for shape in job.scene.shapes)

"""One cell model: every key in SI, short forms and long ones alike."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from cell_files import ABOUT, CELLS, built, write

from holonom import load_arm
from holonom.app.cell import Cell, cell_schema, load_cell
from holonom.app.cell.model.short import SHORT
from holonom.app.job import Job
from holonom.errors import CellError
from holonom.geometry import Box, Cylinder

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return load_cell(CELLS / "all_keys.toml")


@pytest.fixture(scope="module")
def job() -> Job:
    return built(CELLS / "all_keys.toml")


def test_every_key_of_an_arm(cell: Cell, job: Job) -> None:
    robot, arm = cell.robot[0], job.arms[0]
    assert (arm.name, arm.drives, arm.entry) == ("puma", "motors", "wave")
    assert robot.home == pytest.approx([0, math.pi / 4, -math.pi, 0, -math.pi / 4, 0])
    assert [s.controller for s in arm.settings] == ["cascade", "computed_torque"]
    assert arm.settings[1].law_bandwidth == 8.0
    levels = arm.settings[0].levels
    assert (levels.supervisor, levels.model, levels.servo, levels.delay, levels.interpolation) == (
        0.1, 0.01, 0.001, 0.002, "cubic",
    )  # fmt: skip
    assert arm.settings[0].following_error == pytest.approx(math.radians(3))
    assert (arm.line.speed, arm.line.acceleration) == (0.4, 3.0)
    nominal = load_arm("puma560").limits
    np.testing.assert_allclose(arm.arm.limits.speed, 0.5 * nominal.speed)
    np.testing.assert_allclose(arm.arm.limits.acceleration, 0.25 * nominal.acceleration)
    assert arm.gripper is not None
    assert (arm.gripper.max_opening, arm.gripper.speed) == (0.05, pytest.approx(0.05 / 0.15))
    T = np.array(arm.arm.model.base)
    np.testing.assert_allclose(T[:3, 3], [0.1, 0.2, 0.3])
    roll, pitch, yaw = (math.radians(a) for a in (10, 20, 30))
    np.testing.assert_allclose(T[2, :3], [-math.sin(pitch), math.cos(pitch) * math.sin(roll),
                                          math.cos(pitch) * math.cos(roll)])  # fmt: skip
    assert math.atan2(T[1, 0], T[0, 0]) == pytest.approx(yaw)


def test_every_key_of_a_base(job: Job) -> None:
    agv = job.bases[0]
    assert agv.base.driven == ("a", "b", "c")
    assert (agv.base.mass, agv.base.alpha, agv.base.com_height) == (12.0, 0.6, 0.08)
    assert (agv.drive.motor.max_voltage, agv.drive.gear.ratio, agv.drive.encoder.counts_per_rev) == (24.0, 20.0, 2000)
    shaping = agv.settings.shaping
    assert (shaping.speed, shaping.acceleration) == (1.0, 0.8)
    assert (shaping.turn_rate, shaping.turn_acceleration) == pytest.approx((math.radians(90), math.radians(300)))
    assert (agv.levels.supervisor, agv.levels.interpolation) == (0.05, "hold")
    assert (agv.settings.slip, agv.settings.traction, agv.settings.watch) == (None, None, None)
    assert (agv.task.start, agv.task.after, agv.task.done) == (2.0, None, 7)
    assert agv.task.path is not None
    np.testing.assert_allclose(agv.pose, agv.task.path.pose[0])
    assert (agv.sensors.gyro_noise, agv.sensors.gyro_bias) == pytest.approx((math.radians(0.1), math.radians(0.02)))
    assert (agv.sensors.accelerometer_noise, agv.sensors.current_noise) == (0.04, 0.02)
    assert [(f.time, f.wheel, f.kind) for f in agv.faults] == [(5.0, "b", "blocked")]
    cart = job.bases[1]
    assert (cart.settings.shaping.jerk, cart.settings.shaping.timeout) == (9.0, 0.5)
    assert cart.settings.shaping.turn_jerk == pytest.approx(math.radians(1000))
    np.testing.assert_allclose(cart.pose, [-3.0, 1.0, math.pi / 2])
    assert cart.task.velocities is not None
    np.testing.assert_allclose(cart.task.velocities, [[0, 0.2, 0, 0.5], [2, 0, 0, 0]])
    assert (cart.task.after, cart.drives) == (7, "from_limits")
    assert job.bases[2].task.hold == 3.0


def test_every_key_of_the_world(job: Job) -> None:
    assert [surface.name for surface in job.surfaces] == ["bench", "tray", "shelf"]
    np.testing.assert_allclose(job.surfaces[0].pose[:3, 3], [0.7, 0.2, 0.3])
    disc = job.parts[0]
    assert (disc.name, disc.radius, disc.thickness, disc.mass) == ("puck", 0.02, 0.01, 0.1)
    np.testing.assert_allclose(disc.pose[:3, 3], [0.7, 0.0, 0.305])
    box, post = job.obstacles
    assert (box.name, box.shape) == ("crate", Box((0.2, 0.3, 0.4)))
    assert (post.name, post.shape) == ("post", Cylinder(0.05, 1.5))
    assert [(e.at, e.number, e.on) for e in job.events] == [(1.0, 3, True), (4.0, 3, False)]
    assert job.fields[0].name == "small"
    assert job.fields[0].size == pytest.approx((0.08, 0.04))
    assert job.floor.material.peak == 0.7
    assert len(job.floor.patches) == 2
    assert (job.name, job.seed, job.time_limit) == ("all keys", 4, 60.0)


def test_an_arm_with_motors_of_its_own(tmp_path: Path) -> None:
    motor = ('resistance = "0.5ohm", inductance = "0.5mH", torque_constant = "50mNm/A", rotor_inertia = "100gcm2", '
             'supply = "48V", max_current = "20A", gear_ratio = 100.0, counts_per_turn = 4096')  # fmt: skip
    path = write(tmp_path, f"{ABOUT}[[robot]]\nmodel = 'three_joint'\ndrives = {{ {motor} }}\n")
    arm = built(path).arms[0]
    assert arm.drives == "motors"
    assert [joint.motor.gear_ratio for joint in arm.arm.model.joints if joint.motor] == [100.0] * 3
    name = load_arm("three_joint").limits.names[1]
    other = motor.replace("100.0", "-60.0")
    text = f"{ABOUT}[[robot]]\nmodel = 'three_joint'\ndrives = [{{ {motor} }}, {{ joint = '{name}', {other} }}]\n"
    arm = built(write(tmp_path, text)).arms[0]
    assert [joint.motor.gear_ratio for joint in arm.arm.model.joints if joint.motor] == [100.0, -60.0, 100.0]
    with pytest.raises(CellError, match=r"cell.toml:6: robot\[0\].drives: no joint 'elbo'; there is .*"):
        built(write(tmp_path, text.replace(f"'{name}'", "'elbo'")))


def test_a_rod_is_a_tool(tmp_path: Path) -> None:
    rod = '[[robot]]\nmodel = "ur5e"\ntool = { kind = "rod", length = "200mm", mass = "1kg" }\n'
    arm = built(write(tmp_path, ABOUT + rod)).arms[0].arm
    bare = load_arm("ur5e")
    q = np.array([0.1, -1.0, 1.2, 0.3, 0.4, 0.5])
    np.testing.assert_allclose(arm.fk(q)[:3, 3], bare.fk(q)[:3, 3] + 0.2 * bare.fk(q)[:3, 2])
    assert np.abs(arm.gravity(q) - bare.gravity(q)).max() > 1.0


def test_a_tool_on_a_flange_that_is_turned(data_folder: Path, tmp_path: Path) -> None:
    """Its weight lies along z of the tool's link, whatever the joint frame is."""
    file = data_folder / "robots/urdf/rtb_data/kr210l150.urdf"
    rod = f"[[robot]]\nmodel = '{file}'\ndrives = 'ideal'\ntool = {{ kind = 'rod', length = '400mm', mass = '10kg' }}\n"
    arm, bare = built(write(tmp_path, ABOUT + rod)).arms[0].arm, load_arm(file)
    q = np.array([0.1, 0.2, -0.3, 0.3, 0.4, 0.5])
    middle = np.eye(4)
    middle[2, 3] = 0.2
    h = 1e-6

    def height(q):
        return (bare.fk(q) @ middle)[2, 3]

    slope = [(height(q + h * e) - height(q - h * e)) / (2 * h) for e in np.eye(6)]
    np.testing.assert_allclose(arm.gravity(q) - bare.gravity(q), 10 * 9.81 * np.array(slope), atol=1e-5)


def test_an_arm_is_short_for_a_robot(tmp_path: Path) -> None:
    short = ABOUT + (
        '[arm]\npreset = "puma560"\nbase = { position = ["0m", "1m", "0m"], angle = "90deg" }\n'
        'home = ["0deg", "45deg", "-180deg", "0deg", "-45deg", "0deg"]\ncontrollers = ["cascade"]\n'
        '[limits]\nline_speed = "250mm/s"\n[program]\nfile = "wave.arps"\n'
        '[table]\npose = { position = ["0m", "0m", "0m"], angle = "0deg" }\nsize = ["1m", "1m"]\n'
    )
    long = ABOUT + (
        '[[robot]]\nmodel = "puma560"\npose = ["0m", "1m", "0m", "0deg", "0deg", "90deg"]\n'
        'home = ["0deg", "45deg", "-180deg", "0deg", "-45deg", "0deg"]\ncontrollers = ["cascade"]\n'
        'limits = { line_speed = "250mm/s" }\nprogram = "wave.arps"\n'
        '[[surface]]\nname = "table"\npose = ["0m", "0m", "0m", "0deg", "0deg", "0deg"]\nsize = ["1m", "1m"]\n'
    )
    assert load_cell(write(tmp_path, short)) == load_cell(write(tmp_path, long))


def test_a_base_is_short_for_a_robot() -> None:
    short = load_cell(EXAMPLES / "03_soccer_robot" / "cell.toml")
    assert [robot.name for robot in short.robot] == [""]
    assert [s.method.name for s in short.sensor] == ["gyro", "accelerometer"]
    assert [patch.name for patch in short.patch] == ["ice"]
    assert short.robot[0].path is not None
    assert short.fault[0].wheel == "rear left"


def test_wheels_may_stand_in_the_robot_or_in_its_model(tmp_path: Path) -> None:
    keys = 'arrangement = "mecanum"\nwheelbase = "0.4m"\ntrack = "0.3m"\nwheel_radius = "50mm"\nmass = "20kg"\n'
    beside = load_cell(write(tmp_path, f"{ABOUT}[[robot]]\n{keys}hold = '1s'\n")).robot[0]
    inside = load_cell(write(tmp_path, f"{ABOUT}[[robot]]\nhold = '1s'\n[robot.model]\n{keys}")).robot[0]
    assert beside.source.params == inside.source.params
    assert beside.source.base.wheels == inside.source.base.wheels
    assert beside.hold == inside.hold == 1.0


def test_the_schema_has_every_table() -> None:
    schema = cell_schema()
    assert set(schema["properties"]) == {*Cell.model_fields, *SHORT}
    for name in ("ArmTable", "BaseTable", "Robot", "WheelDrive", "GripperTool"):
        assert name in schema["$defs"]


SENSOR = """from dataclasses import dataclass
from holonom.registry import OWN, Method, check_fields, parameter

@dataclass(frozen=True, slots=True)
class Nose:
    gain: float = parameter(1.0, meaning="of it", least=0.0)

    def __post_init__(self):
        check_fields(self)

    def read(self, truth):
        return [self.gain]

METHOD = Method("smells", lambda sheet: sheet, OWN, Nose)
"""


def test_a_sensor_that_is_added_is_a_sensor_of_cells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = f"{ABOUT}[[robot]]\nmodel = 'ur5e'\n[[sensor]]\nkind = 'nose'\nname = 'left nostril'\ngain = 2.0\n"
    with pytest.raises(CellError, match=r"cell.toml:7: sensor\[0\].kind: no sensor 'nose'"):
        load_cell(write(tmp_path, text))
    (tmp_path / "thrown_away_nose.py").write_text(SENSOR)
    about = tmp_path / "thrown_away_nose-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: thrown_away_nose\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text("[holonom.sensors]\nnose = thrown_away_nose:METHOD\n")
    monkeypatch.syspath_prepend(tmp_path)
    (sensor,) = built(write(tmp_path, text)).sensors
    assert (sensor.name, sensor.robot, sensor.kind, sensor.sensor.read(None)) == ("left nostril", "", "nose", [2.0])

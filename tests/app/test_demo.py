"""The two examples, judged from their recordings and summaries alone."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from holonom.app.cell import load_cell
from holonom.app.cell.build.camera import calibrate
from holonom.app.cell.model.places import placement_pose
from holonom.app.console.cli import main
from holonom.app.recording import EPOCH, Recording, read_recording
from holonom.model import preset
from holonom.spatial import inverse
from holonom.vision import to_pixel

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]
COINS = ROOT / "examples" / "01_sort_coins" / "cell.toml"
CELL = load_cell(COINS)
LINES = "02_straight_lines"


@pytest.fixture(scope="module")
def folder(example_run: Callable[[str], Path]) -> Path:
    return example_run("01_sort_coins")


@pytest.fixture(scope="module")
def recording(folder: Path) -> Recording:
    return read_recording(folder / "recording.mcap")


@pytest.fixture(scope="module")
def coins(recording: Recording) -> dict[str, np.ndarray]:
    """Every coin's place at the start and at the end, in the table frame, m: (2, 3)."""
    to_table = inverse(placement_pose(CELL.surface[0].pose))
    ends = {name: track.poses()[[0, -1]] for name, track in recording.frames.items() if name.startswith("coin")}
    return {name: (to_table @ poses)[:, :3, 3] for name, poses in ends.items()}


def labelled() -> tuple[np.ndarray, list[str]]:
    """Centres (24, 2) in px and classes, as a person sees them in the photograph."""
    with (ROOT / "tests" / "vision" / "coins_labelled.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return np.array([[float(row["u"]), float(row["v"])] for row in rows]), [row["class"] for row in rows]


def test_every_coin_ends_in_the_field_of_its_class(coins: dict[str, np.ndarray]) -> None:
    centres, classes = labelled()
    starts, ends = (np.array([place[k] for place in coins.values()]) for k in (0, 1))
    pixels = to_pixel(calibrate(CELL.camera, COINS), starts[:, :2])
    distance = np.linalg.norm(pixels[:, None] - centres, axis=-1)
    label = distance.argmin(axis=1)
    assert sorted(label) == list(range(24)), "each label is one coin's, each coin has one"
    assert distance.min(axis=1).max() < 1.5
    fields = {field.name: field for field in CELL.tray.fields}
    for name, place, k in zip(coins, ends, label, strict=True):
        field = fields[classes[k]]
        size = field.pitch * np.array([field.columns, field.rows])
        inside = (place[:2] >= field.corner) & (place[:2] <= np.add(field.corner, size))
        assert inside.all(), f"{name}, a {classes[k]} coin, lies at {1e3 * place} mm"
        assert place[2] == pytest.approx(CELL.tray.floor + CELL.parts.thickness / 2, abs=1e-6)
    assert Counter(classes) == {"small": 18, "medium": 2, "large": 4}


def test_no_two_coins_overlap_in_the_tray(coins: dict[str, np.ndarray]) -> None:
    with CELL.parts.layout.open(encoding="utf-8") as file:
        rows = [[float(row[key]) for key in ("u", "v", "diameter")] for row in csv.DictReader(file)]
    truth = np.array(rows)
    pixels = to_pixel(calibrate(CELL.camera, COINS), np.array([place[0, :2] for place in coins.values()]))
    nearest = np.linalg.norm(pixels[:, None] - truth[:, :2], axis=-1).argmin(axis=1)
    radius = 0.5e-3 * truth[nearest, 2] / 2
    ends = np.array([place[1, :2] for place in coins.values()])
    apart = np.linalg.norm(ends[:, None] - ends, axis=-1) - radius[:, None] - radius
    assert apart[~np.eye(24, dtype=bool)].min() > 0.0


def test_a_real_puma_could_do_it(folder: Path, recording: Recording) -> None:
    """Peaks of the 10 kHz loops and of the recording keep to the rated values of the model."""
    joints = json.loads((folder / "summary.json").read_text("utf-8"))["joints"]
    peaks = {
        "speed_rad_s": np.abs(recording.true_joints.velocity).max(0),
        "torque_Nm": np.abs(recording.true_joints.effort).max(0),
        "current_A": np.abs(recording.drives.current).max(0),
        "voltage_V": np.abs(recording.drives.voltage).max(0),
    }
    for k, joint in enumerate(preset("puma560").joints):
        rated = (joint.limits.speed, joint.limits.torque, joint.motor.max_current, joint.motor.max_voltage)
        for (key, seen), limit in zip(peaks.items(), rated, strict=True):
            peak = joints[joint.name][f"peak_{key}"]
            assert 0.0 < seen[k] <= peak <= limit, f"{joint.name}: {key} {peak}, recorded {seen[k]}, rated {limit}"
    assert recording.joints.time[-1] < 24 * 4.0


def test_the_arm_keeps_to_its_references(recording: Recording) -> None:
    error = np.abs(recording.joints.position - recording.reference.position).max()
    assert 0.0 < error < np.radians(0.1)


SHORT = """[cell]
name = "short"
time_limit = "5s"
[[robot]]
model = "puma560"
program = "short.arps"
"""


def test_a_second_run_is_the_same_to_the_byte(tmp_path: Path) -> None:
    """Two seconds of an arm with its motors."""
    (tmp_path / "short.arps").write_text(".PROGRAM short()\n  DRIVE 1, 10, 50\n  DRIVE 2, -5, 50\n.END\n", "utf-8")
    (tmp_path / "cell.toml").write_text(SHORT, "utf-8")
    for out in ("one", "two"):
        assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / out), "--quiet"]) == 0
    for name in ("recording.mcap", "summary.json"):
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


def test_the_recording_is_one_of_ros(folder: Path) -> None:
    with (folder / "recording.mcap").open("rb") as file:
        reader, factory = make_reader(file), DecoderFactory()
        summary = reader.get_summary()
        counts = {summary.channels[k].topic: n for k, n in summary.statistics.channel_message_counts.items()}
        seconds = (summary.statistics.message_end_time - EPOCH) / 1e9
        for topic in ("/joint_states", "/commanded/joint_states", "/truth/tf", "/truth/tool_pose"):
            assert counts[topic] >= 100 * seconds, topic
        assert counts["/rosout"] > 24
        window: dict[str, list[Any]] = {}
        for schema, channel, message in reader.iter_messages():
            if 20e9 <= message.log_time - EPOCH < 21e9:
                decode = factory.decoder_for(channel.message_encoding, schema)
                window.setdefault(channel.topic, []).append(decode(message.data))
    assert set(window) >= {"/joint_states", "/truth/tf", "/truth/tool_pose", "/rosout"}
    assert [len(window[topic]) for topic in ("/joint_states", "/truth/tf")] == [100, 200], "the arm's, and the parts'"
    assert window["/joint_states"][0].name[0] == "waist"
    names = {transform.child_frame_id for message in window["/truth/tf"][:2] for transform in message.transforms}
    assert {"link1", "tool", "coin_01", "coin_24"} <= names


def test_computed_torque_follows_better_in_every_phase(example_run: Callable[[str], Path]) -> None:
    folder = example_run(LINES)
    phases = json.loads((folder / "summary.json").read_text("utf-8"))["tracking"]
    names = [f"{figure}, {rate} mm/s" for rate in (100, 250) for figure in ("square", "circle")]
    assert [phase["phase"] for phase in phases] == names
    for phase in phases:
        rms, peak = phase["rms_m"], phase["peak_m"]
        assert phase["ratio"] == pytest.approx(rms["cascade"] / rms["computed torque"])
        assert phase["ratio"] >= 1.0, phase
        assert rms["computed torque"] < peak["computed torque"] < 1e-3
    report = (folder / "report.html").read_text("utf-8")
    assert all(name in report for name in names)


@pytest.mark.parametrize("name", ["recording.mcap", "recording_cascade.mcap"])
def test_the_figures_are_drawn(example_run: Callable[[str], Path], name: str) -> None:
    """Tool points while each signal is on lie on a square of 200 mm, or on a circle's 24 chords."""
    recording = read_recording(example_run(LINES) / name)
    centre = np.array([0.45, -0.125, 0.45])
    times = [signal.time for signal in recording.signals if signal.time > 0.0]
    for number in range(4):
        inside = (recording.tool.time >= times[2 * number]) & (recording.tool.time <= times[2 * number + 1])
        points = recording.tool.position[inside] - centre
        assert np.abs(points[:, 2]).max() < 1e-4
        if number % 2 == 0:
            size = np.abs(points[:, :2]).max(axis=1)
            np.testing.assert_allclose(size, 0.1, atol=5e-4 if number == 0 else 3e-3)
            assert np.ptp(points[:, :2], axis=0) == pytest.approx([0.2, 0.2], abs=6e-4)
        else:
            radius = np.linalg.norm(points[:, :2], axis=1)
            assert radius.max() < 0.1001
            assert radius.min() > 0.1 * np.cos(np.pi / 24) - 3e-4

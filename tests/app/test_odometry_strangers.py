"""Logs as strangers write them: the same runs in every form give the same numbers."""

from __future__ import annotations

import math
import sqlite3
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import Writer

from holonom.app.calibrate.odometry import calibrate_odometry
from holonom.app.odometry_log import read_log
from holonom.errors import LogError
from holonom.mobile.calibration import drive_parameters
from holonom.mobile.odometry import integrate

GEOMETRY = "[geometry]\nwheelbase = 0.2\ndiameter_left = 0.084\ndiameter_right = 0.084\n"
TRUE = np.array([0.2013, 0.08405, 0.08395])
NAMES = ("time", "left", "right", "x", "y", "theta")


def rows() -> np.ndarray:
    """Times, running angles of the wheels, and the truth of a base that wanders about."""
    time = 0.05 * np.arange(500)
    turns = 0.1 + 0.08 * np.sin(np.outer(time, [0.7, 0.9]) + np.array([0.0, 1.0]))
    turns[0] = 0.0
    matrix = drive_parameters("differential", {"wheelbase": 0.2, "diameter_left": 0.084, "diameter_right": 0.084})
    return np.column_stack([time, np.cumsum(turns, axis=0), integrate(turns @ matrix.matrix(TRUE).T)])


def log(folder: Path, run: str, units: str = 'wheels = "angle"', more: str = "") -> Path:
    path = folder / "log.toml"
    path.write_text(f'drive = "differential"\nruns = ["{run}"]\n{GEOMETRY}[units]\n{units}\n{more}', encoding="utf-8")
    return path


def text(values: np.ndarray, mark: str = ",", names: tuple[str, ...] = NAMES, form: str = "{:.9f}") -> str:
    lines = [mark.join(names), *(mark.join("" if math.isnan(v) else form.format(v) for v in row) for row in values)]
    return "\n".join(lines) + "\n"


def decimal_commas(values: np.ndarray) -> str:
    return text(values, ";").replace(".", ",")


def stamps(values: np.ndarray) -> str:
    lines = [",".join(NAMES)]
    for time, *rest in values:
        lines.append(",".join([str(1_700_000_000_000_000_000 + round(1e9 * time)), *(f"{v:.9f}" for v in rest)]))
    return "\n".join(lines)


def more_columns(values: np.ndarray) -> str:
    plain = text(values).splitlines()
    return "\n".join([f"{plain[0]},battery,state", *(f"{line},12.4,driving" for line in plain[1:])])


def two_rates(values: np.ndarray) -> str:
    """Wheels at 20 Hz; the truth at 100 Hz, each in rows of its own."""
    fine = np.linspace(0.0, values[-1, 0], 5 * len(values))
    truth = [np.interp(fine, values[:, 0], column) for column in values[:, 3:].T]
    blank = np.full((len(fine), 2), np.nan)
    both = np.concatenate([
        np.column_stack([values[:, :3], np.full((len(values), 3), np.nan)]),
        np.column_stack([fine + 1e-7, blank, *truth]),
    ])  # fmt: skip
    return text(both[np.argsort(both[:, 0])])


FORMS: dict[str, Callable[[np.ndarray], str]] = {
    "commas": text, "semicolons": lambda v: text(v, ";"), "tabs": lambda v: text(v, "\t"),
    "decimal commas": decimal_commas, "stamps in ns": stamps, "more columns": more_columns, "two rates": two_rates,
}  # fmt: skip


@pytest.mark.parametrize("form", FORMS)
def test_the_same_run_in_any_form(tmp_path: Path, form: str) -> None:
    (tmp_path / "run.csv").write_text(FORMS[form](rows()), encoding="utf-8")
    data = calibrate_odometry([log(tmp_path, "run.csv")]).data
    found = [data["calibrated"][name] for name in ("wheelbase", "diameter_left", "diameter_right")]
    np.testing.assert_allclose(found, TRUE, rtol=1e-4)
    unread = [note for note in data["notes"] if "not read: column battery, state" in note]
    assert len(unread) == (form == "more columns")


def test_the_unit_of_time_may_be_stated(tmp_path: Path) -> None:
    values = rows()
    values[:, 0] *= 1e3
    (tmp_path / "run.csv").write_text(text(values), encoding="utf-8")
    run = read_log([log(tmp_path, "run.csv", 'wheels = "angle"\ntime = "ms"')]).runs[0]
    np.testing.assert_allclose(np.diff(run.time), 0.05)


def test_a_clock_that_is_late_is_said_and_put_right(tmp_path: Path) -> None:
    """By 0.4 s: neither slip nor a wrong column."""
    values = rows()
    values[:, 3:] = np.stack([np.interp(values[:, 0] - 0.4, values[:, 0], c) for c in values[:, 3:].T], axis=1)
    (tmp_path / "run.csv").write_text(text(values), encoding="utf-8")
    data = calibrate_odometry([log(tmp_path, "run.csv")]).data
    assert any("the truth's clock is 0.4 s late; put right" in note for note in data["notes"])
    assert not any("slip" in note or "disagree" in note for note in data["notes"])
    np.testing.assert_allclose([data["calibrated"][n] for n in ("wheelbase", "diameter_left")], TRUE[:2], rtol=2e-3)


def test_two_rates_need_both(tmp_path: Path) -> None:
    values = rows()
    values[:, 3:] = np.nan
    (tmp_path / "run.csv").write_text(text(values), encoding="utf-8")
    with pytest.raises(LogError, match="0 rows with x, y, theta; two or more are expected"):
        read_log([log(tmp_path, "run.csv")])
    values = rows()
    values[:, 1:3] = np.nan
    (tmp_path / "run.csv").write_text(text(values), encoding="utf-8")
    with pytest.raises(LogError, match="0 rows with left, right"):
        read_log([log(tmp_path, "run.csv")])


class Cdr:
    """A message as OMG's CDR lays it out, written here a second time."""

    def __init__(self) -> None:
        self.data = b""

    def put(self, form: str, *values: object) -> Cdr:
        size = struct.calcsize(f"<{form[-1]}")
        self.data += b"\0" * (-len(self.data) % size) + struct.pack(f"<{form}", *values)
        return self

    def text(self, words: str) -> Cdr:
        self.put("I", len(words) + 1)
        self.data += words.encode() + b"\0"
        return self

    def header(self, time: float, frame: str) -> Cdr:
        stamp = round(1e9 * time)
        return self.put("i", stamp // 10**9).put("I", stamp % 10**9).text(frame)

    def pose(self, x: float, y: float, theta: float) -> Cdr:
        return self.put("7d", x, y, 0.0, 0.0, 0.0, math.sin(theta / 2), math.cos(theta / 2))


def joints(row: np.ndarray) -> bytes:
    cdr = Cdr().header(row[0], "").put("I", 2).text("left").text("right").put("I", 2).put("2d", *row[1:3])
    return b"\0\1\0\0" + cdr.put("I", 0).put("I", 0).data


def posed(row: np.ndarray) -> bytes:
    return b"\0\1\0\0" + Cdr().header(row[0], "world").pose(*row[3:]).data


def transformed(row: np.ndarray) -> bytes:
    cdr = Cdr().put("I", 2)
    for frame, pose in (("base_link", row[3:]), ("beacon", np.zeros(3))):
        cdr.header(row[0], "world").text(frame).pose(*pose)
    return b"\0\1\0\0" + cdr.data


TRUTHS = {"geometry_msgs/msg/PoseStamped": posed, "tf2_msgs/msg/TFMessage": transformed}


def database(path: Path, kind: str) -> None:
    """As rosbag2's own storage makes its tables."""
    base = sqlite3.connect(path)
    base.execute(
        "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
        "serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL)"
    )
    base.execute(
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, "
        "data BLOB NOT NULL)"
    )
    base.executemany(
        "INSERT INTO topics VALUES(?, ?, ?, 'cdr', '')",
        [(1, "/joint_states", "sensor_msgs/msg/JointState"), (2, "/truth", kind)],
    )
    for row in rows():
        for topic, data in ((1, joints(row)), (2, TRUTHS[kind](row))):
            base.execute(
                "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", (topic, round(1e9 * row[0]), data)
            )
    base.commit()
    base.close()


def mcap(path: Path, kind: str) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=Profile.ROS2, library="stranger")
        channels = [
            writer.register_channel(topic, MessageEncoding.CDR, writer.register_schema(name, SchemaEncoding.ROS2, b"x"))
            for topic, name in (("/joint_states", "sensor_msgs/msg/JointState"), ("/truth", kind))
        ]
        for row in rows():
            for channel, data in zip(channels, (joints(row), TRUTHS[kind](row)), strict=True):
                stamp = round(1e9 * row[0])
                writer.add_message(channel, log_time=stamp, publish_time=stamp, data=data)
        writer.finish()


@pytest.mark.parametrize("kind", TRUTHS)
@pytest.mark.parametrize("store", ["db3", "mcap", "folder"])
def test_poses_and_transforms_in_any_recording(tmp_path: Path, store: str, kind: str) -> None:
    name = "bag" if store == "folder" else f"run.{store}"
    if store == "folder":
        (tmp_path / name).mkdir()
    target = tmp_path / name / "bag_0.db3" if store == "folder" else tmp_path / name
    (mcap if store == "mcap" else database)(target, kind)
    data = calibrate_odometry([log(tmp_path, name)]).data
    found = [data["calibrated"][key] for key in ("wheelbase", "diameter_left", "diameter_right")]
    np.testing.assert_allclose(found, TRUE, rtol=1e-5)


def test_what_is_no_recording_or_has_no_such_frame(tmp_path: Path) -> None:
    (tmp_path / "run.db3").write_bytes(b"SQLite format 3\0 but no more")
    with pytest.raises(LogError, match="no rosbag2 database that can be read"):
        read_log([log(tmp_path, "run.db3")])
    database(tmp_path / "tf.db3", "tf2_msgs/msg/TFMessage")
    with pytest.raises(LogError, match="no transform of frame 'robot'; there is base_link, beacon: name one as frame"):
        read_log([log(tmp_path, "tf.db3", more='[mcap]\nframe = "robot"\n')])
    beacon = read_log([log(tmp_path, "tf.db3", more='[mcap]\ntruth = "/truth"\nframe = "base_link"\n')])
    np.testing.assert_allclose(beacon.runs[0].truth[-1], rows()[-1, 3:], atol=1e-9)


TRUE_LOGS = {"wheelbase": 0.2013, "diameter_left": 0.08405, "diameter_right": 0.08395}


@pytest.mark.parametrize(
    ("name", "frame"), [("marker_off_80mm_3deg", (0.08, 0.008, 0.05)), ("semicolon", (0, 0, 0)), ("ns", (0, 0, 0))]
)
def test_logs_that_once_gave_wrong_numbers(data_folder: Path, name: str, frame: tuple[float, ...]) -> None:
    """Simulated with other numbers than the data sheet's and a marker beside the base: within three deviations."""
    data = calibrate_odometry([data_folder / "faults" / "logs" / name / "log.toml"]).data
    truth = {**TRUE_LOGS, **dict(zip(("frame_ahead", "frame_left", "frame_yaw"), frame, strict=True))}
    z = [(data["calibrated"][key] - truth[key]) / data["deviations"][key] for key in truth]
    assert np.abs(z).max() < 3.0
    for key, value in TRUE_LOGS.items():
        assert data["calibrated"][key] == pytest.approx(value, rel=5e-4)

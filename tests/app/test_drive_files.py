"""`holonom check` of motors and axes, `holonom select`: files, published cases, refusals."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holonom
from holonom.app.console.cli import main
from holonom.app.drives.select import select
from holonom.app.recording import Recorder
from holonom.devices import MotorSheet, motor_card
from holonom.registry import parameters_of
from holonom.signals import JointCommand, JointState


def case(data_folder: Path, start: str) -> dict[str, Any]:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    return next(one for one in cases if one["id"].startswith(start))


def toml(folder: Path, tables: Mapping[str, Mapping[str, Any]], name: str = "file.toml") -> Path:
    path, lines = folder / name, []
    for table, keys in tables.items():
        lines += [f"[{table}]"] if table else []
        lines += [f"{key} = {json.dumps(value)}" for key, value in keys.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def call(capsys: pytest.CaptureFixture[str], *words: str | Path) -> tuple[int, Any]:
    status = main([*map(str, words), "--json"])
    return status, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("name", ["motor maxon RE 40 148877 48 V", "servo data sheet 310 V"])
def test_published_sheets(data_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    found = case(data_folder, name)
    status, data = call(capsys, "check", toml(tmp_path, {"motor": found["input"]}))
    assert status == 0
    for key, value in found["expected"].items():
        assert data[key] == pytest.approx(value, rel=found["tol"]), key
    if "IN" in found["input"]:
        heat = case(data_folder, "thermal")
        for key, value in heat["expected"].items():
            assert data[key] == pytest.approx(value, rel=heat["tol"]), key


def test_quantities_are_the_same_numbers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written = {
        "U": "48 V", "n0": "7590rpm", "I0": "68.6mA", "nN": "7000 rpm", "MN": "187mNm", "IN": "3.17A", "MH": "2.56Nm",
        "IA": "42.4A", "R": "1130mohm", "L": "0.33mH", "kM": "60.3mNm/A", "kn_rpm_per_V": "158rpm/V", "J": "137gcm2",
        "Rth1": "4.65K/W", "Rth2": "1.93K/W", "tau_w": "41.5s", "tau_s": "809s", "eta_max": 0.92, "tau_m": "4.28ms",
        "gradient_rpm_per_mNm": "2.97rpm/mNm",
    }  # fmt: skip
    _, data = call(capsys, "check", toml(tmp_path, {"motor": written}))
    _, same = call(capsys, "check", toml(tmp_path, {"motor": {"preset": "maxon_re40_48v"}}))
    for key, value in same.items():
        if isinstance(value, float):
            assert data[key] == pytest.approx(value, rel=1e-12), key


@pytest.mark.parametrize(
    ("motor", "name"),
    [
        ({"R": 3.99, "L": 0.556e-3, "kM": 0.0352159, "J": 45.3e-6}, "inertia against tau_m (factor 10)"),
        ({"R": 4.5, "L": 0.5e-3, "kM": 0.04, "J": 45e-6, "tau_m": 0.0127}, "inertia against tau_m (factor 10)"),
        ({"U": 9, "n0_rpm": 11400, "nN_rpm": 12300, "R": 0.168, "kM": 0.00695, "kn_rpm_per_V": 1370}, "n0 below nN"),
        ({"Ke_V_per_krpm": 51, "Kt": 0.051}, "Ke against Kt (factor 9.5)"),
    ],
)
def test_contradictions_end_with_status_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], motor: dict[str, float], name: str
) -> None:
    path = toml(tmp_path, {"motor": motor})
    status, data = call(capsys, "check", path)
    assert status == 2
    assert [one["name"] for one in data["contradictions"]] == [name]
    assert main(["check", str(path)]) == 2
    assert f"contradiction: {name}: " in capsys.readouterr().out


def test_every_motor_is_sound(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sheet = motor_card("maxon_re50_24v").sheet.printed()
    assert set(sheet) <= {field.name for field in parameters_of(MotorSheet)}
    status, data = call(capsys, "check", toml(tmp_path, {"motor": {**sheet, "name": "mine", "note": "bought"}}))
    assert (status, data["motor"], data["kind"]) == (0, "mine", "motor")
    assert data["contradictions"] == data["warnings"] == []


def test_an_axis_says_what_does_not_fit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    axis = {
        "motor": {"preset": "maxon 148877 48 V"},
        "supply": {"voltage": 48, "current_limit": "10A"},
        "gear": {"ratio": 2, "efficiency": 0.9, "gap": "0.1deg", "stiffness": "20Nm/rad"},
        "load": {"inertia": 1e-2, "coulomb": 0.002, "viscous": 1e-5},
        "encoder": {"counts": 100},
        "sample": {"current": "1ms"},
        "wanted": {"anything": 1},
    }
    status, data = call(capsys, "check", toml(tmp_path, axis))
    assert (status, data["kind"]) == (0, "axis")
    warned = {one["name"]: one for one in data["warnings"]}
    assert set(warned) == {"inertia ratio", "sample time above L/R", "encoder too coarse"}
    assert warned["inertia ratio"]["printed"] == pytest.approx(1e-2 / 4 / 1.37e-5, rel=1e-3)
    step = 2.0 * math.pi / (warned["encoder too coarse"]["expected"] * 5e-4)
    assert step == pytest.approx(0.02 * 794.7, rel=2e-3)
    assert "current limit above the thermal limit" in [one["name"] for one in data["notes"]]
    for wrong, name in (
        ({"load": {"coulomb": 50}}, "friction above the torque"),
        ({"gear": {"ratio": 0}}, "gear ratio 0"),
        ({"wanted": {"speed": 500}}, "speed above the no-load speed"),
    ):
        status, data = call(capsys, "check", toml(tmp_path, axis | wrong))
        assert status == 2
        assert name in [one["name"] for one in data["contradictions"]]
    magnets = {"motor": {"U": 48, "R": 1.0, "L": 1e-3, "kM": 0.05, "J": 1e-5, "I_demag": 8, "n_max": 5000}}
    status, data = call(capsys, "check", toml(tmp_path, {**magnets, "supply": {"current_limit": 10}}))
    assert status == 2
    assert data["contradictions"][0]["name"] == "current limit above the demagnetising current"
    assert "supply above the largest speed" in [one["name"] for one in data["warnings"]]


def test_faults_of_a_file_have_their_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = toml(tmp_path, {"motor": {"R": -1, "L": "3V", "kM": True, "JJ": 1.0, "U": math.inf}})
    path.write_text(path.read_text().replace("Infinity", "inf"), encoding="utf-8")
    assert main(["check", str(path)]) == 2
    told = capsys.readouterr().err
    for line in (
        f"{path}:2: motor.R: -1 came; it must be finite and greater than 0 ohm",
        f"{path}:3: motor.L: '3V' came, in a unit of voltage",
        f"{path}:4: motor.kM: True came; a number in Nm/A is expected",
        f"{path}:5: motor.JJ: no key 'JJ'",
        f"{path}:6: motor.U: inf came",
    ):
        assert line in told
    for motor, words in (
        ({"preset": "maxon 1"}, "motor.preset: no motor 'maxon 1'"),
        ({"preset": "maxon_re40_48v", "R": 1.0}, "give a preset, or the numbers of a sheet"),
        ({"name": "x"}, "no number of a sheet came"),
        ({"R": 1e-16}, "at least 1e-15 ohm is read"),
        ({"R": 1e16}, "must be finite"),
    ):
        assert main(["check", str(toml(tmp_path, {"motor": motor}))]) == 2
        assert words in capsys.readouterr().err


def test_what_is_no_drive_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "file.toml"
    for text, words in (
        ("motor = 3", "3 came; a table is expected"),
        (
            '[process]\nkind = "dead time"',
            f"a process is not checked but tuned, which says what is wrong: holonom tune {path}",
        ),
    ):
        path.write_text(text, encoding="utf-8")
        assert main(["check", str(path)]) == 2
        assert capsys.readouterr().err.strip().endswith(words)


def test_published_cycle_and_ratio(data_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cycle, ratio = case(data_folder, "load cycle"), case(data_folder, "best ratio")
    for tables in ({"": cycle["input"]}, {"cycle": cycle["input"]}):
        status, data = call(capsys, "select", toml(tmp_path, tables))
        assert status == 0
        for key, value in cycle["expected"].items():
            assert data[key] == pytest.approx(value, rel=cycle["tol"]), key
        assert data["ranked"]
        assert all(one["rejections"] for one in data["rejected"])
    status, data = call(capsys, "select", toml(tmp_path, {"": ratio["input"]}))
    assert data["ratio"] == pytest.approx(ratio["expected"]["ratio"], rel=ratio["tol"])


def test_own_motors_gears_and_limits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = toml(tmp_path, {"cycle": {"angle": "90deg", "time": "0.5s", "inertia": 0.02, "load": 5, "dwell": 0.1}})
    more = '[supply]\nvoltage = 24\n[[gear]]\nratio = 26\nmax_torque = 3\n[[motor]]\npreset = "maxon_re40_48v"\n'
    path.write_text(path.read_text() + more, encoding="utf-8")
    status, data = call(capsys, "select", path)
    assert (status, data["ranked"], len(data["rejected"])) == (0, [], 1)
    assert {"thermal", "gear"} <= {one["name"] for one in data["rejected"][0]["rejections"]}
    assert data["assumed"] == []
    assert main(["select", str(path)]) == 0
    assert "no motor makes it" in capsys.readouterr().out


def test_a_sheet_that_contradicts_itself_is_not_selected_in_silence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = toml(tmp_path, {"cycle": {"angle": 1.0, "time": 0.5, "inertia": 0.01}})
    sheet = "[[motor]]\nname = 'mine'\nU = 24\nn0 = 3000\nnN = 4000\nR = 1\nL = 1e-3\nkM = 0.05\nJ = 1e-5\nIN = 2\n"
    path.write_text(path.read_text() + sheet, encoding="utf-8")
    _, data = call(capsys, "select", path)
    assert [warning["name"] for warning in data["warnings"]] == ["n0 below nN"]
    assert data["warnings"][0]["text"].startswith("mine: n0 is 3000 rpm")
    assert main(["select", str(path)]) == 0
    assert "warning: n0 below nN: mine" in capsys.readouterr().out


def test_a_cycle_of_samples(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [[0.0, 0.0, 1.0], [1.0, 2.0, 1.0], [2.0, 0.0, -1.0]]
    _, data = call(capsys, "select", toml(tmp_path, {"cycle": {"samples": rows, "inertia": 0.1}}))
    assert (data["time"], data["peak_speed"], data["peak_torque"]) == (2.0, 2.0, 1.0)
    path = toml(tmp_path, {"cycle": {"samples": rows[::-1]}})
    assert main(["select", str(path)]) == 2
    assert "time[1] is 1 s after 2 s" in capsys.readouterr().err
    for tables, words in (
        ({"cycle": {"inertia": 1.0}}, "no load cycle"),
        ({"": {"angle": 1.0, "time": 1.0, "motors": ["none"]}}, "no motor 'none'"),
        ({"cycle": {"angle": 0.0, "time": 1.0}}, "angle"),
        ({"cycle": {"angle": 1.0, "time": 0.0}}, "cycle.time"),
    ):
        assert main(["select", str(toml(tmp_path, tables))]) == 2
        assert words in capsys.readouterr().err


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A Puma 560 whose shoulder swings."""
    path = tmp_path_factory.mktemp("arm") / "recording.mcap"
    arm = holonom.load_arm("puma560")
    with Recorder(path, tuple(arm.limits.names)) as out:
        for t in np.arange(0.0, 2.0, 0.01):
            q, qd = np.zeros(6), np.zeros(6)
            q[1], qd[1] = 0.3 * math.sin(3.0 * t), 0.9 * math.cos(3.0 * t)
            out.put(JointState(float(t), q, qd, np.full(6, 7.0)))
            out.put(JointCommand(float(t), q, qd, 0.0 * q))
    return path


def test_a_recorded_motion_is_a_cycle(recording: Path) -> None:
    data = select(recording, joint="2", arm="puma560").data
    (name,) = data["joints"]
    told = data["joints"][name]
    arm = holonom.load_arm("puma560")
    assert name == arm.limits.names[1]
    q = np.zeros((400, 6))
    q[:, 1] = 0.3 * np.sin(np.linspace(0.0, 5.97, 400))
    held = np.abs(arm.gravity(q)[:, 1]).max()
    swing = (float(arm.mass_matrix(q[0])[1, 1]) - 107.815**2 * 2e-4) * 2.7
    assert held - 5.0 < told["peak_torque"] < held + swing + 20.0
    assert told["peak_speed"] == pytest.approx(0.9, rel=1e-2)
    assert told["acceleration"] == pytest.approx(2.7, rel=2e-2)
    assert told["inertia"] == pytest.approx(swing / 2.7, rel=0.05)
    every = select(recording, joint="all").data
    assert len(every["joints"]) == 6
    assert every["joints"][name]["peak_torque"] == 7.0
    assert "as recorded" in every["notes"][0]


def test_a_joint_must_be_named(recording: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["select", str(recording)]) == 2
    assert "which joint" in capsys.readouterr().err
    assert main(["select", str(recording), "--joint", "7", "--arm", "puma560"]) == 2
    assert "no joint '7'" in capsys.readouterr().err
    assert main(["select", str(toml(tmp_path, {"": {"angle": 1.0, "time": 1.0}})), "--joint", "1"]) == 2
    assert "this is a load cycle" in capsys.readouterr().err
    assert main(["select", str(recording), "--joint", "1", "--arm", "ur5e_two"]) == 2
    capsys.readouterr()


@pytest.mark.slow
def test_a_cell_is_run_for_its_cycle(capsys: pytest.CaptureFixture[str]) -> None:
    cell = Path(__file__).resolve().parents[2] / "examples" / "02_straight_lines" / "cell.toml"
    status, data = call(capsys, "select", cell, "--joint", "shoulder")
    assert status == 0
    assert data["joints"]["shoulder"]["peak_torque"] > 10.0

"""`holonom check` of synchronous, stepping and induction motors: what follows from a sheet, what contradicts itself."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.app.console.cli import main

SYNCHRONOUS = {"pole_pairs": 3, "psi": 0.08, "R_phase": 0.5, "Ld": 2e-3, "Lq": 3e-3, "Udc": 300.0, "current": 12.0}
STEPPER = {"holding_torque": 1.2, "rotor_teeth": 100, "inertia": 3e-5, "load": 0.3, "steps_per_turn": 400}


def check(folder: Path, capsys: pytest.CaptureFixture[str], sheet: dict[str, Any]) -> tuple[int, Any]:
    path = folder / "motor.toml"
    path.write_text("\n".join(["[motor]", *(f"{key} = {json.dumps(value)}" for key, value in sheet.items())]), "utf-8")
    status = main(["check", str(path), "--json"])
    return status, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("modulation", "part"), [("space vector", 1.0 / math.sqrt(3.0)), ("sine", 0.5)])
def test_a_synchronous_motor(tmp_path: Path, capsys: pytest.CaptureFixture[str], modulation: str, part: float) -> None:
    """By its steady equations: short circuit and best angle of the current found on a grid."""
    status, data = check(tmp_path, capsys, SYNCHRONOUS | {"modulation": modulation})
    assert (status, data["kind"], data["contradictions"]) == (0, "synchronous motor", [])
    p, psi, R, Ld, Lq = (SYNCHRONOUS[key] for key in ("pole_pairs", "psi", "R_phase", "Ld", "Lq"))
    assert data["no_load_speed"] == pytest.approx(part * 300.0 / (p * psi))
    angle = np.linspace(0.0, np.pi, 200001)
    d, q = 12.0 * np.cos(angle), 12.0 * np.sin(angle)
    torque = 1.5 * p * (psi + (Ld - Lq) * d) * q
    assert data["torque"] == pytest.approx(torque.max(), rel=1e-8)
    assert (data["id"], data["iq"]) == pytest.approx((d[torque.argmax()], q[torque.argmax()]), rel=1e-3)
    w = p * np.linspace(1.0, 1000.0, 100001)
    d = -(w**2) * Lq * psi / (R**2 + w**2 * Ld * Lq)
    q = -w * R * psi / (R**2 + w**2 * Ld * Lq)
    brakes = -1.5 * p * (psi + (Ld - Lq) * d) * q
    assert data["short_circuit_brake_peak_torque"] == pytest.approx(brakes.max(), rel=1e-6)
    assert data["short_circuit_speed_of_peak"] == pytest.approx(w[brakes.argmax()] / p, rel=1e-3)


def test_a_stepping_and_an_induction_motor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, data = check(tmp_path, capsys, STEPPER | {"holding_torque": "1200 mNm", "inertia": "300 gcm2"})
    assert status == 0
    assert data["natural_frequency_Hz"] == pytest.approx(math.sqrt(100 * 1.2 / 3e-5) / math.tau)
    assert math.sin(0.5 * math.pi * data["deflection_full_steps"]) == pytest.approx(0.25)
    assert data["torque_of_one_sixteenth_step"] == pytest.approx(1.2 * math.sin(math.pi / 32.0))
    status, data = check(
        tmp_path, capsys, {"breakdown_torque": 10.0, "breakdown_slip": 0.25, "synchronous_rpm": 3000, "name": "pump"}
    )
    assert (status, data["motor"]) == (0, "pump")
    assert data["starting_torque"] == pytest.approx(20.0 / 4.25)
    assert data["torque_at_3_percent_slip"] == pytest.approx(20.0 / (0.03 / 0.25 + 0.25 / 0.03))
    assert main(["check", str(tmp_path / "motor.toml")]) == 0
    assert "pump, induction motor: no contradiction" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("sheet", "name"),
    [
        (SYNCHRONOUS | {"torque_constant_per_peak_A": 0.08}, "torque constant against psi"),
        (STEPPER | {"steps_per_turn": 200}, "steps_per_turn against rotor_teeth"),
        (STEPPER | {"load": 1.3}, "load above the holding torque"),
    ],
)
def test_contradictions(tmp_path: Path, capsys: pytest.CaptureFixture[str], sheet: dict[str, Any], name: str) -> None:
    status, data = check(tmp_path, capsys, sheet)
    assert (status, [finding["name"] for finding in data["contradictions"]]) == (2, [name])


@pytest.mark.parametrize(
    ("sheet", "said"),
    [
        (SYNCHRONOUS | {"psi": -0.1}, "motor.toml:3: motor.psi: psi is -0.1"),
        ({"pole_pairs": 3}, "neither psi nor torque_constant_per_peak_A came"),
        (SYNCHRONOUS | {"pole_pairs": 0}, "motor.pole_pairs: pole_pairs is 0"),
        (SYNCHRONOUS | {"modulation": "none"}, "sine, space vector"),
        (SYNCHRONOUS | {"kn": 3.0}, "no key 'kn'"),
        ({"holding_torque": 1.0, "rotor_teeth": 50}, "inertia missing"),
        (STEPPER | {"inertia": 0}, "inertia is 0"),
        ({"breakdown_torque": "nan", "breakdown_slip": 0.1, "synchronous_rpm": 1500}, "motor.breakdown_torque"),
    ],
)
def test_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str], sheet: dict[str, Any], said: str) -> None:
    status, data = check(tmp_path, capsys, sheet)
    assert status == 2
    assert said in data["error"]["message"]

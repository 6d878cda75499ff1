"""Data sheets of motors: identities, contradictions, the table of real motors, published cases."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.devices import MOTORS, MotorSheet, check_sheet, motor_card
from holonom.errors import InputError, ModelError, UnknownName

RE40 = motor_card("maxon_re40_48v").sheet


def case(data_folder: Path, name: str) -> dict[str, Any]:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    return next(one for one in cases if one["id"] == name)


@pytest.mark.parametrize("name", ["motor maxon RE 40 148877 48 V", "servo data sheet 310 V"])
def test_published_sheets(data_folder: Path, name: str) -> None:
    found = case(data_folder, name)
    derived = check_sheet(MotorSheet(**found["input"])).derived
    for key, value in found["expected"].items():
        assert derived[key] == pytest.approx(value, rel=found["tol"]), key


def test_published_temperatures(data_folder: Path) -> None:
    found = case(data_folder, "thermal maxon RE 40 148877 48 V")
    derived = check_sheet(
        MotorSheet(**case(data_folder, found["input"]["motor"].join(("motor ", "")))["input"])
    ).derived
    for key, value in found["expected"].items():
        assert derived[key] == pytest.approx(value, rel=found["tol"]), key


def consistent(rng: np.random.Generator) -> MotorSheet:
    """A random motor as its vendor would print it."""
    k, R, U = np.exp(rng.uniform(np.log([5e-3, 0.1, 6.0]), np.log([0.5, 20.0, 300.0])))
    I0, IN = rng.uniform(0.005, 0.02) * U / R, rng.uniform(0.05, 0.2) * U / R
    J = rng.uniform(1e-3, 20e-3) * k * k / R
    rpm = 30.0 / math.pi
    return MotorSheet(
        U=U, R=R, L=rng.uniform(1e-5, 1e-3) * R, kM=k, kn=rpm / k, I0=I0, IN=IN, J=J, tau_m=R * J / k**2,
        n0=rpm * (U - R * I0) / k, nN=rpm * (U - R * IN) / k, MN=k * (IN - I0), MH=k * (U / R - I0), IA=U / R,
        gradient_rpm_per_mNm=1e-3 * rpm * R / k**2, Kt=k, Ke_V_per_krpm=1e3 * k / rpm,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(20))
def test_a_consistent_sheet_has_no_findings_and_one_wrong_number_is_named(seed: int) -> None:
    rng = np.random.default_rng(seed)
    sheet = consistent(rng)
    assert check_sheet(sheet).findings == ()
    for key in ("n0", "nN", "MN", "IA", "kn", "J", "tau_m", "gradient_rpm_per_mNm", "Kt", "Ke_V_per_krpm"):
        wrong = check_sheet(replace(sheet, **{key: 7.0 * getattr(sheet, key)}))
        assert wrong.contradictions, key


def test_contradictions_are_named_with_their_numbers() -> None:
    amax = MotorSheet(R=3.99, L=0.556e-3, kM=0.0352159, J=45.3e-6, tau_m=14.6e-3)
    (inertia,) = check_sheet(amax).contradictions
    assert inertia.name == "inertia against tau_m (factor 10)"
    assert "g cm2" in inertia.text
    (inertia,) = check_sheet(replace(amax, tau_m=None)).contradictions  # by the motor of the table
    assert inertia.name == "inertia against tau_m (factor 10)"
    (warning,) = check_sheet(replace(amax, tau_m=None, R=5.0)).findings
    assert (warning.level, warning.name) == ("warning", "inertia against tau_m (none printed)")
    dcx = motor_card("maxon_dcx22l_9v").sheet
    (order,) = check_sheet(replace(dcx, n0=dcx.nN, nN=dcx.n0)).contradictions
    assert order.name == "n0 below nN"
    assert "exchanged" in order.text
    (constants,) = check_sheet(MotorSheet(Ke_V_per_krpm=51.0, Kt=0.051)).contradictions
    assert constants.name == "Ke against Kt (factor 9.5)"
    assert "rpm and rad/s" in constants.text


def test_conventions_are_warnings() -> None:
    (phase,) = check_sheet(MotorSheet(Ke_V_per_krpm=51.0, Kt=0.487 * math.sqrt(3.0))).findings
    assert phase.level == "warning"
    assert "phase-to-phase" in phase.text


def test_current_limits_are_told_apart() -> None:
    (note,) = check_sheet(RE40).findings
    assert (note.level, note.name) == ("note", "IN is not the thermal limit")
    assert (note.printed, note.expected) == (3.17, pytest.approx(3.406, rel=1e-3))
    names = {f.name: f.level for f in check_sheet(replace(RE40, I_demag=20.0)).findings}
    assert names["stall current above the demagnetising current"] == "warning"
    assert replace(RE40, I_demag=20.0).motor().max_current == 20.0
    assert check_sheet(replace(RE40, I_demag=2.0)).contradictions[0].name == "I_demag below IN"


@pytest.mark.parametrize("name", MOTORS.own)
def test_identities_hold_on_every_card(name: str) -> None:
    card = motor_card(name)
    assert card.name == name
    assert card.title
    assert card.source
    assert [f for f in check_sheet(card.sheet).findings if f.level != "note"] == []
    motor = card.sheet.motor()
    assert 1e-3 < motor.mechanical_time_constant() < 0.05
    assert motor_card(card.title) == card


def test_there_are_enough_motors_and_wrong_names_are_refused() -> None:
    assert len(MOTORS.own) >= 12
    assert motor_card("maxon 148877 48 V").name == "maxon_re40_48v"
    with pytest.raises(UnknownName, match="no motor 'maxon 999'"):
        motor_card("maxon 999")
    with pytest.raises(InputError, match="say which"):
        motor_card("maxon EC 45 flat")


def test_what_a_sheet_lacks_is_named() -> None:
    with pytest.raises(ModelError, match="L; kM, Kt, kn or Ke_V_per_krpm; J or tau_m missing"):
        MotorSheet(U=24.0, R=1.0).motor()
    with pytest.raises(ModelError, match="Rth1, Rth2, tw, ts missing"):
        MotorSheet(R=1.0).thermal()
    for key in ("J", "R", "L", "kM"):
        for value in (0.0, -1.0, math.nan, math.inf):
            with pytest.raises(ModelError, match=key):
                replace(RE40, **{key: value})
    inferred = replace(RE40, J=None).motor()
    assert inferred.rotor_inertia == pytest.approx(RE40.J, rel=0.01)

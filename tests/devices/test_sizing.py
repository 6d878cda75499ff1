"""Load cycles, and which motor and gear make them."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.devices import MOTORS, GearChoice, LoadCycle, SizingLimits, best_ratio, motor_card, select_drive
from holonom.errors import ModelError, ShapeError

CARDS = [motor_card(name) for name in MOTORS.own]
GEARS = [GearChoice(n, 0.8) for n in (5.0, 14.0, 26.0, 43.0, 66.0, 100.0)]
MOVE = LoadCycle.move(1.5708, 0.5, 0.02, friction=0.05)


def case(data_folder: Path, start: str) -> dict[str, Any]:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text())
    return next(one for one in cases if one["id"].startswith(start))


def test_published_cycle(data_folder: Path) -> None:
    found = case(data_folder, "load cycle")
    g = found["input"]
    cycle = LoadCycle.move(g["angle"], g["time"], g["inertia"], friction=g["friction"])
    values = (np.abs(cycle.acceleration).max(), cycle.peak_speed, cycle.peak_torque, cycle.rms_torque)
    names = ("acceleration", "peak_speed", "peak_torque", "rms_torque")
    for name, value in zip(names, values, strict=True):
        assert value == pytest.approx(found["expected"][name], rel=found["tol"]), name


def test_published_ratio(data_folder: Path) -> None:
    found = case(data_folder, "best ratio")
    g = found["input"]
    assert best_ratio(g["J_motor"], g["J_load"]) == pytest.approx(found["expected"]["ratio"], rel=found["tol"])
    ratios = np.linspace(20.0, 60.0, 100001)
    best = ratios[np.argmax(ratios / (g["J_load"] + ratios**2 * g["J_motor"]))]
    assert best == pytest.approx(best_ratio(g["J_motor"], g["J_load"]), rel=1e-4)


def test_a_move_covers_its_angle_and_balances_its_energy() -> None:
    cycle = LoadCycle.move(-2.0, 0.7, 0.03, friction=0.1, load=0.4, dwell=0.2)
    middle = 0.5 * (cycle.start + cycle.end)
    assert np.sum(cycle.duration * middle) == pytest.approx(-2.0)
    work = np.sum(cycle.duration * middle * cycle.torque)
    assert work == pytest.approx(2.0 * 0.1 - 2.0 * 0.4)  # friction, and the load that goes down
    assert cycle.time == pytest.approx(0.9)


def test_samples_make_the_same_cycle() -> None:
    time = np.linspace(0.0, 0.5, 3001)
    speed = np.interp(time, [0.0, 0.5 / 3, 1.0 / 3, 0.5], [0.0, 4.7124, 4.7124, 0.0])
    torque = 0.02 * np.gradient(speed, time) + 0.05
    sampled = LoadCycle.sampled(time, speed, torque, inertia=0.02)
    assert sampled.rms_torque == pytest.approx(MOVE.rms_torque, rel=2e-3)
    assert sampled.peak_speed == pytest.approx(MOVE.peak_speed, rel=1e-4)


def test_a_peak_of_one_sample_is_not_averaged_away() -> None:
    cycle = LoadCycle.sampled([0.0, 1.0, 3.0], [0.0, 2.0, 0.0], [1.0, -3.0, 0.0])
    assert (cycle.time, cycle.peak_torque, cycle.peak_speed) == (3.0, 3.0, 2.0)
    assert cycle.rms_torque == pytest.approx(np.sqrt((0.5 * 1.0 + 1.5 * 9.0) / 3.0))
    assert cycle.acceleration == pytest.approx([2.0, 2.0, -1.0, -1.0])


@pytest.mark.parametrize("seed", range(5))
def test_a_choice_is_what_an_independent_run_of_the_motor_takes(seed: int) -> None:
    """Currents and voltages by finely stepping the move and the power balance of motor, gear and load."""
    rng = np.random.default_rng(seed)
    angle, time, inertia = rng.uniform(0.5, 3.0), rng.uniform(0.5, 1.5), rng.uniform(0.01, 0.05)
    cycle = LoadCycle.move(angle, time, inertia, friction=0.1, load=0.2, dwell=0.3)
    fitting, others = select_drive(cycle, CARDS[:1], [GearChoice(30.0, 0.7)])
    (choice,) = (*fitting, *others)
    motor = choice.motor.sheet.motor()
    n = 9000
    at = (np.arange(n) + 0.5) * (time + 0.3) / n
    a = np.select([at < time / 3, at < 2 * time / 3, at < time], [1.0, 0.0, -1.0], 0.0) * 4.5 * angle / time**2
    w = np.cumsum(a) * (time + 0.3) / n
    load = inertia * a + 0.2 + np.where(at < time, 0.1, 0.0)
    out = load * w
    w_motor = np.where(out >= 0.0, out / 0.7, out * 0.7)
    torque = np.where(np.abs(w) > 1e-6, w_motor / np.where(w == 0.0, 1.0, w) / 30.0, load / 30.0)
    torque = torque + motor.rotor_inertia * 30.0 * a
    current = torque / motor.torque_constant + np.where(at < time, motor.no_load_current, 0.0)
    assert choice.rms_current == pytest.approx(math.sqrt(np.mean(current**2)), rel=5e-3)
    assert choice.peak_current == pytest.approx(np.abs(current).max(), rel=5e-3)
    voltage = motor.resistance * current + motor.back_emf_constant * 30.0 * w
    assert choice.peak_voltage == pytest.approx(np.abs(voltage).max(), rel=2e-2)


def test_choices_are_ranked_by_size_and_others_say_why() -> None:
    fitting, others = select_drive(MOVE, CARDS, GEARS)
    assert len(fitting) + len(others) == len(CARDS)
    assert len(fitting) >= 2
    sizes = [c.motor.sheet.torque_constant**2 / c.motor.sheet.R for c in fitting]
    assert sizes == sorted(sizes)
    assert all(c.used <= 1.0 and not c.rejections for c in fitting)
    assert all(c.rejections for c in others)
    for choice in fitting:  # no other gear uses the limits less
        for gear in GEARS:
            one, rest = select_drive(MOVE, [choice.motor], [gear])
            assert (*one, *rest)[0].used >= choice.used or rest


@pytest.mark.parametrize(
    ("cycle", "limits", "name"),
    [
        (replace(MOVE, torque=100.0 * MOVE.torque), SizingLimits(), "torque"),
        (replace(MOVE, start=20.0 * MOVE.start, end=20.0 * MOVE.end), SizingLimits(), "speed"),
        (MOVE, SizingLimits(current=0.1), "current"),
        (replace(MOVE, torque=6.0 + 0.0 * MOVE.torque), SizingLimits(), "thermal"),
        (replace(MOVE, inertia=20.0), SizingLimits(), "inertia ratio"),
        (MOVE, SizingLimits(voltage=5.0), "voltage"),
    ],
)
def test_each_rejection_is_named(cycle: LoadCycle, limits: SizingLimits, name: str) -> None:
    _, (choice,) = select_drive(cycle, [motor_card("maxon_re40_48v")], [GearChoice(26.0, 0.8)], limits)
    assert name in [one.name for one in choice.rejections]
    for one in choice.rejections:
        assert one.value > one.limit
        assert f"{one.value:.4g}" in one.text


def test_what_is_not_known_is_not_taken_and_a_gear_has_its_limit() -> None:
    _, (choice,) = select_drive(MOVE, [motor_card("maxon_amax32")], GEARS)
    assert "unknown" in [one.name for one in choice.rejections]
    _, (choice,) = select_drive(MOVE, [motor_card("maxon_re40_48v")], [GearChoice(26.0, max_torque=0.3)])
    assert [one.name for one in choice.rejections] == ["gear"]


def test_bad_cycles_are_refused() -> None:
    with pytest.raises(ModelError, match=r"time\[2\] is 1 s after 1 s"):
        LoadCycle.sampled([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], [0.0, 1.0, 2.0])
    with pytest.raises(ShapeError, match="two at least"):
        LoadCycle.sampled([0.0], [0.0], [0.0])
    for wrong in ({"time": 0.0}, {"inertia": -1.0}, {"angle": math.nan}):
        with pytest.raises(ModelError):
            LoadCycle.move(**({"angle": 1.0, "time": 1.0, "inertia": 1.0} | wrong))
    with pytest.raises(ModelError, match="no gear"):
        select_drive(MOVE, CARDS, [])
    with pytest.raises(ModelError, match="ratio"):
        GearChoice(0.0)

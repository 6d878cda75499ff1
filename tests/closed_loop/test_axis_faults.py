"""The watch over a drive: every fault is named in time and holds its speed; a healthy axis raises no alarm."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from random_axes import ramp, random_axis, top_speed, torque

from holonom.closed_loop.axis import AxisRun
from holonom.closed_loop.axis_faults import AxisFault
from holonom.control import design_cascade
from holonom.control.servo.causes import Cause
from holonom.errors import OutOfLimits, UnknownName
from holonom.sim import Axis, simulate_axis

NAMES = {
    "channel_a_stuck": Cause.CHANNEL_STUCK,
    "channel_b_stuck": Cause.CHANNEL_STUCK,
    "encoder_dead": Cause.ENCODER_DEAD,
    "line_broken": Cause.LINE_BROKEN,
    "channels_swapped": Cause.CHANNELS_SWAPPED,
    "edges_lost": Cause.EDGES_LOST,
    "wrong_counts": Cause.WRONG_COUNTS,
    "index_stuck": Cause.INDEX_MISSING,
    "bad_frames": Cause.CHECKSUM,
    "phase_lost": Cause.PHASE_LOST,
}
BREAKS = 0.7  # s


def broken(kind: str, axis: Axis, true: Axis, speed: float, load: float, size: float | None) -> tuple[AxisRun, float]:
    """A run up to a speed (rad/s of the joint) with a fault in it, and the greatest motor speed of the healthy one."""
    gains = design_cascade(axis.servo_axis())
    slow = kind in ("edges_lost", "index_stuck", "wrong_counts")
    turns = 6.0 * 2.0 * math.pi / (speed * axis.gear.ratio) if slow else 0.0
    reference = ramp(speed, 0.3, 1000 + min(int(1000 * turns), 5000))
    fault = AxisFault(kind, 0.0 if kind == "wrong_counts" else BREAKS, size)
    runs = [
        simulate_axis(true, gains, reference, loop="speed", load_torque=load, known=axis, faults=faults)
        for faults in ((), (fault,))
    ]
    assert not runs[0].events
    return runs[1], float(np.abs(runs[0].motor_speed).max())


@pytest.mark.parametrize("kind", NAMES)
def test_a_fault_is_named_in_time_and_holds_its_speed(kind: str) -> None:
    """From 5 % of the no-load speed up: within 5 ms, by the index within two turns; never above 1.1 x the reference."""
    for seed in range(25):
        rng = np.random.default_rng([11, seed])
        axis, true = random_axis(rng)
        speed = rng.uniform(0.055, 0.75) * top_speed(axis)
        load = torque(axis, rng.uniform(0.0 if kind == "phase_lost" else -0.2, 0.2))
        size = None
        if kind == "wrong_counts":
            size = 4 * round(axis.encoder.counts_per_rev * rng.choice([0.5, 0.95, 1.024, 2.0]) / 4)
        run, healthy = broken(kind, axis, true, speed, load, size)
        assert run.events, (seed, "not found")
        assert run.events[0].cause == NAMES[kind], (seed, run.events[0])
        turn = 2.0 * math.pi / (speed * axis.gear.ratio)
        turns = max(
            2.0, 2.0 / (1e-3 * axis.encoder.counts_per_rev) + 1.0
        )  # of a coarse encoder: two edges must be lost
        late = {"edges_lost": turns * turn + 4e-3, "index_stuck": 2.0 * turn + 4e-3, "wrong_counts": 0.3 + 2.0 * turn}
        begins = 0.0 if kind == "wrong_counts" else BREAKS
        assert run.events[0].time - begins <= late.get(kind, 5e-3) + 1e-9, seed
        assert np.abs(run.motor_speed).max() <= max(1.1 * speed * axis.gear.ratio, 1.02 * healthy), seed
        assert abs(run.motor_speed[-1]) < 1e-6, seed
        assert run.phase[-1] == 0
        assert run.events[0].first
        assert not any(event.first for event in run.events[1:])


@pytest.mark.parametrize("kind", ["channel_a_stuck", "encoder_dead", "line_broken", "channels_swapped", "bad_frames"])
def test_a_slow_axis_stays_slow(kind: str) -> None:
    """Below 5 % of the no-load speed a fault may go unseen, but never beyond those (without a gap to rattle in)."""
    for seed in range(25):
        rng = np.random.default_rng([12, seed])
        axis, true = (dataclasses.replace(one, gap=0.0) for one in random_axis(rng))
        speed = rng.uniform(0.002, 0.02) * top_speed(axis)
        run, healthy = broken(kind, axis, true, speed, torque(axis, rng.uniform(-0.2, 0.2)), None)
        limit = 0.05 * top_speed(axis) * axis.gear.ratio
        assert np.abs(run.motor_speed).max() <= max(limit, 1.02 * healthy), seed


def test_a_thousand_healthy_axes_raise_no_alarm() -> None:
    for seed in range(1000):
        rng = np.random.default_rng([13, seed])
        axis, true = random_axis(rng)
        n, top = 600, top_speed(axis)
        load = torque(axis, rng.uniform(-0.4, 0.4)) * np.ones(n)
        load[: n // 2] *= rng.integers(2)
        kind = rng.integers(4)
        if kind == 0:
            reference = np.cumsum(ramp(rng.uniform(0.01, 0.8) * top, rng.uniform(0.05, 0.4), n)) * 1e-3
        elif kind == 1:
            reference = np.full(n, rng.uniform(-3.0, 3.0))
        elif kind == 2:
            reference = np.sin(np.arange(n) * 1e-3 * rng.uniform(1.0, 40.0)) * rng.uniform(0.1, 0.9) * top
        else:
            reference = np.where(np.arange(n) < n // 2, 1.0, -1.0) * rng.uniform(0.01, 0.8) * top
        loop = "position" if kind < 2 else "speed"
        gains = design_cascade(axis.servo_axis())
        run = simulate_axis(true, gains, reference, loop=loop, load_torque=load, known=axis)
        assert not run.events, (seed, run.events)


def test_an_axis_that_is_blocked_is_told_from_a_dead_encoder() -> None:
    from test_axis import PLAIN

    gains = design_cascade(PLAIN.servo_axis())
    run = simulate_axis(PLAIN, gains, ramp(100.0, 0.1, 400), loop="speed", faults=[AxisFault("blocked", 0.3)])
    assert run.events[0].cause == Cause.BLOCKED
    assert run.phase[-1] == 0


def test_unsupervised_a_dead_encoder_runs_away() -> None:
    from test_axis import RUBBING  # a small axis

    from holonom.machine.axis.drive import DriveSettings

    gains = design_cascade(RUBBING.servo_axis())
    run = simulate_axis(
        RUBBING, gains, np.full(1500, 100.0), loop="speed", drive=DriveSettings(supervised=False),
        faults=[AxisFault("encoder_dead", 0.5)],
    )  # fmt: skip
    assert run.motor_speed.max() > 700.0


@pytest.mark.parametrize(
    ("make", "error", "text"),
    [
        (lambda: AxisFault("gremlin"), UnknownName, "channel_a_stuck"),
        (lambda: AxisFault("encoder_dead", -1.0), OutOfLimits, "time is -1.0 s"),
        (
            lambda: AxisFault("edges_lost", 0.0, 2.0),
            OutOfLimits,
            "edges_lost of size 2.0; it must lie within 1e-06 and 1",
        ),
    ],
)
def test_bad_faults_are_named(make, error: type[Exception], text: str) -> None:
    with pytest.raises(error, match=text):
        make()


def test_faults_that_exclude_each_other() -> None:
    from test_axis import PLAIN

    gains = design_cascade(PLAIN.servo_axis())
    with pytest.raises(OutOfLimits, match="another fault of the same lines"):
        simulate_axis(PLAIN, gains, [0.0], faults=["encoder_dead", "channels_swapped"])
    with pytest.raises(OutOfLimits, match="all break at one time"):
        simulate_axis(PLAIN, gains, [0.0], faults=[AxisFault("encoder_dead", 0.1), AxisFault("phase_lost", 0.2)])

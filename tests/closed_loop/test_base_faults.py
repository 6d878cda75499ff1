"""What breaks of bases of any wheels is found, named, and driven on without or stopped; slip by sensors of inertia."""

from __future__ import annotations

import numpy as np
import pytest

from holonom.app.about.drive_bench.bases import BASES
from holonom.closed_loop import BaseLog, simulate_base
from holonom.machine import PATHS, PathLimits, plan_path
from holonom.mobile import SlipStatus
from holonom.mobile.base.drivable import moves_sideways
from holonom.mobile.drive.sized import sized_base_drive
from holonom.sim import ICE, BaseFault, Floor, RectangularPatch

BROKEN = 4.0  # s
EIGHT = {
    sideways: plan_path(
        PATHS.make("figure_of_eight", {"size": 4.0}), PathLimits(1.0, 1.0), heading="fixed" if sideways else "tangent"
    )
    for sideways in (True, False)
}
CHECKED = [name for name in BASES if name not in ("omni", "mecanum", "segway", "skid_steer")]
STEERED = [name for name in BASES if BASES[name]().steered]


def run(name: str, *faults: BaseFault, floor: Floor = Floor(), seed: int = 1) -> BaseLog:
    base = BASES[name]()
    path = EIGHT[moves_sideways(base)]
    return simulate_base(
        base, sized_base_drive(base, 2.0, 2.0), path, faults=faults, floor=floor, rng=np.random.default_rng(seed)
    )


def said(log: BaseLog, source: str = "motor watch") -> list[tuple[float, str]]:
    return [(float(event.time), event.text) for event in log.events if event.source == source]


def missed(log: BaseLog) -> float:
    return float(np.sqrt((log.path_error**2).mean()))


@pytest.mark.parametrize("name", CHECKED)
def test_nothing_is_found_where_nothing_is_broken(name: str) -> None:
    """On the level and uphill; the path is kept there, too, though the accelerometers show the slope."""
    for floor, most in ((Floor(), 0.02), (Floor(slope=np.radians(5.0), uphill=0.3), 0.07)):
        log = run(name, floor=floor)
        assert log.ended == "done"
        assert not log.dead.any()
        assert (log.status == SlipStatus.NO_SLIP).all()
        assert missed(log) < most


@pytest.mark.parametrize("name", [*CHECKED, "skid_steer", "mecanum"])
def test_an_encoder_that_is_stuck_is_named(name: str) -> None:
    driven = BASES[name]().driven[0]
    log = run(name, BaseFault(BROKEN, driven, "frozen"))
    (time, text), *others = said(log)
    assert text.startswith(f"the encoder of {driven} is stuck")
    assert time - BROKEN < 0.2
    assert not others
    if log.ended == "done":
        assert missed(log) < 0.05
    else:
        assert log.ended == "stopped"
        assert "the base stops" in text
        assert np.abs(log.twist[-1]).max() < 0.25


@pytest.mark.parametrize("name", CHECKED)
def test_a_dead_motor_is_driven_on_without_or_stopped(name: str) -> None:
    """By what is left: motions that its motors drive, of those that its wheels allow."""
    base = BASES[name]()
    log = run(name, BaseFault(BROKEN, base.driven[0]))
    (_, text), *_ = said(log)
    assert text.startswith(f"the motor of {base.driven[0]} does not do as told")
    if name in ("differential", "tricycle", "bicycle", "sphere"):
        assert log.ended == "stopped"
        ways = 1 if base.steered else 2
        assert f"the others drive {'none' if len(base.driven) == 1 else 1} of the {ways} ways to move" in text
    else:
        assert log.ended == "done"
        assert missed(log) < 0.02


@pytest.mark.parametrize("name", STEERED)
def test_steering_that_is_stuck_is_named(name: str) -> None:
    """A base that can move sideways keeps its path and turns about the wheel; others stop."""
    base = BASES[name]()
    wheel = next(wheel.name for wheel in base.wheels if wheel.kind == "steered")
    log = run(name, BaseFault(BROKEN, wheel, "stuck"))
    (_, text), *others = said(log)
    assert text.startswith(f"the steering of {wheel} is stuck")
    assert not others
    if name == "swerve":
        assert log.ended == "done"
        assert missed(log) < 0.03
        assert np.ptp(log.pose[:, 2]) > 1.0
    else:
        assert log.ended == "stopped"


def test_a_wheel_that_comes_off_is_named() -> None:
    log = run("differential", BaseFault(BROKEN, "left", "off"))
    (time, text), *_ = said(log)
    assert text.startswith("left pushes nothing, it is off or spins")
    assert time - BROKEN < 5.0  # it has to be asked for some push
    assert log.ended == "stopped"


@pytest.mark.parametrize("name", ["differential", "tricycle", "ackermann", "synchro"])
def test_slip_is_found_by_inertia(name: str) -> None:
    """It starts on ice: wheels spin, and the base does not move as they say."""
    log = run(name, floor=Floor(patches=(RectangularPatch((0.0, 0.0), 0.8, 0.8, ICE),)))
    slips = np.abs(log.slip) > 0.2
    assert slips.any()
    first = log.time[slips.any(axis=1)][0]
    found = log.time[log.status == SlipStatus.SLIP]
    assert 0.0 <= found[0] - first < 0.3 or abs(found[0] - first) < 0.1
    early = log.time < first + 1.0
    assert not (log.named & (np.abs(log.slip) < 0.02))[early].any(axis=0).all()


def test_a_slip_that_accelerometers_cannot_follow_is_ambiguous() -> None:
    """Wheels of a bicycle that spin for long: its one driven wheel tells nothing, accelerometers drift."""
    ice = RectangularPatch((0.0, 0.0), 30.0, 30.0, ICE)
    log = run("bicycle", floor=Floor(patches=(ice,)))
    assert (log.status == SlipStatus.AMBIGUOUS).any()

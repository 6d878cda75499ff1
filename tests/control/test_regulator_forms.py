"""Conformance of every form of `REGULATORS`, and each form against its z-transform by SciPy."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete, lfilter

from holonom.arrays import Array
from holonom.control import REGULATORS, respond
from holonom.control.regulators import Regulator, four_sample_rate
from holonom.control.regulators.forms.pid_series import to_parallel, to_series
from holonom.errors import InputError, NotFinite, OutOfLimits, ShapeError, UnknownName

DT, LIMITS = 0.05, (-3.0, 3.0)
ALL = list(REGULATORS)


def example(name: str, **other: Any) -> dict[str, Any]:
    """Gains of a form: its examples, where it has such."""
    fields = {f.name: f.parameter.example for f in REGULATORS[name].fields}
    return {key: value for key, value in fields.items() if value is not None} | {
        key: value for key, value in other.items() if key in fields
    }


def made(name: str, **other: Any) -> Regulator:
    return REGULATORS.make(name, example(name, **other))


SWITCHES = [name for name in ALL if made(name).switches]
LINEAR = [name for name in ALL if not made(name).switches]
every = pytest.mark.parametrize("name", ALL)
linear = pytest.mark.parametrize("name", LINEAR)


@pytest.mark.parametrize("case", ["regulator sequences, step and reversal", "recoil after a spike"])
def test_published_sequences(case: str, data_folder: Path) -> None:
    cases = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    found = next(each for each in cases if each["id"] == case)
    given, wanted = found["input"], found["expected"]
    forms: dict[str, list[tuple[str, dict[str, float]]]] = {
        "foxboro": [("foxboro", {})],
        "reset_g1": [("reset", {"g": 1.0})],
        "reset_g02": [("reset", {"g": 0.2})],
        "incremental_PID": [("incremental", {"Td": given["Td"]}), ("recursive", {"Td": given["Td"]})],
    }
    assert set(wanted) == set(forms)
    for key, ways in forms.items():
        for name, gains in ways:
            u = respond(
                name,
                given["error"],
                0.0,
                dt=given["Ts"],
                limits=given["limits"],
                Kc=given["Kc"],
                Ti=given["Ti"],
                **gains,
            )
            np.testing.assert_allclose(u, wanted[key], rtol=0.0, atol=found["tol"])


@every
def test_limits_are_held(name: str) -> None:
    rng = np.random.default_rng(1)
    r, y = 10.0 ** rng.uniform(-2, 4, (2, 400)) * rng.choice([-1.0, 1.0], (2, 400))
    u = respond(name, r, y, dt=DT, limits=LIMITS, **example(name, Td=0.2, T=0.1))
    assert np.all((u >= -3.0) & (u <= 3.0))
    assert {-3.0, 3.0} <= set(u.tolist())


@every
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_windup(name: str, side: float) -> None:
    """After any time at a limit the output leaves it as soon as the error turns (switching: within a period)."""
    r = np.concatenate([np.full(20_000, 10.0 * side), np.full(20, -2.0 * side)])
    u = respond(name, r, 0.0, dt=DT, limits=LIMITS, **example(name))
    assert u[19_999] == 3.0 * side
    assert side * u[20_000:].min() < 2.7 or name in SWITCHES
    assert np.all(side * u[20_000:] < 2.7) or name == "time_proportional"
    assert np.mean(side * u[20_000:]) < 2.0


@every
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("before", [-0.4, 0.0, 0.4])
def test_recoil(name: str, side: float, before: float) -> None:
    """One wrong measurement of 20: forms that recoil are at the other limit after it, others where they were."""
    regulator = made(name, Ti=1e6, hysteresis=0.1)
    r = np.zeros(80)
    r[20] = 20.0 * side
    u = side * respond(name, r, 0.0, dt=DT, limits=LIMITS, start=before, **example(name, Ti=1e6, hysteresis=0.1))
    assert u[20] == 3.0
    assert REGULATORS[name].help.endswith("no recoil" if not regulator.recoils else "; recoils") or name in (
        "back_calculation",
    )
    if regulator.recoils:
        assert u[21] == -3.0
    elif name == "time_proportional":
        assert np.mean(u[40:60]) == pytest.approx(np.mean(u[:20]), abs=1e-12)
    elif name in SWITCHES:
        assert u[21:].min() >= u[:20].min()
    else:
        np.testing.assert_allclose(u[21:], side * before, atol=1e-4)


def test_recoil_is_no_matter_of_one_spike_size() -> None:
    """Those said to recoil do so for every spike that saturates; FOXBORO, conditional, back-calculation for none."""
    for size in (2.0, 5.0, 1e3):
        e = np.array([0.0, size, 0.0, 0.0])
        for name in LINEAR:
            u = respond(name, e, 0.0, dt=0.1, limits=LIMITS, Kc=2.0, Ti=1e6)
            clipped = max(2.0 * size - 3.0, 0.0)
            wanted = -min(clipped, 3.0) if made(name).recoils else 0.0
            assert u[2] == pytest.approx(wanted, abs=1e-3), (name, size)


@linear
def test_bumpless_start(name: str) -> None:
    rng = np.random.default_rng(2)
    for _ in range(20):
        u0, r, y = rng.uniform(-3.0, 3.0), rng.normal(), rng.normal()
        given = example(name, Kc=rng.uniform(0.1, 5.0), Ti=rng.uniform(0.1, 5.0), Td=0.3, T=0.1, b=0.4)
        u = respond(name, np.full(2, r), y, dt=DT, limits=LIMITS, start=u0, **given)
        assert u[0] == pytest.approx(u0, abs=1e-9)
        assert abs(u[1] - u0) <= given["Kc"] * abs(r - y) * DT / given["Ti"] * 1.0000001 + 1e-9  # what I takes, no more


@linear
def test_bumpless_switch(name: str) -> None:
    """By hand, on, by hand again and on: nothing jumps where r and y do not."""
    rng = np.random.default_rng(3)
    r, y, hand = rng.normal(size=60), rng.normal(size=60), np.full(60, math.nan)
    hand[:20] = rng.uniform(-3.0, 3.0, 20)
    hand[40:50] = rng.uniform(-3.0, 3.0, 10)
    for k in (20, 50):
        r[k], y[k] = r[k - 1], y[k - 1]
    u = respond(name, r, y, dt=DT, limits=LIMITS, manual=hand, **example(name, Td=0.3, T=0.1))
    np.testing.assert_array_equal(u[~np.isnan(hand)], hand[~np.isnan(hand)])
    assert u[20] == pytest.approx(u[19], abs=1e-9)
    assert u[50] == pytest.approx(u[49], abs=1e-9)


@pytest.mark.parametrize("name", SWITCHES)
def test_start_of_what_switches(name: str) -> None:
    """The position nearest to the output before, of a time-proportional form the mean over its period."""
    for before in (-3.0, 3.0):
        u = respond(name, np.zeros(20), 0.0, dt=DT, limits=LIMITS, start=before, **example(name, hysteresis=0.2))
        assert np.mean(u) == pytest.approx(0.0 if name in ("on_off_3", "on_off_5") else before, abs=1e-12)


@every
def test_the_rate_of_the_reference_is_limited(name: str) -> None:
    r = np.concatenate([np.full(200, 2.0), np.full(200, -1.0)])
    ramp = np.concatenate([0.517 + 0.0437 * np.arange(1, 201), 2.0 - 0.0437 * np.arange(1, 201)])
    ramp = np.concatenate([np.minimum(ramp[:200], 2.0), np.maximum(ramp[200:], -1.0)])
    given = example(name, Td=0.2, T=0.1)
    u = respond(name, r, 0.517, dt=DT, limits=LIMITS, rate=0.0437 / DT, **given)
    np.testing.assert_allclose(u, respond(name, ramp, 0.517, dt=DT, limits=LIMITS, **given), atol=1e-9)


@every
def test_not_a_number(name: str) -> None:
    """Refused in a sequence; the compiled step holds output and state."""
    given = example(name, Td=0.2, T=0.1)
    for r, y in ((math.nan, [0.0]), ([1.0], math.inf)):
        with pytest.raises(NotFinite):
            respond(name, r, y, dt=DT, limits=LIMITS, **given)
    regulator = REGULATORS.make(name, given)
    params = regulator.settings.params(DT)
    state = regulator.start(params, 0.0, 0.0, 0.0, *LIMITS)
    for error in (0.2, 0.7, -0.3):
        u, state = regulator.step(params, state, error, 0.0, *LIMITS)
    for bad in (math.nan, math.inf, -math.inf):
        held, after = regulator.step(params, state, 0.1, bad, *LIMITS)
        assert held == u
        if name != "time_proportional":  # its period goes on
            assert after == state


def z_domain(num: list[float], den: list[float], dt: float, method: str, e: Array) -> Array:
    """A transfer function in s, made discrete by SciPy, from rest."""
    kind = {"backward": "backward_diff", "tustin": "bilinear", "zoh": "zoh"}[method]
    top, bottom, _ = cont2discrete((num, den), dt, kind)
    return lfilter(np.ravel(top), bottom, e)


def parallel(Kc: float, Ti: float, Td: float, T: float, b: float = 1.0, c: float = 1.0) -> tuple[Any, Any]:
    """`K_c (b + 1/(s T_i) + c s T_d/(1 + s T))` as numerator and denominator."""
    num = Kc * (b * np.array([Ti * T, Ti, 0.0]) + np.array([0.0, T, 1.0]) + c * np.array([Ti * Td, 0.0, 0.0]))
    return num, np.array([Ti * T, Ti, 0.0])


FREE = (-1e9, 1e9)


@pytest.mark.parametrize("method", ["backward", "tustin", "zoh"])
@pytest.mark.parametrize("name", ["pid_parallel", "pid_series", "pid_two_dof", "recursive", "back_calculation"])
def test_unsaturated_it_is_its_z_transform(name: str, method: str) -> None:
    rng = np.random.default_rng(4)
    r, y = rng.normal(size=(2, 60))
    for _ in range(5):
        Kc, Ti, Td, T = rng.uniform(0.2, 3.0), rng.uniform(0.5, 3.0), rng.uniform(0.1, 0.5), rng.uniform(0.05, 0.3)
        weights = {"b": 0.6, "c": 0.3} if name == "pid_two_dof" else {}
        u = respond(name, r, y, dt=DT, limits=FREE, Kc=Kc, Ti=Ti, Td=Td, T=T, method=method, **weights)
        if name == "pid_series":
            num = Kc * np.polymul([Ti, 1.0], [Td, 1.0])
            wanted = z_domain(num, np.polymul([Ti, 0.0], [T, 1.0]), DT, method, r - y)
        else:
            wanted = z_domain(*parallel(Kc, Ti, Td, T, **weights), DT, method, r)
            wanted -= z_domain(*parallel(Kc, Ti, Td, T), DT, method, y)
        np.testing.assert_allclose(u, wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", [n for n in LINEAR if n not in ("foxboro",)])
def test_unsaturated_pi_by_backward_differences(name: str) -> None:
    e = np.random.default_rng(5).normal(size=200)
    u = respond(name, e, 0.0, dt=DT, limits=FREE, Kc=1.7, Ti=0.8)
    np.testing.assert_allclose(u, z_domain([1.7 * 0.8, 1.7], [0.8, 0.0], DT, "backward", e), rtol=1e-9, atol=1e-9)


def test_unsaturated_foxboro() -> None:
    e = np.random.default_rng(6).normal(size=200)
    beta = math.exp(-DT / 0.8)
    u = respond("foxboro", e, 0.0, dt=DT, limits=FREE, Kc=1.7, Ti=0.8)
    np.testing.assert_allclose(u, lfilter([1.7, -1.7 * beta], [1.0, -1.0], e), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["pid_parallel", "incremental", "recursive"])
def test_ideal_pid(name: str) -> None:
    """Specification 04.1: `b0 = Kc (1 + Ts/Ti + Td/Ts)`, `b1 = -Kc (1 + 2 Td/Ts)`, `b2 = Kc Td/Ts`."""
    e = np.random.default_rng(7).normal(size=100)
    b = [2.0 * (1 + DT + 0.3 / DT), -2.0 * (1 + 0.6 / DT), 2.0 * 0.3 / DT]
    u = respond(name, e, 0.0, dt=DT, limits=FREE, Kc=2.0, Ti=1.0, Td=0.3)
    np.testing.assert_allclose(u, lfilter(b, [1.0, -1.0], e), rtol=1e-9, atol=1e-9)


def test_series_and_parallel_are_one_transfer_function() -> None:
    s = 1j * np.geomspace(1e-3, 1e3, 40)
    rng = np.random.default_rng(8)
    for _ in range(20):
        Kc, Ti, Td = rng.uniform(0.1, 5.0, 3)
        Td *= Ti / 5.0  # Ti > Td in series form, the larger first
        p = to_parallel(Kc, Ti, Td)
        series = Kc * (1 + s * Ti) / (s * Ti) * (1 + s * Td)
        np.testing.assert_allclose(p.Kc * (1 + 1 / (s * p.Ti) + s * p.Td), series, rtol=1e-12)
        np.testing.assert_allclose(to_series(*p), (Kc, Ti, Td), rtol=1e-9)
    assert to_series(*to_parallel(2.0, math.inf, 0.3)) == (2.0, math.inf, 0.3)
    with pytest.raises(OutOfLimits, match=r"at least 4 Td, which is 4\.0"):
        to_series(1.0, 3.0, 1.0)


def test_four_samples_have_half_the_noise() -> None:
    rng = np.random.default_rng(9)
    x = rng.normal(size=200_000)
    rates = (x[3:] + 3.0 * (x[2:-1] - x[1:-2]) - x[:-3]) / 6.0
    weights = [four_sample_rate(*row, 1.0) for row in np.eye(4)]
    np.testing.assert_allclose(weights, np.array([1.0, 3.0, -3.0, -1.0]) / 6.0)
    assert np.linalg.norm(weights) == pytest.approx(math.sqrt(20.0) / 6.0)
    assert np.std(rates) == pytest.approx(0.745, abs=0.01)
    assert np.std(np.diff(x)) == pytest.approx(1.414, abs=0.01)
    assert four_sample_rate(7.0, 5.0, 3.0, 1.0, 0.5) == pytest.approx(4.0)  # exact for a line


def test_a_derivative_over_four_samples_in_a_regulator() -> None:
    y = np.random.default_rng(10).normal(size=100)
    b = np.array([1.0, 3.0, -3.0, -1.0]) / (6.0 * DT)
    given: dict[str, Any] = {"dt": DT, "limits": FREE, "Kc": 2.0, "Ti": math.inf, "Td": 0.3, "four_samples": True}
    wanted = -2.0 * (y + 0.3 * lfilter(b, 1.0, y))
    np.testing.assert_allclose(respond("pid_two_dof", 0.0, y, **given), wanted, rtol=1e-9, atol=1e-9)
    with pytest.raises(OutOfLimits, match="four samples with method='zoh'"):
        respond("pid_two_dof", 0.0, y, T=0.1, method="zoh", **given)


def test_positions_and_hysteresis() -> None:
    e = np.array([0.0, 0.6, 0.45, 0.35, -0.6, -0.45, -0.35, 2.0, 1.45, 1.35, -2.0, 0.0])
    given: dict[str, Any] = {"dt": DT, "limits": (-4.0, 4.0)}
    two = respond("on_off_2", e, 0.0, hysteresis=1.0, **given)
    np.testing.assert_array_equal(two, 4.0 * np.array([-1, 1, 1, 1, -1, -1, -1, 1, 1, 1, -1, -1]))
    three = respond("on_off_3", e, 0.0, inner=0.5, hysteresis=0.1, **given)
    np.testing.assert_array_equal(three, 4.0 * np.array([0, 1, 1, 0, -1, -1, 0, 1, 1, 1, -1, 0]))
    five = respond("on_off_5", e, 0.0, inner=0.5, outer=1.5, hysteresis=0.1, **given)
    np.testing.assert_array_equal(five, 2.0 * np.array([0, 1, 1, 0, -1, -1, 0, 2, 2, 1, -2, 0]))
    with pytest.raises(OutOfLimits, match=r"hysteresis is 0\.6, inner 0\.5"):
        respond("on_off_3", e, 0.0, inner=0.5, hysteresis=0.6, **given)
    with pytest.raises(OutOfLimits, match="outer - inner"):
        respond("on_off_5", e, 0.0, inner=0.5, outer=0.4, **given)


def test_time_proportional_has_the_mean_of_its_regulator() -> None:
    e = np.repeat(np.random.default_rng(11).uniform(-0.5, 0.5, 30), 200)  # new at the beginning of each period
    u = respond("time_proportional", e, 0.0, dt=0.01, limits=(0.0, 1.0), start=0.5, Kc=0.3, Ti=50.0, period=2.0)
    assert set(u.tolist()) == {0.0, 1.0}
    wanted = respond("conditional", e[::200], 0.0, dt=2.0, limits=(0.0, 1.0), start=0.5, Kc=0.3, Ti=50.0)
    wanted = np.concatenate([[0.5], wanted[1:]])
    np.testing.assert_allclose(u.reshape(30, 200).mean(axis=1), wanted, atol=0.5 / 200 + 1e-12)
    assert np.all(np.diff(u.reshape(30, 200), axis=1) <= 0.0)  # on first, then off
    with pytest.raises(OutOfLimits, match="two samples at least"):
        respond("time_proportional", e, 0.0, dt=2.0, limits=(0.0, 1.0), Kc=0.3, Ti=50.0, period=2.0)


@pytest.mark.parametrize(
    ("name", "given", "error", "said"),
    [
        ("pid", {}, UnknownName, "no regulator 'pid'; there is back_calculation, conditional"),
        ("reset", {}, InputError, r"Kc, Ti missing; it needs Kc \(gain, .*\), Ti \(integral time"),
        ("reset", {"Kc": 1.0}, InputError, "Ti missing"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "Td": 1.0}, UnknownName, "regulator 'reset' 'Td'; there is Kc, Ti, g"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "g": 1.5}, OutOfLimits, "g is 1.5"),
        ("reset", {"Kc": -1.0, "Ti": 1.0}, OutOfLimits, "Kc is -1.0"),
        ("reset", {"Kc": math.nan, "Ti": 1.0}, OutOfLimits, "Kc is nan"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "dt": 0.0}, OutOfLimits, "dt is 0.0"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "dt": "fast"}, OutOfLimits, "dt is 'fast'"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "limits": (1.0, 1.0)}, OutOfLimits, "limits are"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "limits": 3.0}, OutOfLimits, "limits are 3.0; the lowest and the highest"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "limits": None}, OutOfLimits, "limits are None"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "start": 4.0}, OutOfLimits, "start is 4.0"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "rate": 0.0}, OutOfLimits, "rate is 0.0"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "manual": [0.0]}, ShapeError, "manual has shape"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "manual": [0.0, 4.0]}, OutOfLimits, r"manual\[1\] is 4.0"),
        ("reset", {"Kc": 1.0, "Ti": 1.0, "y": [1.0, 2.0, 3.0]}, ShapeError, "r holds 2 samples, y 3"),
        ("on_off_2", {"limits": (0.0, math.inf)}, OutOfLimits, "needs finite ones"),
        ("pid_parallel", {"Kc": 1.0, "Ti": 1.0, "Td": 1.0, "method": "tustin"}, OutOfLimits, "filtered derivative"),
        ("pid_parallel", {"Kc": 1.0, "Ti": 1.0, "method": "euler"}, UnknownName, "backward, tustin, zoh"),
        ("back_calculation", {"Kc": 1.0, "Ti": 1.0, "Tt": 0.01}, OutOfLimits, "Tt is 0.01"),
    ],
)
def test_refusals(name: str, given: dict[str, Any], error: type[InputError], said: str) -> None:
    with pytest.raises(error, match=said):
        respond(name, **({"r": [1.0, 2.0], "y": 0.0, "dt": DT, "limits": LIMITS} | given))

"""Processes: linear systems, loops with dead time, sampled loops; published figures and closed forms."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import cont2discrete

from holonom.control import processes as p
from holonom.errors import InputError, ModelError, OutOfLimits, ShapeError, UnknownName


@pytest.fixture(scope="module")
def published(data_folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((data_folder / "control" / "control_cases.json").read_text("utf-8"))
    return found


@pytest.fixture(scope="module")
def cases(data_folder: Path) -> dict[str, Any]:
    found = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    return {case["id"]: case for case in found}


KEYS = {
    "RiseTime": "rise_time",
    "SettlingTime": "settling_time",
    "SettlingMin": "settling_min",
    "SettlingMax": "settling_max",
    "Overshoot": "overshoot",
    "Undershoot": "undershoot",
    "Peak": "peak",
    "PeakTime": "peak_time",
    "SteadyState": "steady_state",
}


def test_step_info_as_published(published: dict[str, Any]) -> None:
    """The second case, and times of peaks, were read off a coarse grid by their source: 2 %."""
    for case, tol in zip(published["step_info"]["cases"], (1e-3, 0.02, 1e-3), strict=True):
        which = {}
        if "ss" in case:
            system = p.linear_system(**case["ss"])
            which = {"input": case["input"] - 1, "output": case["output"] - 1}
        else:
            system = p.linear_system(num=case["num"], den=case["den"])
        t, y = p.step_response(system, **which)
        final = p.steady_gain(system, **which)
        found = p.step_info(t, y, steady_state=final, sampled="ss" in case)
        for key, name in KEYS.items():
            if key in case:
                assert getattr(found, name) == pytest.approx(
                    case[key], rel=0.02 if key == "PeakTime" else tol, abs=1e-9
                ), key
        if "SettlingTime_0p5percent" in case:
            tight = p.step_info(t, y, band=0.005, steady_state=final)
            assert tight.settling_time == pytest.approx(case["SettlingTime_0p5percent"], rel=tol)


def test_time_responses_as_published(published: dict[str, Any]) -> None:
    first, *sampled = published["time_response"]["cases"]
    tol = published["time_response"]["tol"]
    t = np.linspace(0.0, 1.0, 10)
    system = p.linear_system(**first["ss"])
    np.testing.assert_allclose(p.step_response(system, t)[1], first["ystep"], atol=tol)
    np.testing.assert_allclose(p.initial_response(system, first["x0"], t)[1], first["yinitial"], atol=tol)
    free = p.linear_system(**(first["ss"] | {"D": [[0]]}))
    np.testing.assert_allclose(p.impulse_response(free, t)[1], first["yimpulse_D0"], atol=tol)
    for case in sampled:
        z = case["tf_z"]
        system = p.linear_system(num=z["num"], den=z["den"], dt=z["dt"])
        y = p.step_response(system, z["dt"] * np.arange(len(case["ystep"])))[1]
        np.testing.assert_allclose(y, case["ystep"], atol=tol)


def test_a_pulse_of_a_sampled_system_is_the_difference_of_its_steps() -> None:
    system = p.linear_system(num=[1.0, 0.5], den=[1.0, -0.9, 0.2], dt=0.5)
    t = 0.5 * np.arange(12)
    step, pulse = p.step_response(system, t)[1], p.impulse_response(system, t)[1]
    np.testing.assert_allclose(np.cumsum(0.5 * pulse), step, atol=1e-12)


def test_margins_as_published(published: dict[str, Any]) -> None:
    plain, expressed = published["margins"]["cases"]
    d = np.polymul(np.polymul([100.0, 1.0], [1.0, 0.22, 1.0]), [0.01, 0.008, 1.0])
    loops = [
        (plain["value"], p.OpenLoop(np.array(plain["num"], float), np.array(plain["den"], float), 0.0)),
        (expressed["value"], p.OpenLoop(8.75 * np.array([4.0, 0.4, 1.0]), d, 0.0)),
    ]
    for (gm, pm, sm, wpc, wgc, wms), loop in loops:
        found = p.loop_figures(loop)
        assert found.stable
        pairs = [(found.gain_margin, gm), (found.phase_margin_deg, float(pm)), (1.0 / found.Ms, sm),
                 (found.phase_crossover, wpc), (found.peak_frequency, wms)]  # fmt: skip
        for value, wanted in pairs:
            assert value == pytest.approx(wanted, rel=published["margins"]["tol"])
        assert math.isnan(found.crossover) if wgc is None else found.crossover == pytest.approx(wgc, rel=2e-3)
    for case in published["margins"]["phase_crossover"]:
        at, value = p.phase_crossings(p.make_process({"num": case["num"], "den": case["den"]}))
        np.testing.assert_allclose(at, case["omega"], rtol=1.5e-3)
        np.testing.assert_allclose(value, case["gain"], rtol=1.5e-3)


def test_ultimate_gain(published: dict[str, Any], cases: dict[str, Any]) -> None:
    for case in published["ultimate_gain_analytic"]:
        found = p.ultimate_gain(p.make_process({"num": case["num"], "den": case["den"]}))
        assert found == pytest.approx((case["Ku"], case["Tu"]), rel=1e-9)
    expected = cases["ultimate 1/(s+1)^3"]["expected"]
    found = p.ultimate_gain(p.make_process(cases["ultimate 1/(s+1)^3"]["input"]))
    assert found == pytest.approx((expected["Ku"], expected["Tu"]), rel=1e-4)
    with pytest.raises(OutOfLimits, match="no gain makes this process swing"):
        p.ultimate_gain(p.make_process({"kind": "two_lags", "lags": [3.0, 1.0]}))


def test_a_published_pid_of_a_motor(published: dict[str, Any]) -> None:
    wanted = published["ctms_speed_pid"]
    motor = next(m for m in published["dc_motors"] if m["name"] == "CTMS DC motor (speed)")
    J, b, K, R, L = (motor[key] for key in ("J", "b", "K", "R", "L"))
    plant = p.make_process({"num": [K], "den": [J * L, J * R + b * L, b * R + K * K]})
    Kp, Ki, Kd = wanted["Kp"], wanted["Ki"], wanted["Kd"]
    loop = p.open_loop(plant, p.Gains(Kp, Kp / Ki, Kd / Kp), "PID")
    found = p.step_info(*p.closed_step(loop, end=8.0), steady_state=1.0)
    for key in ("RiseTime", "SettlingTime", "Overshoot", "Peak", "PeakTime"):
        assert getattr(found, KEYS[key]) == pytest.approx(wanted[key], rel=0.02), key
    open_loop = published["ctms_speed_open_loop"]
    system = p.linear_system(num=plant.num, den=plant.den)
    alone = p.step_info(*p.step_response(system), steady_state=p.steady_gain(system))
    assert alone.steady_state == pytest.approx(open_loop["SteadyState"], rel=1e-9)
    assert alone.settling_time == pytest.approx(open_loop["SettlingTime"], rel=0.01)
    assert alone.rise_time == pytest.approx(open_loop["RiseTime"], rel=0.01)


def test_integrator_with_dead_time(cases: dict[str, Any]) -> None:
    """Peak, times and margin of `e^(-sT)/(2 T s)`, in dead times: exact polynomials by the method of steps."""
    wanted = cases["integrator with dead time e^-s/(2s), unit step"]["expected"]
    for T in (1.0, 0.02):
        loop = p.OpenLoop(np.array([1.0]), np.array([2.0 * T, 0.0]), T)
        t, y = p.closed_step(loop)
        found = p.step_info(t, y, steady_state=1.0)
        assert found.peak == pytest.approx(wanted["peak"], rel=1e-4)
        assert found.peak_time / T == pytest.approx(wanted["peak_time_over_T"], rel=2e-3)
        assert found.rise_time / T == pytest.approx(wanted["rise_10_90_over_T"], rel=1e-3)
        assert found.settling_time / T == pytest.approx(wanted["settling_2_percent_over_T"], rel=1e-3)
        assert p.loop_figures(loop).phase_margin_deg == pytest.approx(wanted["phase_margin_deg"], rel=1e-4)
        piece = (t > T) & (t < 2.0 * T)  # y = (t - T)/2T, then e is 1 - that: exact parabola
        np.testing.assert_allclose(y[piece], (t[piece] / T - 1.0) / 2.0, atol=1e-9)
        piece = (t > 2.0 * T) & (t < 3.0 * T)
        x = t[piece] / T - 2.0
        np.testing.assert_allclose(y[piece], 0.5 + x / 2.0 - x * x / 8.0, atol=1e-6)


def test_a_closed_loop_without_dead_time_is_that_of_an_integrator_of_equations() -> None:
    loop = p.open_loop(p.make_process({"kind": "lags", "lags": [2.0, 1.0, 0.3]}), p.Gains(1.5, 2.0, 0.4), "PID")
    t, y = p.closed_step(loop, prefilter=0.7, end=6.0)
    den, num = np.polyadd(loop.den, loop.num), loop.num
    n = len(den) - 1
    A = np.zeros((n, n))
    A[0], A[1:, :-1] = -den[1:] / den[0], np.eye(n - 1)
    C = np.concatenate([np.zeros(n - len(num)), num]) / den[0]

    def motion(t: float, x: Any) -> Any:
        return A @ x + np.eye(n)[0] * -np.expm1(-t / 0.7)

    x = solve_ivp(motion, (0.0, t[-1]), np.zeros(n), t_eval=t, rtol=1e-9, atol=1e-12).y
    np.testing.assert_allclose(y, C @ x, atol=2e-6)


@pytest.mark.parametrize("gain", [0.3, 0.9, 1.1, 2.0])
def test_stability_with_much_dead_time(gain: float) -> None:
    """P on dead time alone is stable below 1; with a lag, below its ultimate gain."""
    alone = p.make_process({"kind": "dead_time", "dead_time": 2.0})
    assert p.loop_figures(p.open_loop(alone, p.Gains(gain), "P")).stable == (gain < 1.0)
    late = p.make_process({"kind": "lag_dead_time", "lag": 0.1, "dead_time": 2.0})
    Ku, _ = p.ultimate_gain(late)
    for part in (0.98, 1.02, 3.0):
        assert p.loop_figures(p.open_loop(late, p.Gains(part * Ku), "P")).stable == (part < 1.0)


def test_stability_agrees_with_the_roots() -> None:
    rng = np.random.default_rng(1)
    counts = [0, 0]
    for _ in range(60):
        lags = rng.uniform(0.05, 2.0, 3).tolist()
        process = p.make_process({"kind": "lags", "lags": lags, "gain": float(rng.uniform(0.5, 2.0))})
        loop = p.open_loop(process, p.Gains(float(rng.uniform(0.2, 12.0)), float(rng.uniform(0.2, 3.0))))
        stable = bool(np.all(np.roots(np.polyadd(loop.den, loop.num)).real < 0.0))
        assert p.loop_figures(loop).stable == stable
        counts[stable] += 1
    assert min(counts) > 10


def test_sampled_margins_of_the_issue() -> None:
    """PI Kc 3, Ti 1 on `1/((1+s)(1+0.2s))` with one sample of computing; largest gains with 60 deg."""
    process, pi = p.make_process({"kind": "two_lags", "lags": [1.0, 0.2]}), p.Gains(3.0, 1.0)
    for dt, degrees in ((0.02, 57.5), (0.1, 38.8), (0.2, 14.6)):
        found = p.sampled_margin(process, pi, dt)
        assert (found.stable, found.phase_margin_deg) == (True, pytest.approx(degrees, abs=0.05))
    found = p.sampled_margin(process, pi, 0.5)
    assert (found.stable, found.pole) == (False, pytest.approx(1.262, abs=5e-4))
    for dt, gain in ((0.1, 1.60), (0.2, 1.11), (0.5, 0.63)):
        assert p.largest_gain(process, pi, dt) == pytest.approx(gain, rel=0.02)


def test_sampled_p_on_an_integrator(cases: dict[str, Any]) -> None:
    case = cases["sampled P on an integrator, one sample of computing delay"]
    dt, delay = case["input"]["Ts"], case["input"]["delay_samples"]
    process = p.make_process({"kind": "integrating_lag", "integral_time": 1.0})
    found = p.sampled_limits(process, dt, delay_samples=delay)
    assert found._asdict() == pytest.approx(case["expected"], rel=1e-6)
    assert p.sampled_margin(process, p.Gains(1.0), dt, delay_samples=delay).gain_margin == pytest.approx(
        1000.0, rel=1e-6
    )


def test_the_current_loop_of_the_open_cases(cases: dict[str, Any]) -> None:
    case = cases["current loop of RE 40"]
    R, L, dt = (case["input"][key] for key in ("R", "L", "Ts"))
    gains = p.Gains(L / (3.0 * dt), L / R)
    y = p.sampled_step(p.make_process({"num": [1.0], "den": [L, R]}), gains, dt, 40)
    assert gains.Kc == pytest.approx(case["expected"]["Kc"])
    assert 100.0 * (y.max() - 1.0) == pytest.approx(case["expected"]["overshoot_percent"], rel=0.01)
    assert int(y.argmax()) == case["expected"]["samples_to_peak"]


@pytest.mark.parametrize("dead_time", [0.0, 0.3, 0.07, 0.25])
def test_a_held_process_is_exact(dead_time: float) -> None:
    """Its open-loop step at the samples is the continuous one; a dead time may be any part of samples."""
    dt, n = 0.1, 60
    process = p.make_process({"kind": "two_lags", "lags": [1.0, 0.2], "gain": 2.0, "dead_time": dead_time})
    tiny = 1e-9
    y = p.sampled_step(process, p.Gains(tiny), dt, n, delay_samples=0) / tiny
    x = np.maximum(dt * np.arange(n) - dead_time, 0.0)
    exact = 2.0 * (1.0 - (np.exp(-x / 1.0) - 0.2 * np.exp(-x / 0.2)) / 0.8)
    np.testing.assert_allclose(y, exact, atol=1e-6)


def test_a_sampled_loop_against_its_difference_equation() -> None:
    dt = 0.05
    num, den, _ = cont2discrete(([1.0], [0.2, 1.2, 1.0]), dt, "zoh")
    _, b1, b2 = np.ravel(num)
    e1 = u1 = u2 = y1 = y2 = integral = late = 0.0
    wanted = []
    for _ in range(80):
        y = b1 * u1 + b2 * u2 - den[1] * y1 - den[2] * y2
        e = 1.0 - y
        integral += 2.0 * dt / 1.0 * e
        now = 2.0 * e + integral + 2.0 * 0.05 / dt * (e - e1)
        u2, u1, late = u1, late, now  # held one sample later
        y2, y1, e1 = y1, y, e
        wanted.append(y)
    process = p.make_process({"kind": "lags", "lags": [1.0, 0.2]})
    np.testing.assert_allclose(p.sampled_step(process, p.Gains(2.0, 1.0, 0.05), dt, 80), wanted, atol=1e-10)


def test_the_relay_of_the_open_cases(cases: dict[str, Any]) -> None:
    case = cases["relay 1 e^-1s/(1+1s)"]
    found = p.relay_cycle(p.make_process(case["input"]["process"]), case["input"]["relay"], case["input"]["hysteresis"])
    for key, value in case["expected"].items():
        assert getattr(found, key) == pytest.approx(value, rel=1e-4)
    assert found.describing_function_error_percent == pytest.approx(-11.0, abs=0.1)


@pytest.mark.parametrize(("lag", "dead", "h"), [(2.0, 0.5, 0.0), (0.3, 1.0, 0.2), (1.0, 0.1, 0.1)])
def test_limit_cycle_of_a_lag_in_closed_form(lag: float, dead: float, h: float) -> None:
    """From y = -h on it falls for another dead time, then rises: `a = d - (d - h) e^(-L/T)`."""
    found = p.relay_cycle(p.make_process({"kind": "lag_dead_time", "lag": lag, "dead_time": dead}), 1.0, h)
    a = 1.0 - (1.0 - h) * math.exp(-dead / lag)
    assert found.amplitude == pytest.approx(a, rel=1e-9)
    assert found.period == pytest.approx(2.0 * (dead + lag * math.log((1.0 + a) / (1.0 - h))), rel=1e-9)


@pytest.mark.parametrize(
    ("given", "error", "said"),
    [
        ({"kind": "lagg"}, UnknownName, "no kind of process 'lagg'; there is dead_time"),
        ({}, InputError, "kind is None"),
        ({"kind": "lag_dead_time", "gain": 1.0}, InputError, "lag missing"),
        ({"kind": "lag_dead_time", "lag": 1.0, "laag": 1.0}, UnknownName, "'laag'"),
        ({"kind": "lag_dead_time", "lag": 0.0}, OutOfLimits, "lag is 0.0"),
        ({"kind": "lag_dead_time", "lag": math.nan}, OutOfLimits, "lag is nan"),
        ({"kind": "lag_dead_time", "lag": 1.0, "dead_time": -1.0}, OutOfLimits, "dead_time is -1.0"),
        ({"kind": "lags", "lags": []}, ModelError, "lags holds 0 time constants"),
        ({"kind": "two_lags", "lags": [1.0]}, ModelError, "two_lags with 1"),
        ({"num": [1.0], "den": [1.0, -1.0]}, ModelError, "unstable, a pole at 1"),
        ({"num": [1.0], "den": [1.0, -0.2, 1.0]}, ModelError, r"unstable, a pole at 0.1 [+-]0.99"),
        ({"num": [1.0, 0.0, 0.0], "den": [1.0, 1.0]}, ModelError, "not strictly proper"),
        ({"num": [1.0, 1.0], "den": [1.0, 2.0]}, ModelError, "not strictly proper"),
        ({"num": [0.0], "den": [1.0, 2.0]}, ModelError, "not all 0"),
        ({"num": [1.0], "den": [1.0]}, ModelError, "neither lag nor integrator nor dead time"),
        ({"num": [1.0], "den": [1.0] * 30}, ModelError, "den has degree 29"),
        ({"num": [1.0], "den": [1e-30, 1.0]}, ModelError, "coefficients are from 1e-30 to 1"),
        ({"num": [1.0], "den": [1.0, 1.0], "dead_time": 1e-20}, ModelError, "dead_time is 1e-20"),
        ({"num": [-1.0], "den": [1.0, 2.0]}, ModelError, "its gain is negative; give a positive one"),
        ({"num": [1.0, 0.0], "den": [1.0, 2.0, 1.0]}, ModelError, "its gain is 0"),
    ],
)
def test_what_is_no_process(given: dict[str, Any], error: type[InputError], said: str) -> None:
    with pytest.raises(error, match=said):
        p.make_process(given)


def test_refusals_of_linear_systems() -> None:
    with pytest.raises(ModelError, match="not proper"):
        p.linear_system(num=[1, 0, 0], den=[1, 1])
    with pytest.raises(ModelError, match="are needed"):
        p.linear_system(num=[1])
    with pytest.raises(ModelError, match="do not fit"):
        p.linear_system(A=[[1.0]], B=[[1.0], [2.0]], C=[[1.0]], D=[[0.0]])
    with pytest.raises(OutOfLimits, match=r"dt is 0\.0"):
        p.linear_system(num=[1], den=[1, 1], dt=0.0)
    with pytest.raises(ModelError, match="does not settle"):
        p.step_response(p.linear_system(num=[1], den=[1, 0]))
    with pytest.raises(ModelError, match="does not settle"):
        p.step_response(p.linear_system(num=[1], den=[1, -2], dt=1.0))
    with pytest.raises(OutOfLimits, match="evenly spaced from 0"):
        p.step_response(p.linear_system(num=[1], den=[1, 1]), [0.0, 1.0, 3.0])
    with pytest.raises(OutOfLimits, match="final value"):
        p.step_info([0.0, 1.0], [1.0, 0.0])
    with pytest.raises(ShapeError):
        p.step_info([0.0, 1.0], [1.0, 0.0, 1.0])
    process = p.make_process({"kind": "lag_dead_time", "lag": 1.0, "dead_time": 1.0})
    with pytest.raises(OutOfLimits, match="closed loop is unstable"):
        p.closed_step(p.open_loop(process, p.Gains(5.0, 1.0)))
    with pytest.raises(OutOfLimits, match=r"dt is -1\.0"):
        p.sampled_margin(process, p.Gains(1.0), -1.0)
    with pytest.raises(OutOfLimits, match="delay_samples"):
        p.sampled_margin(process, p.Gains(1.0), 0.1, delay_samples=-1)
    with pytest.raises(OutOfLimits, match="more than 300 samples"):
        p.sampled_margin(process, p.Gains(1.0), 1e-3)
    with pytest.raises(OutOfLimits, match="so short beside the lags"):
        p.sampled_margin(p.make_process({"kind": "lags", "lags": [1.0, 2.0]}), p.Gains(1.0), 1e-6)
    with pytest.raises(OutOfLimits, match=r"relay is 0\.0"):
        p.relay_cycle(process, 0.0)
    with pytest.raises(ModelError, match="no limit cycle"):
        p.relay_cycle(p.make_process({"kind": "two_lags", "lags": [1.0, 2.0]}), 1.0)
    with pytest.raises(ModelError, match="dead time alone"):
        p.relay_cycle(p.make_process({"kind": "dead_time", "dead_time": 2.0}), 1.0)


def test_a_process_or_its_keys() -> None:
    """Every verb takes both; what is neither is said."""
    keys = {"kind": "lag_dead_time", "lag": 1.0, "dead_time": 0.5}
    made, gains = p.make_process(keys), p.Gains(1.0, 1.0)
    assert p.ultimate_gain(keys) == p.ultimate_gain(made)
    assert p.relay_cycle(keys, 1.0) == p.relay_cycle(made, 1.0)
    assert p.sampled_margin(keys, gains, 0.1) == p.sampled_margin(made, gains, 0.1)
    assert p.sampled_limits(keys, 0.1) == p.sampled_limits(made, 0.1)
    assert p.largest_gain(keys, gains, 0.1) == p.largest_gain(made, gains, 0.1)
    assert p.loop_figures(p.open_loop(keys, gains)) == p.loop_figures(p.open_loop(made, gains))
    np.testing.assert_array_equal(p.sampled_step(keys, gains, 0.1, 9), p.sampled_step(made, gains, 0.1, 9))
    for wrong in ("oven", None, 3.0):
        with pytest.raises(InputError, match="give a Process, or its keys"):
            p.ultimate_gain(wrong)  # type: ignore[arg-type]
    with pytest.raises(UnknownName, match="no rule '3'"):
        p.tune_process(keys, 3)  # type: ignore[arg-type]

"""Rules of tuning, the guide, warnings, identification: published cases, closed forms, and what every rule owes."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.control import RULES, Process, make_process, recommend, tune_process
from holonom.control import processes as p
from holonom.errors import CalibrationError, InputError, ModelError, OutOfLimits, UnknownName

LATE = {"kind": "lag_dead_time", "gain": 2.0, "lag": 14.0, "dead_time": 3.0}


@pytest.fixture(scope="module")
def cases(data_folder: Path) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    return found


def test_cases_with_a_rule(cases: list[dict[str, Any]]) -> None:
    count = 0
    for case in cases:
        given = case["input"]
        if "rule" not in given or "process" not in given:
            continue
        settings = {key: given[key] for key in ("ratio", "tau_c") if key in given}
        found = tune_process(given["process"], given["rule"], given["form"], **settings)
        tol = case["tol"] if isinstance(case["tol"], dict) else {"default": case["tol"]}
        for key, value in case["expected"].items():
            rel = tol.get(key, tol["default"])
            assert getattr(found, key) == pytest.approx(value, rel=rel, abs=1e-9), (case["id"], key)
        count += 1
    assert count >= 8


def test_reaction_curve_rules(cases: list[dict[str, Any]]) -> None:
    case = next(c for c in cases if c["id"].startswith("reaction curve rules"))
    for key, value in case["expected"].items():
        rule, _, form = key.rpartition("_")
        found = tune_process(case["input"]["process"], rule, form).gains
        for number, wanted in zip(found, value, strict=False):
            low, high = wanted if isinstance(wanted, list) else (wanted, wanted)
            assert low * (1.0 - case["tol"]) <= number <= high * (1.0 + case["tol"]), key


def test_the_tables_as_published(data_folder: Path) -> None:
    tables = json.loads((data_folder / "control" / "control_cases.json").read_text("utf-8"))["pid_tuning_tables"]
    T, L, K = 14.0, 3.0, 2.0
    for kind in ("disturbance_0", "disturbance_20", "setpoint_0", "setpoint_20"):
        for form, row in tables["chien_hrones_reswick"][kind].items():
            found = tune_process(LATE, f"chr_{kind}", form).gains
            assert found.Kc == pytest.approx(row["Kp"] * T / (L * K))
            for key, number in (("Ti", found.Ti), ("Td", found.Td)):
                if key in row:
                    factor, _, unit = row[key].rpartition(" ")
                    wanted = float(factor or 1.0) * {"T": T, "L": L}[unit]
                    assert number == pytest.approx(wanted), (kind, form)
    a, tau = K * L / T, L / (L + T)
    found = tune_process(LATE, "cohen_coon", "PID").gains
    wanted = (1.35 / a * (1 + 0.18 * tau / (1 - tau)), (2.5 - 2 * tau) / (1 - 0.39 * tau) * L,
              (0.37 - 0.37 * tau) / (1 - 0.81 * tau) * L)  # fmt: skip
    assert found == pytest.approx(wanted)
    assert tune_process(LATE, "ziegler_nichols", "P").Kc == pytest.approx(T / (K * L))


def test_ziegler_nichols_by_the_ultimate_gain(cases: list[dict[str, Any]]) -> None:
    wanted = next(c for c in cases if c["id"].startswith("Ziegler-Nichols"))["expected"]
    for form in ("P", "PI", "PID"):
        found = tune_process({"num": [1.0], "den": [1.0, 3.0, 3.0, 1.0]}, "ziegler_nichols_ultimate", form)
        for key in ("Kc", "Ti", "Td"):
            if f"{form}_{key}" in wanted:
                assert getattr(found, key) == pytest.approx(wanted[f"{form}_{key}"], rel=1e-4)


def test_prefilter_of_the_type_two_loop() -> None:
    """The issue: Ti = 10 T overshoots by 23.2 %, with the prefilter by 0."""
    for scale in (1.0, 1e-3):
        found = tune_process(
            {"kind": "integrating_lag", "integral_time": 6.0 * scale, "lag": scale}, "symmetrical_bode"
        )
        assert found.overshoot_percent == pytest.approx(23.2, abs=0.05)
        assert found.overshoot_with_prefilter_percent == pytest.approx(0.0, abs=1e-6)
    assert tune_process(LATE).overshoot_with_prefilter_percent is None


PROCESSES: dict[str, dict[str, Any]] = {
    "late": LATE,
    "two": {"kind": "two_lags", "gain": 0.5, "lags": [3.0, 1.0]},
    "many": {"kind": "lags", "lags": [2.0, 1.0, 0.5], "dead_time": 0.4},
    "integrating": {"kind": "integrating_lag", "integral_time": 6.0, "lag": 1.0, "dead_time": 0.5},
    "dead": {"kind": "dead_time", "gain": 2.0, "dead_time": 3.0},
    "ratio": {"num": [-0.5, 1.0], "den": [2.0, 3.0, 1.0]},
    "one": {"kind": "lag_dead_time", "lag": 2.0},
    "swings": {"num": [1.0], "den": [1.0, 0.6, 1.2, 0.5]},
}


def tuned(process: dict[str, Any], rule: str, form: str, factor: float = 1.0, gain: float = 1.0) -> Any:
    """Tuned with all times longer by a factor and the output of the process multiplied."""
    given = make_process(process)
    n = len(given.den)
    num = gain * np.array(given.num) * factor ** np.arange(len(given.num))[::-1]
    den = np.array(given.den) * factor ** np.arange(n)[::-1]
    scaled = Process(tuple(num), tuple(den), factor * given.dead_time, {})
    settings = {"sample_time": 0.05 * factor} if rule == "sampled" else {}
    return tune_process(scaled, rule, form, **settings)


@pytest.mark.parametrize("rule", RULES.own)
def test_units_do_not_matter(rule: str) -> None:
    """With minutes for seconds, and mA for A, times and gains are those, and margins and overshoot the same."""
    fitting = 0
    for process in PROCESSES.values():
        compared = False
        for form in ("PID", "PI", "PD", "P", "I"):
            try:
                found = tuned(process, rule, form)
            except (ModelError, OutOfLimits):
                continue
            fitting += 1
            assert found.Ms >= 1.0
            if math.isfinite(found.phase_margin_deg):  # Ms bounds it from below: PM >= 2 asin(1/(2 Ms))
                assert found.phase_margin_deg >= 2.0 * math.degrees(math.asin(0.5 / found.Ms)) - 0.5
            if compared:
                continue
            compared = True
            other = tuned(process, rule, form, factor=60.0, gain=1000.0)
            assert other.Kc == pytest.approx(found.Kc / 1000.0, rel=1e-4)
            assert (other.Ti, other.Td) == pytest.approx((60.0 * found.Ti, 60.0 * found.Td), rel=1e-4)
            assert other.phase_margin_deg == pytest.approx(found.phase_margin_deg, abs=0.01)
            assert other.overshoot_percent == pytest.approx(found.overshoot_percent, abs=0.02)
            assert other.Ms == pytest.approx(found.Ms, rel=1e-3)
    assert fitting >= 1


def test_a_second_order_loop_in_closed_form() -> None:
    """`Kc = k T1/T2`: damping 1/(2 sqrt k), overshoot exp(-pi z/sqrt(1 - z^2))."""
    for rule, k in (("phase_margin_60", 0.6), ("phase_margin_50", 1.0)):
        z = 0.5 / math.sqrt(k)
        found = tune_process({"kind": "two_lags", "gain": 3.0, "lags": [0.2, 7.0]}, rule)
        assert found.Kc == pytest.approx(k * 7.0 / (0.2 * 3.0))
        assert found.overshoot_percent == pytest.approx(
            100.0 * math.exp(-math.pi * z / math.sqrt(1.0 - z * z)), rel=1e-5
        )


def test_modulus_optimum_with_pid_cancels_two_lags() -> None:
    found = tune_process({"kind": "lags", "gain": 2.0, "lags": [3.0, 1.0, 0.1]}, "modulus_optimum", "PID")
    assert found.overshoot_percent == pytest.approx(4.3214, rel=1e-3)
    assert (found.Ti, found.Td) == pytest.approx((4.0, 0.75))


def test_lambda_gives_the_closed_loop_that_was_asked() -> None:
    found = tune_process({"kind": "lag_dead_time", "gain": 3.0, "lag": 2.0}, "lambda", closed_lag=0.5)
    t, y = p.closed_step(p.open_loop(found.process, found.gains))
    np.testing.assert_allclose(y, -np.expm1(-t / 0.5), atol=1e-9)


def test_a_tangent_at_the_point_of_inflection() -> None:
    """Three equal lags: 0.218 and 3.69 of them (Strejc's table: Tg/Tu = 4.59, Tg/T = 3.695, Tu/T = 0.805)."""
    for T in (1.0, 20.0):
        found = tune_process({"kind": "lags", "lags": [T, T, T]}, "ziegler_nichols", "PI")
        assert found.Ti == pytest.approx(3.3 * 0.805 * T, rel=2e-3)
        assert found.Kc == pytest.approx(0.9 * 4.59, rel=2e-3)
    late = tune_process({"kind": "integrating_lag", "integral_time": 4.0, "lag": 1.0, "dead_time": 0.5}, "oppelt", "PI")
    assert late.gains == pytest.approx((0.8 * 4.0 / 1.5, 4.5, 0.0))


@pytest.mark.parametrize(
    ("process", "where", "form", "said", "rejected"),
    [
        ({"kind": "dead_time", "gain": 2.0, "dead_time": 3.0}, "before", "I", "61.4", {"P": "Kc Kp = 1"}),
        ({"kind": "lag_dead_time", "lag": 3.0}, "before", "P", "PI", {"PID": "no second lag"}),
        ({"kind": "two_lags", "lags": [2.0, 2.0]}, "before", "PI", "two equal lags", {"PD": "large effort and an"}),
        ({"kind": "two_lags", "lags": [1.0, 9.0]}, "before", "PI", "on the larger (9 s)", {"PD": "offset"}),
        ({"kind": "two_lags", "lags": [2.0, 1.7], "dead_time": 0.5}, "before", "PID", "near-equal", {"PI": "half as"}),
        (PROCESSES["integrating"], "behind", "P", "PD", {"PI": "not needed"}),
        (PROCESSES["integrating"], "before", "PI", "10 times the largest lag: 10 s; faster with PID", {"P": "offset"}),
        (LATE, "before", "PI", "cancels the lag", {"P": "offset"}),
    ],
)  # fmt: skip
def test_the_guide(process: Any, where: str, form: str, said: str, rejected: dict[str, str]) -> None:
    found = recommend(process, disturbance=where)
    assert found.recommended == form
    assert said in " ".join(found.reasons)
    assert form not in found.rejected
    for key, word in rejected.items():
        assert word in found.rejected[key]
    assert set(found.data()) == {"recommended", "reasons", "rejected"}


def test_what_the_guide_says_of_dead_time_is_so() -> None:
    process = make_process({"kind": "dead_time", "gain": 2.0, "dead_time": 3.0})
    for part in (0.99, 1.01):
        assert p.loop_figures(p.open_loop(process, p.Gains(part / 2.0), "P")).stable == (part < 1.0)
    assert tune_process(process).form == "I"
    assert tune_process(process).phase_margin_deg == pytest.approx(61.352, abs=1e-3)


def test_a_sample_that_is_too_slow_is_said() -> None:
    process = {"kind": "lags", "lags": [1.0, 0.2]}
    assert not tune_process(process, "phase_margin_60", sample_time=0.02).warnings
    text = tune_process(process, "phase_margin_60", sample_time=0.1).warnings["sample_time"]
    assert "38.8 deg of 62.1" in text
    assert "largest Kc with 60 deg there: 1.6" in text
    assert (
        "unstable (a pole at 1.262)"
        in tune_process(process, "phase_margin_60", sample_time=0.5).warnings["sample_time"]
    )
    for dt, gain in ((0.1, 1.60), (0.2, 1.11), (0.5, 0.63)):
        found = tune_process(process, "sampled", sample_time=dt)
        assert found.Kc == pytest.approx(gain, rel=0.02)
        assert found.phase_margin_deg == pytest.approx(60.0, abs=0.01)
    slow = tune_process(PROCESSES["integrating"], "sampled", sample_time=0.1)
    assert slow.phase_margin_deg == pytest.approx(60.0, abs=0.01)


def test_weak_loops_are_said() -> None:
    found = tune_process({"num": [1.0], "den": [1.0, 3.0, 3.0, 1.0]}, "ziegler_nichols_ultimate", "PI")
    assert set(found.warnings) == {"phase_margin", "sensitivity"}
    data = found.data()
    assert json.loads(json.dumps(data, allow_nan=False)) == data
    assert data["process"]["kind"] == "transfer_function"
    assert [w["name"] for w in data["warnings"]] == ["phase_margin", "sensitivity"]


@pytest.mark.parametrize(
    ("process", "rule", "form", "settings", "error", "said"),
    [
        (LATE, "sims", "PI", {}, UnknownName, "did you mean 'simc'"),
        (LATE, "simc", "PIDD", {}, UnknownName, "no form 'PIDD'; there is I, P, PD, PI, PID"),
        (LATE, "simc", "PD", {}, ModelError, "rule 'simc' has no PD; it has PI, PID"),
        (LATE, "simc", "PI", {"tau": 1.0}, UnknownName, "no parameter of rule 'simc' 'tau'; there is tau_c"),
        (LATE, "simc", "PI", {"tau_c": -1.0}, OutOfLimits, "tau_c is -1.0"),
        (LATE, "sampled", "PI", {}, InputError, "sample_time missing"),
        (LATE, "phase_margin_60", "PI", {}, ModelError, "two lags without dead time"),
        (PROCESSES["two"], "lag_compensation", "PI", {}, ModelError, "dead time with one lag"),
        (PROCESSES["two"], "symmetrical_optimum", "PI", {}, ModelError, "one integrator with a lag"),
        (PROCESSES["one"], "ziegler_nichols", "PI", {}, ModelError, "no dead time"),
        (PROCESSES["one"], "simc", "PI", {}, ModelError, "give tau_c"),
        (PROCESSES["dead"], "simc", "PI", {}, ModelError, "take form I"),
        (PROCESSES["swings"], "simc", "PI", {}, ModelError, "real lags"),
        (PROCESSES["integrating"], "chr_setpoint_0", "PI", {}, ModelError, "integrating process has no lag"),
        ({"num": [1.0], "den": [1.0, 3.0, 3.0, 1.0]}, "cohen_coon", "PI", {}, ModelError, "gives an unstable PI"),
        ({"num": [1.0], "den": [1.0, -3.0]}, "simc", "PI", {}, ModelError, "unstable"),
    ],
)  # fmt: skip
def test_refusals(
    process: Any, rule: str, form: str, settings: dict[str, Any], error: type[InputError], said: str
) -> None:
    with pytest.raises(error, match=said):
        tune_process(process, rule, form, **settings)


def test_the_guide_refuses() -> None:
    with pytest.raises(UnknownName, match="behind"):
        recommend(LATE, disturbance="inside")
    with pytest.raises(ModelError, match="two integrators"):
        recommend({"num": [1.0], "den": [1.0, 0.0, 0.0]})


STEP = np.linspace(0.0, 100.0, 801)


def answer(kind: str, **keys: Any) -> Any:
    """Output of a process, 3 before, whose input goes from 0.5 to 2 at 5 s."""
    process = make_process({"kind": kind, **keys})
    late = 5.0 + process.dead_time
    t, y = p.step_response(p.linear_system(num=process.num, den=process.den), np.linspace(0.0, 100.0, 40_001))
    return 3.0 + 1.5 * np.where(late <= STEP, np.interp(STEP - late, t, y), 0.0)


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize(
    ("kind", "keys"),
    [
        ("lag_dead_time", {"gain": 2.0, "lag": 14.0, "dead_time": 3.0}),
        ("two_lags", {"gain": 0.7, "lags": [9.0, 4.0], "dead_time": 2.0}),
        ("integrating_lag", {"gain": 1.0, "integral_time": 6.0, "lag": 5.0, "dead_time": 1.0}),
    ],
)
def test_a_process_from_a_recorded_step(kind: str, keys: dict[str, Any], noise: float) -> None:
    y = answer(kind, **keys)
    y = y + noise * np.ptp(y) * np.random.default_rng(3).normal(size=y.shape)
    found = p.identify_step(STEP, np.where(STEP >= 5.0, 2.0, 0.5), y)
    given = dict(found.process.given)
    assert given.pop("kind") == kind
    for key, value in keys.items():
        assert given[key] == pytest.approx(value, rel=2e-4 if noise == 0.0 else 0.15, abs=0.5 * noise * 100.0), key
    assert found.misfit_percent == pytest.approx(100.0 * noise, abs=0.1)
    assert found.compared[kind] == found.misfit_percent


def relay_record(lag: float, dead: float, gain: float) -> Any:
    """A relay of +-2 about 1, from rest, on one lag: exact from sample to sample."""
    h, n = dead / 200.0, 4000
    y, u, ys, us = 0.0, 1.0, [], [1.0] * 200
    part = -math.expm1(-h / lag)
    for k in range(n):
        u = 3.0 if y < gain else (-1.0 if y > gain else u)
        us.append(u)
        ys.append(y)
        y += part * (gain * us[k] - y)
    return h * np.arange(n), np.array(us[200:]), np.array(ys)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_process_from_a_relay(noise: float) -> None:
    t, u, y = relay_record(1.0, 1.0, 1.5)
    y = y + noise * np.random.default_rng(5).normal(size=y.shape)
    found = p.identify_relay(t, u, y)
    given = found.fit.process.given
    assert (given["gain"], given["lag"], given["dead_time"]) == pytest.approx((1.5, 1.0, 1.0), rel=1e-6 + 2.0 * noise)
    assert found.relay == 2.0
    assert found.period == pytest.approx(2.97976, rel=0.005)  # of its closed form; the record's relay is a sample late
    assert found.amplitude == pytest.approx(2.0 * 1.5 * 0.632121, rel=0.005)
    assert found.Ku_exact == pytest.approx(2.26183 / 1.5, rel=1e-4 + 2.0 * noise)
    assert found.describing_function_error_percent == pytest.approx(-11.0, abs=0.5 + 50.0 * noise)


def test_records_that_tell_nothing() -> None:
    u, y = (
        np.where(STEP >= 5.0, 2.0, 0.5),
        answer("lag_dead_time", **{k: LATE[k] for k in ("gain", "lag", "dead_time")}),
    )
    for given, error, said in (
        ((STEP, 0.0 * u, y), CalibrationError, "input never changes"),
        ((STEP, u, 0.0 * y), CalibrationError, "output does not move"),
        ((STEP, -u, y), CalibrationError, "in the direction of the input"),
        ((STEP[::-1], u, y), OutOfLimits, "each after the one before"),
        ((STEP[:4], u[:4], y[:4]), OutOfLimits, "8 at least"),
        ((STEP[:43], u[:43], y[:43]), CalibrationError, "samples follow the step"),
        ((STEP, np.sin(STEP), y), CalibrationError, "held between a few steps"),
    ):
        with pytest.raises(error, match=said):
            p.identify_step(*given)
    with pytest.raises(UnknownName, match="two_lags"):
        p.identify_step(STEP, u, y, kind="three_lags")
    with pytest.raises(CalibrationError, match="switches up 1 times"):
        p.identify_relay(STEP, u, y)
    t, u, y = relay_record(1.0, 1.0, 1.5)
    with pytest.raises(CalibrationError, match="the hysteresis is 5"):
        p.identify_relay(t, u, y, hysteresis=5.0, kind="lag_dead_time")
    with pytest.raises(OutOfLimits, match="hysteresis is nan"):
        p.identify_relay(t, u, y, hysteresis=math.nan)


def test_a_zero_on_the_right_counts_as_dead_time() -> None:
    """Half rule of `(1 - s/2)/((1 + 2 s)(1 + s))`: 2.5 s of lag, 0.5 + 0.5 s of dead time."""
    found = tune_process({"num": [-0.5, 1.0], "den": [2.0, 3.0, 1.0]}, "simc")
    assert found.gains == pytest.approx((2.5 / 2.0, 2.5, 0.0))

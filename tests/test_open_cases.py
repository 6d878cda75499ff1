"""Every published case through a public door: a command with `--json`, or a function of the package.

Inputs are taken by the keys of the cases, answers compared by the keys under `expected`, within `tol`.
"""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import holonom as hm
from holonom.app.console.cli import main

Case = dict[str, Any]
Door = Callable[[Case], Mapping[str, Any]]

APART = ("impact", "force loop", "two-point contact")
"""Contact and force, which the issue leaves for later."""
ELSEWHERE = {
    "two-mass": "tests/devices/test_transmission.py",
    "describing function of play": "tests/devices/test_transmission.py",
    "harmonic drive": "tests/devices/test_transmission.py",
    "trial: spike in the speed loop": "tests/control/test_cascade.py",
}


@pytest.fixture(scope="module")
def cases(data_folder: Path) -> list[Case]:
    found: list[Case] = json.loads((data_folder / "control" / "open_cases.json").read_text("utf-8"))
    return found


class Doors:
    """Commands as a user calls them."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self.capsys = folder, capsys

    def call(self, command: str, tables: Mapping[str, Mapping[str, Any]], *words: str, status: int = 0) -> Any:
        lines = []
        for table, keys in tables.items():
            lines += [f"[{table}]"] if table else []
            lines += [f"{key} = {json.dumps(value)}" for key, value in keys.items()]
        path = self.folder / "file.toml"
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return self.run(*command.split(), str(path), *words, status=status)

    def run(self, *words: str, status: int = 0) -> Any:
        assert main([*words, "--json"]) == status, self.capsys.readouterr()
        return json.loads(self.capsys.readouterr().out)

    def motor(self, given: Case) -> Any:
        return self.call("check", {"motor": given})

    def preset(self, given: Case) -> Any:
        return self.call("check", {"motor": {"preset": given["motor"]}})

    def rule(self, given: Case) -> Any:
        wanted = {key: given[key] for key in ("form", "ratio") if key in given}
        return self.call("tune", {"process": given["process"], "wanted": wanted}, "--rule", given["rule"])

    def ultimate(self, given: Case) -> Any:
        return self.call("tune", {"process": given})

    def ziegler_nichols(self, given: Case) -> dict[str, float]:
        """Of the process that has this ultimate gain and period."""
        found = {}
        for form in ("P", "PI", "PID"):
            tables = {"process": {"num": [1], "den": [1, 3, 3, 1]}, "wanted": {"form": form}}
            data = self.call("tune", tables, "--rule", "ziegler_nichols_ultimate")
            assert (data["Ku"], data["Tu"]) == pytest.approx((given["Ku"], given["Tu"]), rel=1e-4)
            found |= {f"{form}_{key}": data[key] for key in ("Kc", "Ti", "Td")}
        return found

    def reaction_curve(self, given: Case) -> dict[str, list[float]]:
        found = {}
        for form in ("PI", "PID"):
            data = self.call("tune", {**given, "wanted": {"form": form}}, "--rule", "all")
            for row in data["rules"]:
                found[f"{row['rule']}_{form}"] = [row["Kc"], row["Ti"], row["Td"]]
        return found

    def relay(self, given: Case) -> Any:
        """A record of the experiment, simulated here, to the command; exactly, the function says the same."""
        p, dt, h = given["process"], 0.01, given["hysteresis"]
        late, t = round(p["dead_time"] / dt), np.arange(0.0, 16.0 * p["dead_time"], dt)
        u, y, now, on = np.zeros(len(t)), np.zeros(len(t)), 0.0, given["relay"]
        for k in range(len(t)):
            on = given["relay"] if now < -h else -given["relay"] if now > h else on
            u[k], y[k] = on, now
            came = u[k - late] if k >= late else 0.0
            now -= math.expm1(-dt / p["lag"]) * (p["gain"] * came - now)
        log = self.folder / "relay.csv"
        np.savetxt(log, np.column_stack([t, u, y]), delimiter=",", header="time,u,y", comments="")
        told = self.run("calibrate", "process", str(log), "--experiment", "relay", "--hysteresis", str(h))
        exact = hm.control.relay_cycle(hm.control.make_process(p), given["relay"], h)
        for key in ("amplitude", "period", "Ku_describing_function", "Ku_exact", "Tu_exact"):
            assert told[key] == pytest.approx(getattr(exact, key), rel=0.01), key
        return {key: getattr(exact, key) for key in told if hasattr(exact, key)}

    def cycle(self, given: Case) -> Any:
        return self.call("select", {"": given})


def sequences(given: Case) -> dict[str, Any]:
    def u(name: str, **gains: float) -> list[float]:
        e, dt, limits = given["error"], given["Ts"], given["limits"]
        made = hm.control.respond(name, e, 0.0, dt=dt, limits=limits, Kc=given["Kc"], Ti=given["Ti"], **gains)
        return list(map(float, made))

    incremental = u("incremental", Td=given["Td"])
    return {
        "foxboro": u("foxboro"), "reset_g1": u("reset", g=1.0), "reset_g02": u("reset", g=0.2),
        "incremental_PID": incremental,
    }  # fmt: skip


def sampled_p(given: Case) -> dict[str, float]:
    integrator = hm.control.make_process({"kind": "integrating_lag", "integral_time": 1.0})
    found = hm.control.sampled_limits(integrator, given["Ts"], delay_samples=given["delay_samples"])
    return found._asdict()


def late_integrator(given: Case) -> dict[str, float]:
    """`e^(-sT)/(2Ts)`, T = 1: P of 0.5 on an integrator with dead time."""
    process = hm.control.make_process({"kind": "integrating_lag", "integral_time": 2.0, "dead_time": 1.0})
    loop = hm.control.open_loop(process, hm.control.Gains(1.0), "P")
    step = hm.control.step_info(*hm.control.closed_step(loop), steady_state=1.0)
    return {
        "peak": step.peak, "peak_time_over_T": step.peak_time, "rise_10_90_over_T": step.rise_time,
        "settling_2_percent_over_T": step.settling_time,
        "phase_margin_deg": hm.control.loop_figures(loop).phase_margin_deg,
    }  # fmt: skip


def current_loop(given: Case) -> dict[str, float]:
    R, L, dt = given["R"], given["L"], given["Ts"]
    gains = hm.control.Gains(L / (3.0 * dt), L / R)
    process = hm.control.make_process({"num": [1.0], "den": [L, R]})
    y = hm.control.sampled_step(process, gains, dt, 60, delay_samples=given["delay_samples"])
    return {"Kc": gains.Kc, "overshoot_percent": 100.0 * (y.max() - 1.0), "samples_to_peak": int(y.argmax())}


def gear(given: Case) -> dict[str, float]:
    params = hm.devices.Gear(given["ratio"], given["efficiency"]).params()
    return {
        "driving": hm.devices.gear_torque(params, given["motor_torque"], 1.0),
        "driven_back": hm.devices.gear_torque(params, given["motor_torque"], -1.0),
    }


def six_step(given: Case) -> dict[str, float]:
    found = hm.devices.SixStep()
    return {"mean_over_peak": found.mean_over_peak, "ripple_pp_over_mean": found.ripple_over_mean}


def bridge(given: Case) -> dict[str, float]:
    found = hm.devices.PwmBridge(given["Udc"], given["frequency"], given["dead_time"])
    return {"largest_ripple_pp": found.ripple(given["L"]), "dead_time_voltage": found.dead_time_voltage}


def frames(kind: str) -> Door:
    def rows(given: Case) -> dict[str, Any]:
        return {"frames": kind}

    return rows


def undetected(given: Case) -> dict[str, int]:
    bits = given["bits"]
    frame = hm.devices.encode_frame("endat", 2**bits // 3, bits=bits)
    places = range(1, len(frame))  # a start bit that is missing is seen anyhow

    def missed(patterns: Any) -> int:
        count = 0
        for pattern in patterns:
            bent = "".join(str(int(bit) ^ (k in pattern)) for k, bit in enumerate(frame))
            count += hm.devices.decode_frame("endat", bent, bits=bits).ok
        return count

    bursts = [
        [k + j for j in range(5) if shape >> j & 1 and k + j < len(frame)] for k in places for shape in range(1, 32, 2)
    ]
    return {
        "single": missed((k,) for k in places),
        f"double_of_{math.comb(len(places), 2)}": missed(itertools.combinations(places, 2)),
        "triple": missed(itertools.combinations(places, 3)),
        "bursts_to_5": missed(bursts),
    }


def counter(given: Case) -> dict[str, float]:
    found = hm.devices.Counter(given["counter_bits"])
    return {"longest_read_interval": found.longest_read_interval(given["counts_per_rev"], given["max_speed"])}


def speeds(given: Case) -> dict[str, float]:
    counts, dt, timer, speed = (given[key] for key in ("counts_per_rev", "Ts", "timer", "speed"))
    by_time = hm.devices.TMethod(counts, timer)
    return {
        "M_resolution": hm.devices.MMethod(counts, dt).resolution(speed),
        "T_counts": by_time.ticks(speed),
        "T_relative_resolution": by_time.resolution(speed) / speed,
        "equal_resolution_speed": hm.devices.equal_resolution_speed(counts, dt, timer),
    }


def sin_cos(given: Case) -> dict[str, float]:
    found = hm.devices.SinCosEncoder(given["lines"], sine_offset=given["offset"])
    return {"largest_error_rad": found.largest_error()}


def stick_slip(given: Case) -> dict[str, Any]:
    g, dt = given, given["step"]
    sheet = hm.devices.LuGre(g["sigma0"], g["sigma1"], g["sigma2"], g["Fc"], g["Fs"], g["vs"])
    params, bristle, speed, place, places = sheet.params(dt), 0.0, 0.0, 0.0, [0.0]
    for k in range(round(g["time"] / dt)):
        friction, bristle = hm.devices.lugre_step(params, bristle, speed)
        speed += dt * (g["spring"] * (g["pull"] * k * dt - place) - friction) / g["mass"]
        place += dt * speed
        if k % 100 == 99:
            places.append(place)
    fast = np.diff(places) > 1e-4
    slips = 100 * dt * np.flatnonzero(fast & ~np.r_[False, fast[:-1]])
    return {"position_at_end": place, "slips_at": [float(t) for t in slips + 100 * dt]}


def coming_to_rest(given: Case) -> dict[str, float]:
    """The load drives on: friction less load brakes."""
    dt, speed, angle, held, stopped = 1e-4, given["speed"], 0.0, 0.0, 0.0
    shaft = hm.devices.Friction(coulomb_positive=given["coulomb"], coulomb_negative=given["coulomb"])
    params = shaft.stiction(given["inertia"], dt)
    for k in range(10_000):
        friction, held = hm.devices.stiction_step(params, held, speed)
        speed += dt * (given["load"] - friction) / given["inertia"]
        angle += dt * speed
        if stopped == 0.0 and abs(speed) < 1e-3 * given["speed"]:
            stopped = (k + 1) * dt
    return {"time": stopped, "angle": angle, "speed_afterwards": speed}


def computed_torque(given: Case) -> dict[str, float]:
    dt = 1e-3
    return {"stable_for_a_above": hm.control.least_inertia(hm.control.acceleration_params(20.0, dt), dt)}


def doors(commands: Doors) -> dict[str, Door]:
    """Begin of a case's id, and its door."""
    return {
        "motor maxon": commands.motor, "servo data sheet": commands.motor, "thermal": commands.preset,
        "maximum torque per ampere": commands.motor, "PMSM": commands.motor, "stepper": commands.motor,
        "induction motor": commands.motor, "lag compensation": commands.rule, "two lags": commands.rule,
        "integrating": commands.rule, "modulus optimum": commands.rule, "symmetrical optimum": commands.rule,
        "SIMC": commands.rule, "ultimate": commands.ultimate, "Ziegler-Nichols": commands.ziegler_nichols,
        "reaction curve rules": commands.reaction_curve, "relay": commands.relay, "load cycle": commands.cycle,
        "best ratio": commands.cycle, "regulator sequences": sequences, "recoil": sequences,
        "sampled P on an integrator": sampled_p, "integrator with dead time": late_integrator,
        "current loop": current_loop, "gear with efficiency": gear, "six-step": six_step, "unipolar PWM": bridge,
        "undetected errors": undetected, "counter": counter, "velocity methods": speeds, "sin/cos": sin_cos,
        "LuGre": stick_slip, "coming to rest": coming_to_rest, "computed torque": computed_torque,
    }  # fmt: skip


def compared(name: str, found: Any, wanted: Any, tol: float, *, absolute: bool = False) -> None:
    """A list within a list is a range."""
    if not isinstance(wanted, list):
        assert isinstance(found, (int, float)), (name, found)
        assert found == pytest.approx(wanted, rel=0.0 if absolute else tol, abs=tol if absolute else 1e-9), name
        return
    assert len(found) >= len(wanted), name
    for number, one in zip(found, wanted, strict=False):
        if isinstance(one, list):
            assert one[0] * (1.0 - tol) <= number <= one[1] * (1.0 + tol), name
        else:
            compared(name, number, one, tol, absolute=absolute)


def test_every_case_has_a_door_and_holds(cases: list[Case], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table, done = doors(Doors(tmp_path, capsys)), 0
    for case in cases:
        name = case["id"]
        if name.startswith((*APART, *ELSEWHERE, "trial:", "frames")):
            continue
        door = next((door for start, door in table.items() if name.startswith(start)), None)
        assert door is not None, f"no door for {name}"
        found, tol = door(case["input"]), case["tol"]
        for key, wanted in case["expected"].items():
            assert key in found, (name, key)
            if isinstance(tol, dict):
                near = tol.get(f"{key}_abs", tol.get(key, tol.get("default")))
                compared(f"{name}: {key}", found[key], wanted, near, absolute=f"{key}_abs" in tol)
            else:
                compared(f"{name}: {key}", found[key], wanted, tol)
        done += 1
    assert done >= 34


@pytest.mark.parametrize("kind", ["ssi", "endat", "biss"])
def test_frames(cases: list[Case], kind: str) -> None:
    (case,) = (case for case in cases if case["id"] == f"frames {kind}")
    for row in case["expected"]["frames"]:
        flags = {key: row[key] for key in ("alarm", "n_error", "n_warning") if key in row}
        assert hm.devices.encode_frame(kind, row["position"], bits=row["bits"], **flags) == row["frame"]
        decoded = hm.devices.decode_frame(kind, row["frame"], bits=row["bits"])
        assert decoded.ok
        assert {key: getattr(decoded, key) for key in row if key not in ("bits", "frame")} == {
            key: row[key] for key in row if key not in ("bits", "frame")
        }


def test_trial_of_an_axis(cases: list[Case], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (case,) = (case for case in cases if case["id"] == "trial: tune RE 40 axis")
    g, accept = case["input"], case["accept"]
    tables = {
        "motor": {"preset": g["motor"]}, "supply": g["supply"], "encoder": {"counts": g["encoder_counts"]},
        "load": {"inertia": g["J_load_at_motor"], "coulomb": g["coulomb_motor"] + g["coulomb_load"]},
    }  # fmt: skip
    data = Doors(tmp_path, capsys).call("tune", tables)
    step, low_high = accept["position_step_1rad"], accept["phase_margin_speed_deg"]
    assert data["verified"]["overshoot_percent"] <= step["overshoot_percent_max"]
    assert data["verified"]["settling_time"] <= step["settling_2_percent_max"]
    assert data["verified"]["end_error"] <= step["end_error_max_counts"] * math.tau / g["encoder_counts"]
    assert low_high[0] <= data["loops"]["speed"]["phase_margin_deg"] <= low_high[1]
    assert data["warnings"] == []


def test_trial_of_sheets_that_contradict_themselves(
    cases: list[Case], data_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (case,) = (case for case in cases if case["id"] == "trial: sheets that contradict themselves")
    sheets = json.loads((data_folder / "control" / "control_cases.json").read_text("utf-8"))["dc_motors"]
    by_name = {sheet["name"]: sheet for sheet in sheets}
    tried = (by_name["maxon A-max 32"] | {"J": 45.3e-6}, by_name["maxon DCX 22 L 9 V"])
    for sheet, name in zip(tried, case["accept"]["named"], strict=True):
        data = Doors(tmp_path, capsys).call("check", {"motor": sheet}, status=2)
        assert [finding["name"] for finding in data["contradictions"]] == [name]


def test_trial_of_encoder_faults(cases: list[Case]) -> None:
    (case,) = (case for case in cases if case["id"] == "trial: encoder faults at 100 rad/s")
    motor = hm.devices.motor_card("maxon RE 40 148877 48 V").sheet.motor(max_current=10.0)
    axis = hm.sim.Axis(motor, hm.sim.Load(3e-5, 0.006), hm.devices.Encoder(case["input"]["counts"]))
    gains, reference = hm.control.design_cascade(axis.servo_axis()), np.full(900, 100.0)
    kinds = ("channel_a_stuck", "encoder_dead", "channels_swapped", "edges_lost")
    causes = set()
    for kind, within in zip(kinds, case["accept"]["detected_ms"], strict=True):
        fault = hm.sim.AxisFault(kind, 0.3)
        run = hm.sim.simulate_axis(axis, gains, reference, loop="speed", faults=[fault])
        first, *later = run.events
        assert 1e3 * (first.time - 0.3) <= within + 1e-6, kind
        assert first.first
        assert not any(event.first for event in later)
        causes.add(first.cause)
        assert np.abs(run.motor_speed).max() <= case["accept"]["largest_speed"], kind
        assert abs(run.motor_speed[-1]) < 1e-6, kind
    assert len(causes) == len(kinds)

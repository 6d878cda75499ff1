"""`holonom tune PROCESS.toml` and `holonom calibrate process`: answers, files, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from holonom.app.console.cli import main
from holonom.control import RULES

OVEN = '[process]\nkind = "lag_dead_time"\ngain = 2.0\nlag = "14s"\ndead_time = 3.0\n'
KEYS = {
    "process",
    "rule",
    "form",
    "Kc",
    "Ti",
    "Td",
    "crossover",
    "phase_margin_deg",
    "overshoot_percent",
    "Ms",
    "guide",
}


def toml(folder: Path, text: str) -> str:
    path = folder / "process.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


def answer(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    assert main([*words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_one_rule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = toml(tmp_path, OVEN)
    data = answer(capsys, "tune", file, "-o", str(tmp_path / "out"))
    assert set(data) >= KEYS
    assert (data["rule"], data["form"]) == ("lag_compensation", "PI")
    assert (data["Kc"], data["Ti"], data["Td"]) == pytest.approx((14.0 / 12.0, 14.0, 0.0))
    assert data["phase_margin_deg"] == pytest.approx(61.352, abs=1e-3)
    assert data["guide"]["recommended"] == "PI"
    assert json.loads((tmp_path / "out" / "tuning.json").read_text("utf-8")) == data
    step = np.loadtxt(tmp_path / "out" / "step.csv", delimiter=",", skiprows=1)
    assert step[:, 1].max() == pytest.approx(1.0405, abs=1e-3)
    bode = np.loadtxt(tmp_path / "out" / "bode.csv", delimiter=",", skiprows=1)
    at = np.interp(0.0, -np.log(bode[:, 1]), bode[:, 2])
    assert at == pytest.approx(61.352 - 180.0, abs=0.05)
    assert main(["tune", file, "--rule", "ziegler_nichols"]) == 0
    text = capsys.readouterr().out
    assert "Kc 2.1" in text
    assert "warning: ziegler_nichols: Ms is" in text
    assert "recommended: PI" in text


def test_all_rules(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    data = answer(capsys, "tune", toml(tmp_path, OVEN), "--rule", "all")
    found = {row["rule"]: row for row in data["rules"]}
    assert set(found) | set(data["unfit"]) == set(RULES)
    assert not set(found) & set(data["unfit"])
    assert found["ziegler_nichols"]["Ti"] == pytest.approx(9.9)
    assert "two lags" in data["unfit"]["aperiodic"]
    sampled = OVEN + "[wanted]\nsample_time = '500ms'\nclosed_lag = 6.0\n"
    data = answer(capsys, "tune", toml(tmp_path, sampled), "--rule", "all")
    found = {row["rule"]: row for row in data["rules"]}
    assert found["sampled"]["phase_margin_deg"] == pytest.approx(60.0, abs=0.01)
    assert found["lambda"]["Kc"] == pytest.approx(14.0 / (2.0 * 9.0))


def test_what_is_wanted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    axis = '[process]\nkind = "integrating_lag"\nintegral_time = 6.0\nlag = 1.0\n'
    data = answer(capsys, "tune", toml(tmp_path, axis))
    assert data["Kc"] == pytest.approx(1.8974, rel=1e-4)
    assert data["overshoot_with_prefilter_percent"] == pytest.approx(0.0, abs=1e-6)
    data = answer(capsys, "tune", toml(tmp_path, axis + '[wanted]\nratio = 4\ndisturbance = "behind"\n'))
    assert (data["Ti"], data["guide"]["recommended"]) == (4.0, "P")
    data = answer(capsys, "tune", toml(tmp_path, axis + '[wanted]\nform = "PD"\nrule = "oppelt"\n'))
    assert (data["form"], data["Ti"]) == ("PD", None)
    data = answer(capsys, "tune", toml(tmp_path, "[process]\nnum = [1]\nden = [1, 3, 3, 1]\n[wanted]\nform = 'PID'\n"))
    assert data["process"] == {"kind": "transfer_function", "num": [1.0], "den": [1.0, 3.0, 3.0, 1.0], "dead_time": 0.0}
    slow = '[process]\nkind = "lags"\nlags = [1.0, 0.2]\n[wanted]\nsample_time = 0.1\n'
    data = answer(capsys, "tune", toml(tmp_path, slow), "--rule", "phase_margin_60")
    assert [w["name"] for w in data["warnings"]] == ["sample_time"]


@pytest.mark.parametrize(
    ("process", "form"),
    [
        ('kind = "dead_time"\ndead_time = 2.0', "I"),
        ('kind = "lag_dead_time"\nlag = 2.0', "P"),
        ('kind = "lags"\nlags = [2.0]', "P"),
        ('kind = "two_lags"\nlags = [2.0, 2.0]', "PI"),
        ('kind = "lags"\nlags = [9.0, 1.0]', "PI"),
        ('kind = "lags"\nlags = [2.0, 1.8]\ndead_time = 0.4', "PID"),
        ('kind = "integrating_lag"\nintegral_time = 2.0\nlag = 0.1', "PI"),
    ],
)
def test_the_guide_answers_for_every_process(
    process: str, form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert answer(capsys, "tune", toml(tmp_path, f"[process]\n{process}\n"))["guide"]["recommended"] == form


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "1: nothing came; a table [process] or [motor] is needed"),
        ("[proces]\nlag = 1\n", "1: [proces] came; a table [process]"),
        ("process = 3\n", "1: process: 3 came; a table [process] is expected"),
        ("[process]\ngain = 1\n", "process.kind: None came; it must be one of dead_time"),
        ('[process]\nkind = "lagg"\n', "2: process.kind: no kind of process 'lagg'"),
        (OVEN.replace("gain", "gian"), "3: process.gian: no key 'gian'; there is dead_time, gain, kind, lag"),
        (OVEN.replace("14s", "14kg"), "4: process.lag: '14kg' came, in a unit of mass"),
        (OVEN.replace('"14s"', "-1"), "4: process.lag: lag is -1.0; it must be 1e-09 to 1e+09 s"),
        (OVEN.replace('"14s"', "nan"), "4: process.lag: lag is nan"),
        (OVEN.replace('lag = "14s"\n', ""), "1: process: kind of process 'lag_dead_time': lag missing"),
        ("[process]\nnum = [1]\nden = [1, -1]\n", "1: process: process: unstable, a pole at 1 1/s"),
        ("[process]\nnum = [1, 0, 0]\nden = [1, 1]\n", "not strictly proper"),
        (OVEN + "[wanted]\nform = 'PIX'\n", "7: wanted.form: no value of form 'PIX'; there is I, P, PD, PI, PID"),
        (OVEN + "[wanted]\nrule = 'sims'\n", "7: wanted.rule: no value of rule 'sims'"),
        (OVEN + "[wanted]\nrati = 3\n", "wanted.rati: no key 'rati'"),
        (OVEN + "[limits]\nu = 3\n", "6: limits: no table 'limits'; there is process, wanted"),
        (OVEN + "[wanted]\nrule='aperiodic'\n", "'aperiodic': this rule takes two lags without dead time; rules th"),
        (OVEN + "[wanted]\nform = 'PD'\nrule = 'simc'\n", "rule 'simc' has no PD; it has PI, PID; rules that fit: "),
        ("[process]\nnum = [1]\nden = [1, 0, 0]\n", "1: process: two integrators"),
        ("[process\n", "not TOML"),
    ],
)  # fmt: skip
def test_a_file_that_is_wrong(text: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = toml(tmp_path, text)
    assert main(["tune", path, "-o", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert path in error
    assert said in error
    assert not (tmp_path / "out").exists()


def test_no_file_and_no_rule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tune", str(tmp_path / "none.toml")]) == 2
    assert "none.toml" in capsys.readouterr().err
    assert main(["tune", toml(tmp_path, OVEN), "--rule", "simcc"]) == 2
    assert "did you mean 'simc'" in capsys.readouterr().err
    dead = "[process]\nkind = 'dead_time'\ndead_time = 1\n[wanted]\nform = 'PID'\n"
    assert main(["tune", toml(tmp_path, dead), "--rule", "all"]) == 2
    assert "no rule fits this process with form 'PID'" in capsys.readouterr().err


def test_the_ultimate_gain_of_any_process(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of k/(1 + sT)^3: the phase is -180 deg at sqrt(3)/T, where the size is k/8; two lags never swing."""
    cube = "[process]\nkind = 'lags'\ngain = 4\nlags = [0.5, 0.5, 0.5]\n"
    for words in ((), ("--rule", "all")):
        data = answer(capsys, "tune", toml(tmp_path, cube), *words)
        assert (data["Ku"], data["Tu"]) == pytest.approx((2.0, 2.0 * np.pi * 0.5 / np.sqrt(3.0)), rel=1e-5)
    data = answer(capsys, "tune", toml(tmp_path, "[process]\nkind = 'lags'\nlags = [0.5, 0.5]\n"))
    assert (data["Ku"], data["Tu"]) == (None, None)


def test_what_p_needs_on_one_lag(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The guide recommends P there; any gain is stable, so that one has to be asked for."""
    lag = "[process]\nkind = 'lag_dead_time'\ngain = 2\nlag = 3\n[wanted]\nform = 'P'\n"
    assert main(["tune", toml(tmp_path, lag)]) == 2
    assert "P by lambda takes one lag, or an integrator, and closed_lag" in capsys.readouterr().err
    data = answer(capsys, "tune", toml(tmp_path, lag + "closed_lag = 0.5\n"))
    assert data["Kc"] == pytest.approx((3.0 / 0.5 - 1.0) / 2.0)


def log(path: Path, **columns: Any) -> str:
    np.savetxt(path, np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns), comments="")
    return str(path)


def test_a_step_becomes_a_process_that_can_be_tuned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = np.linspace(0.0, 80.0, 400)
    y = 20.0 + 2.0 * -np.expm1(-np.maximum(t - 8.0, 0.0) / 14.0)
    file = log(tmp_path / "step.csv", time=t, u=np.where(t >= 5.0, 1.0, 0.0), y=y, door=t)
    data = answer(capsys, "calibrate", "process", file, "--experiment", "step", "-o", str(tmp_path))
    at = t[np.argmax(t >= 5.0)]  # it was recorded from the sample on at which it was seen
    wanted = {"gain": 2.0, "lag": 14.0, "dead_time": 8.0 - at}
    assert data["process"].pop("kind") == "lag_dead_time"
    assert data["process"] == pytest.approx(wanted, rel=1e-5)
    assert data["misfit_percent"] < 1e-3
    assert data["notes"] == [f"{file}:1: not read: column door"]
    assert answer(capsys, "tune", str(tmp_path / "process.toml"))["Ti"] == pytest.approx(14.0, rel=1e-5)
    assert main(["calibrate", "process", file, "--experiment", "step"]) == 0
    assert "lag_dead_time: gain 2, lag 14" in capsys.readouterr().out
    other = log(tmp_path / "other.csv", t=t, input=np.where(t >= 5.0, 1.0, 0.0), output=y)
    assert answer(capsys, "calibrate", "process", other, "--experiment", "step")["process"]["kind"] == "lag_dead_time"


def test_a_relay_tells_its_own_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = np.arange(0.0, 16.0, 0.01)
    u, y, now, on = np.zeros(len(t)), np.zeros(len(t)), 0.0, 1.0
    for k in range(len(t)):
        on = 1.0 if now < 0.0 else -1.0 if now > 0.0 else on
        u[k], y[k] = on, now
        now += -np.expm1(-0.01) * ((u[k - 100] if k >= 100 else 0.0) - now)
    file = log(tmp_path / "relay.csv", time=t, u=u, y=y)
    data = answer(capsys, "calibrate", "process", file, "--experiment", "relay")
    assert data["process"].pop("kind") == "lag_dead_time"
    assert data["process"] == pytest.approx({"gain": 1.0, "lag": 1.0, "dead_time": 1.0}, rel=1e-4)
    assert data["Ku_exact"] == pytest.approx(2.26183, rel=1e-4)
    assert data["Tu_exact"] == pytest.approx(3.09706, rel=1e-4)
    assert data["describing_function_error_percent"] == pytest.approx(-11.0, abs=0.6)
    assert main(["calibrate", "process", file, "--experiment", "relay"]) == 0
    assert "by the describing function" in capsys.readouterr().out


def test_records_that_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    t = np.linspace(0.0, 80.0, 400)
    u, y = np.where(t >= 5.0, 1.0, 0.0), -np.expm1(-np.maximum(t - 8.0, 0.0))
    for columns, words, said in (
        ({"time": t, "u": u}, (), "1: columns time, u came; y missing"),
        ({"when": t, "in": u, "out": y}, (), "1: columns when, in, out came; time, u, y missing"),
        ({"t": t, "in": u, "out": y}, (), "1: columns t, in, out came; u, y missing"),
        ({"time": t[::-1], "u": u, "y": y}, (), "time must grow"),
        ({"time": t, "u": 0.0 * u, "y": y}, (), "the input never changes"),
        ({"time": t, "u": u, "y": y}, ("--experiment", "relay"), "switches up 1 times"),
        (
            {"time": t, "u": u, "y": y},
            ("--experiment", "ramp"),
            "no value of --experiment 'ramp'; there is relay, step",
        ),
        ({"time": t, "u": u, "y": y}, ("--kind", "lags"), "no value of --kind 'lags'"),
    ):
        file = log(tmp_path / "log.csv", **columns)
        given = words if "--experiment" in words else ("--experiment", "step", *words)
        assert main(["calibrate", "process", file, *given]) == 2
        assert said in capsys.readouterr().err
    assert main(["calibrate", "process", file]) == 2
    assert "--experiment" in capsys.readouterr().err

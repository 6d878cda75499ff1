"""`holonom tune PROCESS.toml`: gains for a process by a rule, or by all that fit, and the guide."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.drives.tuning.tables import TuningFile
from holonom.control.processes import (
    PROCESSES,
    RULES,
    Process,
    Tuning,
    closed_step,
    default_rule,
    loop_figures,
    make_process,
    open_loop,
    recommend,
    tune_process,
    ultimate_gain,
)
from holonom.control.processes.contract import FORMS
from holonom.control.processes.guide import DISTURBANCES
from holonom.errors import InputError, ModelError, OutOfLimits, UnknownName
from holonom.registry import Field, Parameter

__all__ = ["RULE_NAMES", "tune_process_file"]

ALL = "all"
_KINDLESS = "transfer_function"


class _RuleNames:
    """Rules, those of other packages too, and all of them."""

    def __iter__(self) -> Iterator[str]:
        yield from RULES
        yield ALL


RULE_NAMES = _RuleNames()
WANTED = {
    "form": Field("form", str, None, Parameter("form of regulator; PI unless given", choices=FORMS)),
    "rule": Field("rule", str, None, Parameter("unless the command names one", choices=RULE_NAMES)),
    "disturbance": Field("disturbance", str, None, Parameter("against an integrator", choices=DISTURBANCES)),
    "sample_time": Field("sample_time", float, None, Parameter("of the regulator", unit="s", least=1e-9, most=1e9)),
    "delay_samples": Field("delay_samples", int, 1, Parameter("for computing", least=0, most=100)),
}


def tune_process_file(file: TuningFile, rule: str | None = None, output: Path | None = None) -> Answer:
    """Tune the process of a file.

    Parameters
    ----------
    file : tables [process] (kind and keys) and [wanted] (form, rule, disturbance, sample_time, settings of rules).
    rule : a name, "all", or None: the file's, else the one that fits.
    output : folder for tuning.json, and of a single rule step.csv and bode.csv.

    Raises
    ------
    InputError
        A key that is unknown, missing or wrong; a process that cannot be tuned, a rule that does not fit.
    """
    file.only(("process", "wanted"))
    process, wanted = _process(file), file.values("wanted", WANTED | _settings())
    named = wanted.pop("rule", None)
    rule = rule or named or default_rule(process, wanted.get("form"), wanted)
    try:
        guide = recommend(process, disturbance=wanted.pop("disturbance", DISTURBANCES[0])).data()
    except ModelError as problem:
        raise ModelError(f"{file.place('process')}: {problem}") from None
    if rule == ALL:
        data, found = _all(process, wanted), None
    else:
        found = _one(file, process, rule, wanted)
        data = found.data()
    data |= _ultimate(process) | {"guide": guide}
    if output is not None:
        _write(prepare_output(output), data, found)
    return Answer(_text(data), data)


def _ultimate(process: Process) -> dict[str, float | None]:
    """Gain with which P alone makes it swing, and the period, s; None where no gain does."""
    try:
        Ku, Tu = ultimate_gain(process)
    except OutOfLimits:
        return {"Ku": None, "Tu": None}
    return {"Ku": Ku, "Tu": Tu}


def _process(file: TuningFile) -> Process:
    given = file.table("process")
    kind = given.get("kind", _KINDLESS if "num" in given and "den" in given else None)
    try:
        if not isinstance(kind, str):
            raise InputError(f"{kind!r} came; it must be one of {', '.join(PROCESSES)}")
        method = PROCESSES[kind]
    except InputError as problem:
        raise ModelError(f"{file.place('process', 'kind')}: {problem}") from None
    keys = file.values("process", {field.name: field for field in method.fields}, ("kind",))
    try:
        return make_process({"kind": kind, **keys})
    except InputError as problem:
        raise ModelError(f"{file.place('process')}: {problem}") from None


def _settings() -> dict[str, Field]:
    """Parameters of all rules."""
    return {field.name: field for name in RULES for field in RULES[name].fields}


def _one(file: TuningFile, process: Process, rule: str, wanted: Mapping[str, Any]) -> Tuning:
    try:
        return tune_process(process, rule, **_for(rule, wanted))
    except UnknownName:
        raise
    except InputError as problem:
        place = f"{file.path}: rule {rule!r}"
        fitting = ", ".join(name for name in RULES if name != rule and _fits(process, name, wanted))
        advice = f"; rules that fit: {fitting}" if fitting else "; no rule fits with this form"
        raise ModelError(f"{place}: {problem}{advice}") from None


def _fits(process: Process, rule: str, wanted: Mapping[str, Any]) -> bool:
    try:
        tune_process(process, rule, **_for(rule, wanted))
    except InputError:
        return False
    return True


def _for(rule: str, wanted: Mapping[str, Any]) -> dict[str, Any]:
    """What is wanted, but for settings of other rules."""
    known = {"form", "sample_time", "delay_samples", *(field.name for field in RULES[rule].fields)}
    return {key: value for key, value in wanted.items() if key in known}


def _all(process: Process, wanted: Mapping[str, Any]) -> dict[str, Any]:
    rules, unfit = [], {}
    for name in RULES:
        try:
            rules.append(tune_process(process, name, **_for(name, wanted)).data())
        except (ModelError, OutOfLimits, InputError) as problem:
            unfit[name] = str(problem)
    if not rules:
        raise ModelError(
            f"no rule fits this process with form {wanted.get('form', 'PI')!r}: {next(iter(unfit.values()))}"
        )
    return {"process": dict(process.given), "rules": rules, "unfit": unfit}


def _write(folder: Path, data: Mapping[str, Any], found: Tuning | None) -> None:
    (folder / "tuning.json").write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    if found is None or found.rule == "sampled":
        return
    loop = open_loop(found.process, found.gains, found.form)
    figures = loop_figures(loop)
    t, y = closed_step(loop, figures=figures)
    every = slice(None, None, max(len(t) // 2000, 1))
    _table(folder / "step.csv", "time_s,output", t[every], y[every])
    middle = figures.crossover if np.isfinite(figures.crossover) else figures.peak_frequency
    w = np.geomspace(1e-2, 1e2, 400) * middle
    L = loop.response(w)
    _table(folder / "bode.csv", "frequency_rad_per_s,size,phase_deg", w, np.abs(L), np.degrees(np.unwrap(np.angle(L))))


def _table(path: Path, header: str, *columns: Any) -> None:
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.9g")


def _text(data: Mapping[str, Any]) -> str:
    lines = [_line(row) for row in data.get("rules", [data])]
    lines += [f"warning: {row['rule']}: {w['text']}" for row in data.get("rules", [data]) for w in row["warnings"]]
    lines += [f"does not fit: {name}: {reason}" for name, reason in data.get("unfit", {}).items()]
    guide = data["guide"]
    lines += [f"recommended: {guide['recommended']}", *(f"  {reason}" for reason in guide["reasons"])]
    return "\n".join([*lines, *(f"  not {form}: {reason}" for form, reason in guide["rejected"].items())])


def _line(row: Mapping[str, Any]) -> str:
    def shown(name: str, form: str, unit: str) -> str:
        return "none" if row[name] is None else f"{row[name]:{form}}{unit}"

    smooth = row.get("overshoot_with_prefilter_percent")
    after = "" if smooth is None else f" (prefilter {smooth:.1f} %)"
    return (
        f"{row['rule']:24} {row['form']:3} Kc {row['Kc']:<8.4g} Ti {shown('Ti', '.4g', ' s'):10} Td {row['Td']:.4g} s  "
        f"{shown('phase_margin_deg', '.1f', ' deg')} at {shown('crossover', '.4g', ' rad/s')}, overshoot "
        f"{row['overshoot_percent']:.1f} %{after}, Ms {row['Ms']:.2f}"
    )

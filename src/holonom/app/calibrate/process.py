"""`holonom calibrate process`: lags, dead time and gain of a process from a recorded experiment."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.odometry_log.table import read_table
from holonom.control.processes.identify import Fit, RelayFit, identify_relay, identify_step
from holonom.errors import CalibrationError, InputError, LogError

__all__ = ["EXPERIMENTS", "calibrate_process"]

EXPERIMENTS = ("step", "relay")
COLUMNS = {"time": ("time", "t", "time_s"), "u": ("u", "input"), "y": ("y", "output")}
"""What a column is, and the names that it may have."""


def calibrate_process(
    log: Path, experiment: str, *, kind: str | None = None, hysteresis: float = 0.0, output: Path | None = None
) -> Answer:
    """Fit a process to a record.

    Parameters
    ----------
    log : CSV with columns `time` (s; or `t`, `time_s`), `u` (or `input`) and `y` (or `output`).
    experiment : "step", or any input that is held between its changes, from rest; "relay": it swings by a relay.
    kind : of model; None: the best one.
    hysteresis : of the relay, in units of the output.
    output : folder for `process.toml` and `process.json`.

    Raises
    ------
    InputError
        No such log, columns that are missing, times that do not grow, a record that tells nothing.
    """
    table = read_table(log, needed={name for names in COLUMNS.values() for name in names})
    named = {what: next((name for name in names if name in table.names), None) for what, names in COLUMNS.items()}
    missing = [what for what, name in named.items() if name is None]
    if missing:
        came = ", ".join([*table.names, *table.ignored])
        raise LogError(
            f"{log}:1: columns {came} came; {', '.join(missing)} missing: time (s), u (input) and y (output)"
        )
    t, u, y = (table.column(name) for name in named.values() if name is not None)
    if np.any(np.diff(t) <= 0.0):
        row = int(np.argmax(np.diff(t) <= 0.0)) + 1
        table.fault(row, str(named["time"]), f"{t[row]:g} s after {t[row - 1]:g} s; time must grow")
    try:
        data = (
            _relay(identify_relay(t, u, y, hysteresis=hysteresis, kind=kind))
            if experiment == EXPERIMENTS[1]
            else _fit(identify_step(t, u, y, kind=kind))
        )
    except InputError as problem:
        raise CalibrationError(f"{log}: {problem}") from None
    notes = [f"{log}:1: not read: column {', '.join(table.ignored)}"] if table.ignored else []
    data = {"log": str(log), "experiment": experiment, **data, "notes": notes}
    if output is not None:
        folder = prepare_output(output)
        (folder / "process.json").write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        (folder / "process.toml").write_text(_toml(data["process"]), encoding="utf-8")
    return Answer(_text(data), data)


def _fit(fit: Fit) -> dict[str, Any]:
    return {
        "process": dict(fit.process.given),
        "misfit": fit.misfit,
        "misfit_percent": fit.misfit_percent,
        "compared_percent": dict(fit.compared),
    }


def _relay(found: RelayFit) -> dict[str, Any]:
    names = ("relay", "amplitude", "period", "Ku_describing_function", "Ku_exact", "Tu_exact",
             "describing_function_error_percent")  # fmt: skip
    swings = math.isfinite(found.Ku_exact)
    values = {name: getattr(found, name) for name in names}
    return _fit(found.fit) | {name: value if swings or math.isfinite(value) else None for name, value in values.items()}


def _toml(process: Mapping[str, Any]) -> str:
    return "\n".join(["[process]", *(f"{key} = {json.dumps(value)}" for key, value in process.items())]) + "\n"


def _text(data: Mapping[str, Any]) -> str:
    keys = [f"{key} {_shown(value)}" for key, value in data["process"].items() if key != "kind"]
    lines = [
        f"{data['process']['kind']}: {', '.join(keys)}; misfit {data['misfit_percent']:.2g} % of the output's range"
    ]
    lines += [f"  {kind}: misfit {value:.2g} %" for kind, value in data["compared_percent"].items()]
    if data.get("Ku_exact") is not None:
        lines.append(
            f"ultimate gain {data['Ku_exact']:.4g}, period {data['Tu_exact']:.4g} s; by the describing function "
            f"{data['Ku_describing_function']:.4g}, {data['describing_function_error_percent']:.1f} % off"
        )
    return "\n".join([*lines, *(f"note: {note}" for note in data["notes"])])


def _shown(value: Any) -> str:
    return " ".join(f"{each:.5g}" for each in value) if isinstance(value, list) else f"{value:.5g}"

"""`holonom calibrate odometry`: a base's geometry from logs of its wheels and the truth."""

from __future__ import annotations

import importlib.util
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from holonom.app.calibrate.odometry_text import LABELS, text_of
from holonom.app.calibrate.sensors import sensors_of, slips_of
from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.odometry_log import OdometryLog, read_log, write_log
from holonom.arrays import Array
from holonom.errors import CalibrationError, MissingExtra, UnknownName
from holonom.mobile import WheelBase
from holonom.mobile.calibration import (
    DRIVES,
    SETS,
    Calibration,
    Motion,
    PathErrors,
    UMBmark,
    article,
    calibrate,
    dead_reckoning,
    drive_parameters,
    end_scatter,
    held_out_errors,
    identifiability,
    lever_of,
    umbmark,
)
from holonom.mobile.methods import ARRANGEMENTS

__all__ = ["FILE", "METHODS", "PICTURE", "TOPICS", "calibrate_odometry"]


METHODS = ("least-squares", "umbmark")
FILE, PICTURE = "odometry.json", "odometry.png"
ASTRAY = 0.05  # share of its way by which a calibrated run may miss the truth without a note
TOPICS = ("/odom_nominal", "/odom_calibrated")
SURE = 0.005  # share of a physical parameter that the extended set may leave open at any cost
DEAR = 1.5  # times less sure that the extended set may make the physical parameters, unless it is asked for
EXACT = 1e-6  # m, mean error at the ends of runs that needs no better
DRAWN = 12  # runs in the picture, the first ones


def calibrate_odometry(
    paths: Sequence[Path],
    *,
    drive: str | None = None,
    method: str = "least-squares",
    parameters: str | None = None,
    form: str | None = None,
    rule: str = "midpoint",
    held_out: bool = False,
    data_sheet: bool = True,
    limits: Sequence[float] | None = None,
    classical_limits: bool = False,
    allow_gaps: bool = False,
    mcap: bool = False,
    output: Path | None = None,
) -> Answer:
    """Calibrate the odometry of a base from logs.

    Parameters
    ----------
    paths : as `odometry_log.read_log` takes them.
    drive : a key of `DRIVES`, or an arrangement of wheels; that of the logs unless given.
    method : one of `METHODS`.
    parameters : for least squares, one of `SETS`; unless given the extended set where the motion tells it and the ends
        of the runs are better for it.
    form : of UMBmark: "x", "y" or "mean"; "x" unless given.
    rule : of integration, a key of `odometry.RULES`.
    held_out : for least squares, also the errors of each run by a calibration from the others.
    data_sheet : for least squares, nominal lengths count as measured too; as `calibrate` takes it.
    limits : for least squares, largest errors allowed: m and degrees on the way, m and degrees at the end.
    classical_limits : instead, those of a classical calibration by the ends of the runs, for the extended set.
    allow_gaps : let gaps in the logs pass with a note.
    mcap : leave the log in the output folder too, runs as MCAP with the odometry before and after (`TOPICS`).
    output : folder for `odometry.json` and, with Matplotlib, a picture of the paths.

    Raises
    ------
    InputError
        Any fault of a log, or a motion that does not tell what is asked.
    """
    for kind, name, known in (("method", method, METHODS), ("set of parameters", parameters or SETS[0], SETS)):
        if name not in known:
            raise UnknownName(kind, name, known)
    if drive is not None and drive not in DRIVES and drive not in ARRANGEMENTS:
        raise UnknownName("drive that can be calibrated", drive, [*DRIVES, *ARRANGEMENTS])
    _check_options(
        method, parameters, form, limits, held_out=held_out, classical=classical_limits, data_sheet=data_sheet
    )
    if mcap and output is None:
        raise CalibrationError("--mcap came without -o; name the folder that the recordings go to")
    log = read_log(paths, drive=drive, allow_gaps=allow_gaps)
    try:
        found = (
            _umbmark(log, form or "x", rule)
            if method == "umbmark"
            else _least_squares(
                log, parameters, rule, "classical" if classical_limits else limits, data_sheet=data_sheet
            )
        )
        if held_out:
            errors = held_out_errors(
                log.runs, *_asked(log), set_name=found.data["set"], rule=rule, data_sheet=data_sheet
            )
            found.data["errors_held_out"] = _errors(errors)
    except CalibrationError as error:
        raise CalibrationError("\n".join([str(error), *(f"note: {note}" for note in log.notes)])) from None
    data = {"drive": log.drive, "method": method, "rule": rule, "runs": [run.name for run in log.runs], **found.data}
    data |= sensors_of(log)
    data["nonsystematic"] = _scatter(log, found.motion, rule)
    data["notes"] = [*log.notes, *found.notes, *_astray(log, found.motion, rule)]
    if output is not None:
        folder = prepare_output(output)
        if not _draw(log, found.motion, rule, folder / PICTURE):
            data["notes"].append(f"no picture of the paths: {MissingExtra('it', 'Matplotlib', 'plots')}")
        if mcap:
            others = dict(zip(TOPICS, _both_paths(log, found.motion, rule).values(), strict=True))
            data["recordings"] = str(write_log(log, folder, runs="mcap", others=others))
        (folder / FILE).write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return Answer(text_of(data), data)


def _check_options(
    method: str, parameters: str | None, form: str | None, limits: Sequence[float] | None, *, held_out: bool,
    classical: bool, data_sheet: bool,
) -> None:  # fmt: skip
    """Refuse options that the method knows nothing of, and limits of two kinds."""
    if classical and limits is not None:
        raise CalibrationError("--limits and --classical-limits came; it is one of the two")
    if method == "umbmark":
        options = {"--parameters": parameters is not None, "--limits": limits is not None, "--held-out": held_out}
        options |= {"--classical-limits": classical, "--runs-alone": not data_sheet}
        named = [name for name, given in options.items() if given]
        if named:
            raise CalibrationError(f"{' and '.join(named)} came with umbmark; leave it out, or use least-squares")
    elif form not in (None, "x"):
        raise CalibrationError(f"--form {form} came with least-squares; leave it out, or use --method umbmark")


def _astray(log: OdometryLog, motion: Array | Motion, rule: str) -> tuple[str, ...]:
    """Notes on runs that calibrated odometry still misses by much of their way."""
    notes, lever = [], lever_of(motion)
    for run in log.runs:
        path = dead_reckoning(run, motion, rule)
        steps = np.diff(path, axis=0)
        way = float(np.hypot(steps[:, 0], steps[:, 1]).sum() + lever * np.abs(steps[:, 2]).sum())
        miss = float(np.hypot(*(path[:, :2] - run.truth[:, :2]).T).max())
        if miss > ASTRAY * way:
            notes.append(
                f"run {run.name} is still {miss:.3g} m astray after calibration, {miss / way:.0%} of its way: the "
                "result is not to be trusted; see columns, units, slip and gaps, or leave the run out"
            )
    return tuple(notes)


@dataclass(frozen=True, slots=True)
class _Found:
    """What a method found: JSON values, what `dead_reckoning` takes, notes."""

    data: dict[str, Any]
    motion: Array | Motion
    notes: tuple[str, ...]


def _umbmark(log: OdometryLog, form: str, rule: str) -> _Found:
    if log.drive != "differential" or log.subject.base is not None:
        raise CalibrationError(f"UMBmark is for differential drives; for {article(log.drive)} use least-squares")
    if log.side is None and log.sides:
        raise CalibrationError(
            f"squares of sides {', '.join(f'{side:g}' for side in log.sides)} m came, or of none stated: UMBmark needs "
            "squares of one side; give the sets one by one, or use least-squares"
        )
    if log.side is None:
        raise CalibrationError(
            f"{log.source} states no side of a square; state it (L in the metadata, side in the TOML file), or use "
            "least-squares"
        )
    result: UMBmark = umbmark(log.runs, log.nominal, log.side, form=form, rule=rule)
    names = list(result.calibrated)
    matrix = drive_parameters("differential", result.calibrated).matrix(np.array(list(result.calibrated.values())))
    return _Found(
        {
            "form": form,
            "side": result.side,
            "nominal": dict(result.nominal),
            "calibrated": dict(result.calibrated),
            "deviations": {name: _number(result.deviations[name]) for name in names},
            "E_b": result.E_b,
            "E_d": result.E_d,
            "alpha": result.alpha,
            "beta": result.beta,
            "clockwise": result.clockwise.tolist(),
            "counterclockwise": result.counterclockwise.tolist(),
            "errors_before": {**_errors(result.before), "E_max_m": result.E_max[0]},
            "errors_after": {**_errors(result.after), "E_max_m": result.E_max[1]},
        },
        matrix,
        result.notes,
    )


def _least_squares(
    log: OdometryLog,
    parameters: str | None,
    rule: str,
    limits: Sequence[float] | Literal["classical"] | None,
    *,
    data_sheet: bool,
) -> _Found:
    plain, refused = _attempt(log, "physical", rule, data_sheet=data_sheet)
    told = refused
    if parameters == "physical" and plain is None:
        raise CalibrationError(refused)
    chosen = plain
    wanted: Sequence[float] | Literal["classical"] | None = None
    if limits == "classical":
        wanted = "classical"
    elif limits is not None:
        wanted = [limits[0], math.radians(limits[1]), limits[2], math.radians(limits[3])]
    notes: tuple[str, ...] = ()
    if parameters != "physical":
        chosen, refused = _attempt(log, "extended", rule, wanted, data_sheet=data_sheet)
        if chosen is None and (parameters == "extended" or plain is None):
            raise CalibrationError(refused if parameters == "extended" else told)
        if chosen is None:
            chosen, notes = plain, (f"physical parameters only; of the extended set {refused}",)
        elif parameters is None and wanted is None and plain is not None and (why := _idle(plain, chosen)):
            chosen, notes = plain, (f"physical parameters only; the extended set {why}",)
    if chosen is plain and wanted is not None:
        chosen = calibrate(log.runs, *_asked(log), set_name="physical", rule=rule, limits=wanted)
    assert chosen is not None
    matrix = {} if isinstance(chosen.motion, Motion) else {"matrix": chosen.motion.tolist()}
    data = {"set": chosen.set, **_values(chosen), **matrix, **_ratios(chosen)}
    data["identifiability"] = _told(log, chosen.set, rule)
    data |= {"condition": chosen.condition, "lever_m": chosen.lever, "errors_before": _errors(chosen.before)}
    data |= {"limits": _limits(chosen), "growth": chosen.growth, "doubt": _number(chosen.doubt)}
    data["clocks_s"] = [_number(float(clock)) for clock in chosen.clocks]
    data |= {"correlation": chosen.correlation.tolist(), "errors_after": _errors(chosen.after)}
    if plain is not None:
        data["physical"] = {**_values(plain), "errors_after": _errors(plain.after)}
    slips = slips_of(log, log.subject.parameters(chosen.set), chosen.values)
    return _Found(data, chosen.motion, (*notes, *slips))


def _asked(log: OdometryLog) -> tuple[str | WheelBase, Mapping[str, float] | None]:
    """What is calibrated, and its numbers where it has none of its own."""
    subject = log.subject
    return (subject.drive, subject.geometry) if subject.base is None else (subject.base, None)


def _told(log: OdometryLog, set_name: str, rule: str) -> dict[str, Any]:
    """Which numbers the runs tell, which only little, and which run would help."""
    found = identifiability(log.runs, *_asked(log), set_name=set_name, rule=rule)
    return {
        "weak": [
            {"shares": dict(one.shares), "told": one.told, "run": one.run, "text": one.text()} for one in found.weak
        ],
        "never_told": {name: list(others) for name, others in found.gauge.items()},
    }


def _idle(plain: Calibration, wide: Calibration) -> str:
    """Why the extended set is not worth its parameters; empty where it is."""
    cost = _cost(plain, wide)
    if cost > DEAR:
        return f"makes them {cost:.1f} times less sure"
    without, with_ = (float(one.after.final_distances.mean()) for one in (plain, wide))
    if with_ > max(without, EXACT):
        return f"leaves {1e3 * with_:.3g} mm at the ends of the runs, where they leave {1e3 * without:.3g} mm"
    return ""


def _cost(plain: Calibration, wide: Calibration) -> float:
    """How many times less sure the extended set makes the physical parameters, in the mean; 0 where they are sure."""
    shared = [name for name in wide.names if name in plain.names]
    if not shared:
        return 0.0
    at = [wide.names.index(name) for name in shared], [plain.names.index(name) for name in shared]
    open_ = wide.deviations[at[0]] / np.maximum(np.abs(wide.values[at[0]]), 1e-12)
    if open_.mean() < SURE:
        return 0.0
    ratios = wide.deviations[at[0]] / np.maximum(plain.deviations[at[1]], 1e-300)
    return float(np.exp(np.mean(np.log(np.maximum(ratios, 1e-12)))))


def _attempt(
    log: OdometryLog,
    set_name: str,
    rule: str,
    limits: Sequence[float] | Literal["classical"] | None = None,
    *,
    data_sheet: bool,
) -> tuple[Calibration | None, str]:
    """A calibration, or the reason why the motion does not tell it."""
    try:
        return calibrate(log.runs, *_asked(log), set_name=set_name, rule=rule, limits=limits, data_sheet=data_sheet), ""
    except CalibrationError as error:
        return None, str(error)


def _values(found: Calibration) -> dict[str, Any]:
    columns = {"nominal": found.nominal, "calibrated": found.values, "deviations": found.deviations}
    return {key: dict(zip(found.names, values.tolist(), strict=True)) for key, values in columns.items()}


def _ratios(found: Calibration) -> dict[str, float]:
    """E_b and E_d of a differential drive."""
    if "wheelbase" not in found.names or "diameter_right" not in found.names:
        return {}
    new, old = (dict(zip(found.names, v.tolist(), strict=True)) for v in (found.values, found.nominal))
    return {"E_b": new["wheelbase"] / old["wheelbase"], "E_d": new["diameter_right"] / new["diameter_left"]}


def _limits(found: Calibration) -> dict[str, float | None]:
    """Limits that the largest errors were held to; None where free."""
    units = (1.0, 180.0 / math.pi, 1.0, 180.0 / math.pi)
    names = [key for key in LABELS if key.startswith("max_")]
    return {name: _number(float(limit) * unit) for name, limit, unit in zip(names, found.limits, units, strict=True)}


def _scatter(log: OdometryLog, motion: Array | Motion, rule: str) -> dict[str, Any]:
    """What is left at the ends of repeated runs, and behind bumps."""
    found = end_scatter(log.runs, motion, bumped=log.bumped, rule=rule)
    sizes = np.sqrt(np.diagonal(found.covariance))
    return {
        "courses": list(found.courses),
        "spread_m": _number(found.spread),
        "deviations": {
            "x_m": _number(sizes[0]),
            "y_m": _number(sizes[1]),
            "heading_deg": _number(np.degrees(sizes[2])),
        },
        "bump_deg": _number(math.degrees(found.bump)),
    }


def _errors(errors: PathErrors) -> dict[str, Any]:
    return {
        "max_distance_m": errors.distance,
        "max_heading_deg": math.degrees(errors.heading),
        "max_final_distance_m": errors.final_distance,
        "max_final_heading_deg": math.degrees(errors.final_heading),
        "runs": [
            {
                "distance_m": float(d),
                "heading_deg": math.degrees(h),
                "final_distance_m": float(fd),
                "final_heading_deg": math.degrees(fh),
            }
            for d, h, fd, fh in zip(
                errors.distances, errors.headings, errors.final_distances, errors.final_headings, strict=True
            )
        ],
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _draw(log: OdometryLog, motion: Array | Motion, rule: str, path: Path) -> bool:
    """Draw the first runs; False where that cannot be."""
    if importlib.util.find_spec("matplotlib") is None:
        return False
    from holonom.plots.odometry import draw_odometry

    runs = log.runs[:DRAWN]
    drawn = {name: paths[:DRAWN] for name, paths in _both_paths(log, motion, rule).items()}
    draw_odometry([run.truth for run in runs], drawn, names=[run.name for run in runs], save=path)
    return True


def _both_paths(log: OdometryLog, motion: Array | Motion, rule: str) -> dict[str, list[Array]]:
    """Poses (N, 3) of every run by nominal and by calibrated odometry."""
    nominal = log.subject.parameters()
    models = {"nominal": nominal.motion(nominal.nominal), "calibrated": motion}
    return {name: [dead_reckoning(run, M, rule) for run in log.runs] for name, M in models.items()}

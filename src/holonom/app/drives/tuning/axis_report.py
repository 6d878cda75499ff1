"""The report of a tuned axis for a customer: one page that holds all that it needs."""

from __future__ import annotations

import dataclasses
import io
import math
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from holonom.app.drives.files import AxisFile
from holonom.app.drives.tuning.tables import gain_unit
from holonom.arrays import Array
from holonom.closed_loop.axis import AxisRun
from holonom.closed_loop.axis_tuning import AxisTuning, try_gains
from holonom.control.servo.law_design import Servo, servo_loops
from holonom.devices.motors.thermal import ThermalModel
from holonom.plots.axis import draw_bode, draw_spread, draw_steps, draw_torque_speed
from holonom.sim import Axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["write_report"]

RUNS = 100
"""Axes that the spread is of."""
TOLERANCES = {"resistance": 0.1, "inductance": 0.15, "constants": 0.05, "load inertia": 0.2, "friction": 0.5}
"""Parts by which they differ from their sheets at most."""
STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2rem; }
table { border-collapse: collapse; } td, th { padding: .2rem .9rem .2rem 0; text-align: left; }
td.n { text-align: right; font-variant-numeric: tabular-nums; } svg { max-width: 100%; height: auto; }
.warning { border-left: 4px solid #D55E00; padding-left: .8rem; margin: .5rem 0; }
"""


def write_report(
    folder: Path, read: AxisFile, found: AxisTuning, thermal: ThermalModel | None, servo: Servo, data: Mapping[str, Any]
) -> None:
    """Write report.html, step.csv, move.csv into a folder.

    Raises
    ------
    MissingExtra
        Matplotlib is not installed.
    """
    for name, run in (("step", found.step), ("move", found.move)):
        columns = (run.time, run.reference, run.position, run.speed, run.current, run.voltage)
        np.savetxt(
            folder / f"{name}.csv", np.column_stack(columns), delimiter=",", comments="", fmt="%.9g",
            header="time_s,reference_rad,position_rad,speed_rad_per_s,current_A,voltage_V",
        )  # fmt: skip
    parts = [
        f"<h1>{escape(read.motor.title)}</h1><p>{escape(str(read.path.name))}; {escape(read.motor.source)}</p>",
        *(f'<p class="warning">{escape(w["text"])}</p>' for w in data["warnings"]),
        "<h2>The axis</h2>", _table(_sheet(found.axis)),
        "<h2>Gains</h2>", _table({"servo": str(servo)} | _gains(data)), _svg(_bode(found)),
        "<h2>A step</h2>", _table(_shown(data)), _svg(_step(found.step)),
        "<h2>A move there and back</h2>", _svg(_move(found.move)),
        "<h2>Torque and speed</h2>", _svg(_plane(found, thermal)),
        "<h2>Spread</h2>", f"<p>{RUNS} axes with these gains, {_tolerances()}.</p>", _svg(draw_spread(_spread(found))),
    ]  # fmt: skip
    page = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(read.motor.title)}</title>'
    (folder / "report.html").write_text(f"{page}<style>{STYLE}</style><body>{''.join(parts)}</body></html>", "utf-8")


def _table(rows: Mapping[str, str]) -> str:
    cells = "".join(f"<tr><td>{escape(name)}</td><td class=n>{escape(value)}</td></tr>" for name, value in rows.items())
    return f"<table>{cells}</table>"


def _svg(figure: Figure) -> str:
    text = io.StringIO()
    figure.savefig(text, format="svg")
    return text.getvalue()[text.getvalue().index("<svg") :]


def _sheet(axis: Axis) -> dict[str, str]:
    m, load = axis.motor, axis.load
    return {
        "resistance, inductance": f"{m.resistance:g} ohm, {1e3 * m.inductance:g} mH",
        "torque constant": f"{m.torque_constant:g} N m/A",
        "rotor inertia": f"{m.rotor_inertia:g} kg m2",
        "supply, current limit": f"{m.max_voltage:g} V, {m.max_current:g} A",
        "gear": f"{axis.gear.ratio:g}, efficiency {axis.gear.efficiency:g}",
        "gap": f"{math.degrees(axis.gap):.3g} deg",
        "stiffness": "rigid" if math.isinf(axis.stiffness) else f"{axis.stiffness:g} N m/rad",
        "load": f"{load.inertia:g} kg m2, {load.coulomb:g} N m Coulomb, {load.viscous:g} N m s/rad",
        "encoder": f"{axis.encoder.counts_per_rev} counts per turn",
    }


def _gains(data: Mapping[str, Any]) -> dict[str, str]:
    found = {}
    for name, loop in data["loops"].items():
        Ti = "" if loop["Ti"] is None else f", Ti {1e3 * loop['Ti']:.4g} ms"
        margin = f"{loop['phase_margin_deg']:.0f} deg at {loop['crossover'] / (2.0 * math.pi):.4g} Hz"
        unit = gain_unit(name, data["loops"])
        found[f"{name}, {loop['form']}"] = f"Kc {loop['Kc']:.5g} {unit}{Ti}; {margin}"
    return found


def _shown(data: Mapping[str, Any]) -> dict[str, str]:
    v = data["verified"]
    hot = v["winding_temperature"]
    return {
        "overshoot": f"{v['overshoot_percent']:.2g} %",
        "settles to 2 % in": "not at all" if v["settling_time"] is None else f"{1e3 * v['settling_time']:.4g} ms",
        "ripple at rest": f"{v['position_ripple']:.2g} rad",
        "a move is followed within": f"{v['following_error']:.3g} rad",
        "its current and voltage": f"{v['peak_current']:.4g} A, {v['peak_voltage']:.4g} V",
        "winding, moving without a pause": "not known" if hot is None else f"{hot:.4g} degC",
    }


def _bode(found: AxisTuning) -> Figure:
    axis, gains = found.axis.servo_axis(), found.gains
    loops = servo_loops(axis, gains)
    times = gains.times
    tops = {"current": times.current, "speed": times.speed, "position": times.position, "angle": times.speed}
    drawn = {}
    for name, loop in loops.items():
        w = np.geomspace(1e-4, 1.0, 600) * math.pi / tops[name]
        drawn[name] = (w, loop(1j * w))
    return draw_bode(drawn, {name: found.loops[name].margin.crossover for name in loops})


def _step(run: AxisRun) -> Figure:
    return draw_steps(
        run.time,
        {
            "rad": {"reference": run.reference, "position": run.position},
            "A": {"current": run.current},
            "V": {"voltage": run.voltage},
        },
    )


def _move(run: AxisRun) -> Figure:
    return draw_steps(
        run.time,
        {
            "rad": {"reference": run.reference, "position": run.position},
            "mrad": {"error": 1e3 * (run.reference - run.position)},
            "rad/s": {"speed of the motor": run.motor_speed},
            "A": {"current": run.current},
        },
    )


def _plane(found: AxisTuning, thermal: ThermalModel | None) -> Figure:
    m = found.axis.motor
    speed = np.linspace(0.0, m.no_load_speed, 300)

    def torque(current: float) -> Array:
        driven = (m.max_voltage - m.back_emf_constant * speed) / m.resistance
        return m.torque_constant * np.clip(driven, 0.0, current)

    lasting = None if thermal is None else torque(thermal.largest_current())
    move = found.move
    at = np.where(move.motor_speed < 0.0, -1.0, 1.0)
    return draw_torque_speed(
        speed, torque(m.max_current), lasting, (np.abs(move.motor_speed), at * m.torque_constant * move.current)
    )


def _spread(found: AxisTuning) -> dict[str, Array]:
    """Overshoot, settling time and following error of axes that differ from their sheets."""
    rng = np.random.default_rng(0)
    rows = [
        (v.overshoot_percent, 1e3 * min(v.settling_time, found.step.time[-1]), 1e3 * v.following_error)
        for v in (try_gains(found, _other(found.axis, rng)) for _ in range(RUNS))
    ]
    names = ("overshoot (%)", "settles in (ms)", "follows within (mrad)")
    return dict(zip(names, np.array(rows).T, strict=True))


def _other(axis: Axis, rng: np.random.Generator) -> Axis:
    t = {name: 1.0 + part * rng.uniform(-1.0, 1.0) for name, part in TOLERANCES.items()}
    m, f, load = axis.motor, axis.rubbing, axis.load
    motor = dataclasses.replace(
        m, resistance=m.resistance * t["resistance"], inductance=m.inductance * t["inductance"],
        torque_constant=m.torque_constant * t["constants"], back_emf_constant=m.back_emf_constant * t["constants"],
    )  # fmt: skip
    rub = t["friction"]
    return dataclasses.replace(
        axis, motor=motor,
        load=dataclasses.replace(
            load, inertia=load.inertia * t["load inertia"], coulomb=load.coulomb * rub, viscous=load.viscous * rub
        ),
        friction=dataclasses.replace(
            f, viscous=f.viscous * rub, coulomb_positive=f.coulomb_positive * rub,
            coulomb_negative=f.coulomb_negative * rub,
        ),
    )  # fmt: skip


def _tolerances() -> str:
    return ", ".join(f"{name} off by up to {100 * part:g} %" for name, part in TOLERANCES.items())

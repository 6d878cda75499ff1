"""Reading a load cycle, and the motors and gears that may make it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field, create_model

from holonom.app.drives.files import SupplyTable, read_model, written_motor
from holonom.app.drives.values import PlainOrQuantity, sheet_table
from holonom.app.fields.quantities import Section, Text
from holonom.devices import MOTORS, GearChoice, LoadCycle, MotorCard, SizingLimits, motor_card
from holonom.errors import InputError, ModelError

__all__ = ["RATIOS", "Candidates", "CycleFile", "read_cycle", "standard_candidates"]

RATIOS = (1.0, 3.7, 5.2, 14.0, 19.0, 27.0, 35.0, 43.0, 51.0, 66.0, 81.0, 100.0, 120.0, 160.0)
"""Of gears where none are given: usual planetary and harmonic ones."""
EFFICIENCY = 0.8
"""Assumed of these."""


class MoveTable(Section):
    """A move from rest to rest in thirds, and the load; or samples of both."""

    angle: Annotated[float | None, PlainOrQuantity("rad")] = None
    """of the move"""
    time: Annotated[float | None, PlainOrQuantity("s", above=0.0)] = None
    """of the move"""
    inertia: Annotated[float, PlainOrQuantity("kg m2", least=0.0)] = 0.0
    """of the load"""
    friction: Annotated[float, PlainOrQuantity("N m", least=0.0)] = 0.0
    """torque against the motion"""
    load: Annotated[float, PlainOrQuantity("N m")] = 0.0
    """torque that is always there"""
    dwell: Annotated[float, PlainOrQuantity("s", least=0.0)] = 0.0
    """rest after the move, under the load"""
    samples: list[tuple[float, float, float]] | None = None
    """time (s), speed (rad/s) and torque (N m) of each, instead of a move"""
    J_motor: Annotated[float | None, PlainOrQuantity("kg m2", above=0.0)] = None
    """of a rotor, for the ratio with the greatest acceleration"""
    J_load: Annotated[float | None, PlainOrQuantity("kg m2", above=0.0)] = None
    """of the load, for that ratio"""


class GearEntry(Section):
    """A gear that may be taken."""

    name: Text = "gear"
    """what it is called"""
    ratio: Annotated[float, PlainOrQuantity("", above=0.0)]
    """motor turns per turn of the load"""
    efficiency: Annotated[float, PlainOrQuantity("", above=0.0, most=1.0)] = 1.0
    """part of the power that arrives"""
    inertia: Annotated[float, PlainOrQuantity("kg m2", least=0.0)] = 0.0
    """at the motor's shaft"""
    max_torque: Annotated[float | None, PlainOrQuantity("N m", above=0.0)] = None
    """at its output"""


class LimitTable(Section):
    """What every choice keeps to."""

    inertia_ratio: Annotated[float, PlainOrQuantity("", above=0.0)] = 10.0
    """load over rotor, at the motor"""
    ambient: Annotated[float, PlainOrQuantity("degC", least=-60.0, most=120.0)] = 25.0
    """temperature of the air"""


@dataclass(frozen=True, slots=True)
class Candidates:
    """What may be taken, what it keeps to, and what of that was assumed."""

    motors: tuple[MotorCard, ...]
    gears: tuple[GearChoice, ...]
    limits: SizingLimits
    assumed: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class CycleFile:
    """A cycle file; `cycle` is None where it only asks for the ratio of two inertias, (rotor, load) in kg m^2."""

    cycle: LoadCycle | None
    inertias: tuple[float, float] | None
    candidates: Candidates


def read_cycle(path: Path) -> CycleFile:
    """Read a load cycle: its keys in a table `[cycle]` or at the top of the file.

    Raises
    ------
    ModelError
        A line for each fault; a cycle without a move and without samples.
    """
    rest: dict[str, Any] = {
        "cycle": (MoveTable | None, None),
        "supply": (SupplyTable | None, None),
        "limits": (LimitTable | None, None),
        "gear": (list[GearEntry], Field([], description="gears that may be taken")),
        "motor": (list[sheet_table()], Field([], description="motors that may be taken")),  # type: ignore[misc]
        "motors": (list[Text], Field([], description="names of motors that may be taken")),
    }
    model = create_model("CycleTables", __base__=MoveTable, **rest)
    found: Any
    found, text = read_model(path, model)
    move = found.cycle if found.cycle is not None else found
    inertias = None if move.J_motor is None or move.J_load is None else (move.J_motor, move.J_load)
    return CycleFile(_cycle(path, move, inertias is not None), inertias, _candidates(path, text, found))


def _cycle(path: Path, move: Any, may_lack: bool) -> LoadCycle | None:
    try:
        if move.samples is not None:
            rows = np.array(move.samples, dtype=np.float64).reshape(-1, 3)
            return LoadCycle.sampled(rows[:, 0], rows[:, 1], rows[:, 2], inertia=move.inertia)
        if move.angle is not None and move.time is not None:
            return LoadCycle.move(
                move.angle, move.time, move.inertia, friction=move.friction, load=move.load, dwell=move.dwell
            )
    except InputError as problem:
        raise ModelError(f"{path}: {problem}") from None
    if may_lack:
        return None
    raise ModelError(f"{path}: no load cycle; give angle and time (and inertia, friction, load, dwell), or samples")


def _candidates(path: Path, text: str, found: Any) -> Candidates:
    supply, limit = found.supply or SupplyTable(), found.limits or LimitTable()
    limits = SizingLimits(
        voltage=supply.voltage,
        current=float("inf") if supply.current_limit is None else supply.current_limit,
        inertia_ratio=limit.inertia_ratio,
        ambient=limit.ambient,
    )
    standard = standard_candidates(limits)
    try:
        motors = [motor_card(name) for name in found.motors]
    except InputError as problem:
        raise ModelError(f"{path}: motors: {problem}") from None
    motors += [written_motor(path, text, table, "motor") for table in found.motor]
    gears = tuple(
        GearChoice(g.ratio, g.efficiency, g.inertia, float("inf") if g.max_torque is None else g.max_torque, g.name)
        for g in found.gear
    )
    return Candidates(
        tuple(motors) or standard.motors, gears or standard.gears, limits, () if gears else standard.assumed
    )


def standard_candidates(limits: SizingLimits | None = None) -> Candidates:
    """Every motor of `MOTORS` with usual gears."""
    gears = tuple(GearChoice(ratio, EFFICIENCY if ratio > 1.0 else 1.0, name=f"{ratio:g}:1") for ratio in RATIOS)
    assumed = f"gears of usual ratios with an efficiency of {EFFICIENCY:g}, without inertia: give [[gear]]"
    motors = tuple(MOTORS.make(name) for name in MOTORS.own)
    return Candidates(motors, gears, SizingLimits() if limits is None else limits, (assumed,))

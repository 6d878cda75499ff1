"""`holonom check` of motors that are no DC motors: the keys of a sheet say which one it is of."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from holonom.app.console.answer import Answer
from holonom.app.drives.tuning.tables import TuningFile
from holonom.app.fields.toml_faults import parse_toml
from holonom.devices import Finding, InductionMotor, Pmsm, Stepper
from holonom.devices.motors.sheet_check import CONTRADICTION
from holonom.errors import InputError, ModelError
from holonom.files import read_text
from holonom.registry import check_fields, parameter, parameters_of, read_record

__all__ = ["KINDS", "check_other_motor", "other_motor"]

RPM = math.pi / 30.0
SLIP = 0.03
MICROSTEPS = 16
AGREES = 0.05
"""Part by which two numbers for the same may differ."""
TEXTS = ("name", "source", "note")


@dataclass(frozen=True, slots=True, kw_only=True)
class SynchronousSheet:
    """A synchronous or brushless motor; values of one phase, currents as peak values."""

    pole_pairs: int = parameter(meaning="p", least=1, most=100)
    psi: float | None = parameter(None, meaning="linkage of the magnets", unit="V s", above=0.0)
    torque_constant_per_peak_A: float | None = parameter(None, meaning="3/2 p psi", unit="N m/A", above=0.0)
    R_phase: float | None = parameter(None, meaning="resistance", unit="ohm", above=0.0)
    L_phase: float | None = parameter(None, meaning="inductance, if it is the same along and across", unit="H", above=0)
    Ld: float | None = parameter(None, meaning="inductance along the magnets", unit="H", above=0.0)
    Lq: float | None = parameter(None, meaning="inductance across the magnets", unit="H", above=0.0)
    Udc: float | None = parameter(None, meaning="voltage of the DC link", unit="V", above=0.0)
    modulation: str = parameter("space vector", meaning="of the bridge", choices=("space vector", "sine"))
    current: float | None = parameter(None, meaning="peak, of which the most torque is asked", unit="A", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.psi is None and self.torque_constant_per_peak_A is None:
            raise ModelError("neither psi nor torque_constant_per_peak_A came; one of them is needed")

    @property
    def flux(self) -> float:
        """Linkage of the magnets, V s: psi, or by the torque constant."""
        return self.psi if self.psi is not None else (self.torque_constant_per_peak_A or 0.0) / (1.5 * self.pole_pairs)

    def derived(self) -> dict[str, float]:
        """What follows, as far as the numbers go; what a formula does not need is 1 in the record."""
        along, across = self.Ld or self.L_phase, self.Lq or self.L_phase
        m = Pmsm(
            self.R_phase or 1.0, along or 1.0, across or 1.0, self.flux, self.pole_pairs, 1.0, self.Udc or 1.0,
            self.current or 1.0, self.modulation.replace(" ", "_"),
        )  # fmt: skip
        found = {"psi": self.flux, "torque_constant_per_peak_A": m.torque_constant}
        if self.Udc is not None:
            found["no_load_speed"] = m.no_load_speed
        if along is not None and across is not None:
            if self.R_phase is not None:
                torque, speed = m.short_circuit_brake()
                found |= {"short_circuit_brake_peak_torque": torque, "short_circuit_speed_of_peak": speed}
            if self.current is not None:
                best = m.most_torque_per_ampere(self.current)
                found |= {"id": best.d, "iq": best.q, "torque": m.torque(best)}
        return found

    def findings(self) -> Iterator[Finding]:
        """What contradicts what."""
        k = self.torque_constant_per_peak_A
        if self.psi is not None and k is not None:
            due = 1.5 * self.pole_pairs * self.psi
            if abs(k / due - 1.0) > AGREES:
                text = f"{k:.5g} N m/A beside {due:.5g} N m/A by 3/2 p psi, factor {k / due:.3g}"
                yield Finding("torque constant against psi", CONTRADICTION, text, k, due)


@dataclass(frozen=True, slots=True, kw_only=True)
class StepperSheet:
    """A two-phase hybrid stepping motor."""

    holding_torque: float = parameter(meaning="both phases at rated current", unit="N m", above=0.0)
    rotor_teeth: int = parameter(meaning="four full steps each", least=1, most=1000)
    inertia: float = parameter(meaning="of rotor and load", unit="kg m2", above=0.0)
    load: float = parameter(0.0, meaning="torque at rest", unit="N m", least=0.0)
    steps_per_turn: int | None = parameter(None, meaning="full steps", least=4)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def derived(self) -> dict[str, float]:
        """What follows."""
        m = Stepper(self.holding_torque, self.rotor_teeth, self.inertia)
        found: dict[str, float] = {"natural_frequency_Hz": m.natural_frequency}
        if self.load < self.holding_torque:
            found["deflection_full_steps"] = m.deflection(self.load)
        return found | {
            "torque_of_one_sixteenth_step": m.microstep_torque(MICROSTEPS),
            "lost_steps_multiple_of": m.lost_steps_multiple_of,
        }

    def findings(self) -> Iterator[Finding]:
        """What contradicts what."""
        due = 4 * self.rotor_teeth
        if self.steps_per_turn is not None and self.steps_per_turn != due:
            text = f"{self.steps_per_turn} steps per turn beside {due}, four for each of {self.rotor_teeth} teeth"
            yield Finding("steps_per_turn against rotor_teeth", CONTRADICTION, text, self.steps_per_turn, due)
        if self.load >= self.holding_torque:
            text = f"the load is {self.load:g} N m, the motor holds {self.holding_torque:g} N m: it does not stand"
            yield Finding("load above the holding torque", CONTRADICTION, text, self.load, self.holding_torque)


@dataclass(frozen=True, slots=True, kw_only=True)
class InductionSheet:
    """An induction motor by Kloss."""

    breakdown_torque: float = parameter(meaning="the greatest", unit="N m", above=0.0)
    breakdown_slip: float = parameter(meaning="where it is", above=0.0, most=10.0)
    synchronous_rpm: float = parameter(meaning="speed of the field, at the shaft", unit="rpm", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    def derived(self) -> dict[str, float]:
        """What follows."""
        m = InductionMotor(self.breakdown_torque, self.breakdown_slip, self.synchronous_rpm * RPM)
        return {
            "starting_torque": m.starting_torque,
            "torque_at_3_percent_slip": m.torque_at_slip(SLIP),
            "breakdown_speed_rpm": (1.0 - self.breakdown_slip) * self.synchronous_rpm,
        }

    def findings(self) -> Iterator[Finding]:
        """Nothing is printed twice."""
        yield from ()


KINDS: Mapping[str, tuple[str, type[Any]]] = MappingProxyType(
    {
        "pole_pairs": ("synchronous motor", SynchronousSheet),
        "holding_torque": ("stepping motor", StepperSheet),
        "breakdown_torque": ("induction motor", InductionSheet),
    }
)
"""Key that tells a kind of motor: what it is called, and its sheet."""


def other_motor(table: Any) -> str | None:
    """Key by which a table `[motor]` is that of no DC motor; None where it is one."""
    return next((key for key in KINDS if isinstance(table, dict) and key in table), None)


def check_other_motor(path: Path) -> Answer:
    """Check the sheet of a motor that is no DC motor.

    Returns
    -------
    Derived values and findings; status 2 where numbers contradict each other.

    Raises
    ------
    ModelError
        A key that is unknown, missing or wrong.
    """
    text = read_text(path, "drive", ModelError)
    file = TuningFile(path, text, parse_toml(path, text, ModelError, "pole_pairs = 8"))
    file.only(("motor",))
    kind, record = KINDS[other_motor(file.table("motor")) or ""]
    values = file.values("motor", {field.name: field for field in parameters_of(record)}, TEXTS)
    try:
        sheet: Any = read_record(record, values, kind)
    except InputError as problem:
        raise ModelError(f"{file.place('motor')}: {problem}") from None
    title, derived, found = str(file.table("motor").get("name", path.stem)), sheet.derived(), list(sheet.findings())
    told = [{key: value for key, value in asdict(finding).items() if key != "level"} for finding in found]
    data = {
        "file": str(path), "kind": kind, "motor": title, **derived, "contradictions": told, "warnings": [], "notes": [],
    }  # fmt: skip
    lines = [
        f"{path}: {title}, {kind}: {'no contradiction' if not found else f'contradictions: {len(found)}'}",
        *(f"  {key:34} {value:12.6g}" for key, value in derived.items()),
        *(f"contradiction: {finding.name}: {finding.text}" for finding in found),
    ]
    return Answer("\n".join(lines), data, 2 if found else 0)

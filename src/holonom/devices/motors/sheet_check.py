"""Does a data sheet agree with itself? Derived values, and what contradicts what, with numbers (spec 03.1).

The identities of the steady permanent-magnet motor: `IA = U/R`, `MH = kM (IA - I0)`, `n0 = (U - R I0)/kM`,
`gradient = R/kM^2`, `tau_m = R J/kM^2`, `kn kM = 30/pi`, `MN = kM (IN - I0)`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass

from holonom.devices.motors.catalogue import MOTORS, MotorCard
from holonom.devices.motors.data_sheet import RPM, MotorSheet
from holonom.errors import OutOfLimits

__all__ = ["CONTRADICTION", "NOTE", "WARNING", "Finding", "SheetCheck", "check_sheet"]

NOTE, WARNING, CONTRADICTION = "note", "warning", "contradiction"
"""Levels of a finding."""
AGREES = 0.05
"""Part by which rounding, tolerances and friction may move a printed number from its identity."""
CONTRADICTS = 1.5
"""Factor from which no such reason is left."""
SLOW = 0.1
"""Mechanical time constant, s, above which a bare rotor is unusual."""
CONVENTIONS = (
    (math.sqrt(3.0), "the square root of 3: phase and phase-to-phase values"),
    (math.sqrt(2.0), "the square root of 2: peak and rms values"),
    (math.sqrt(1.5), "the square root of 3/2: peak of a phase and rms of all"),
    (1.5, "3/2: phase and terminal values"),
    (2.0, "2: phase and terminal values"),
    (3.0, "3: three phases and one"),
)
SLIPS = (
    (30.0 / math.pi, "30/pi: rpm and rad/s"),
    (1e3, "1,000: milli"),
    (1e3 * RPM, "1,000 pi/30: V/krpm and V s/rad"),
    (10.0, "10: a unit such as g cm2 (1e-7 kg m2)"),
    (100.0, "100: cm2 and m2"),
    (1e4, "10,000: cm2 and m2"),
)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to know of a sheet.

    Attributes
    ----------
    name
        What stands against what: "inertia against tau_m (factor 10)".
    level
        "note", "warning", or "contradiction": no motor has both numbers.
    text
        The numbers, and what they suggest.
    printed, expected
        The number of the sheet and that of the others, in the sheet's unit.
    """

    name: str
    level: str
    text: str
    printed: float
    expected: float


@dataclass(frozen=True, slots=True)
class SheetCheck:
    """Derived values (SI unless the key says its unit) and findings, the gravest first."""

    derived: dict[str, float]
    findings: tuple[Finding, ...]

    @property
    def contradictions(self) -> tuple[Finding, ...]:
        """Findings that no motor can have."""
        return tuple(finding for finding in self.findings if finding.level == CONTRADICTION)


def check_sheet(sheet: MotorSheet) -> SheetCheck:
    """Check what a sheet prints against the identities of the motor.

    Returns
    -------
    Values that follow from the sheet, as far as its numbers go, and findings.
    """
    derived = _derived(sheet)
    found = [*_orders(sheet), *_identities(sheet, derived), *_inertia(sheet, derived), *_limits(sheet, derived)]
    grave = {CONTRADICTION: 0, WARNING: 1, NOTE: 2}
    return SheetCheck(derived, tuple(sorted(found, key=lambda finding: grave[finding.level])))


def _derived(s: MotorSheet) -> dict[str, float]:
    found: dict[str, float] = {}
    k, current = s.torque_constant, s.I0 or 0.0
    back = s.kM if s.kM is not None else s.back_emf_constant
    if s.U is not None and back is not None:
        found["no_load_speed_rpm"] = (s.U - (s.R or 0.0) * current) / back / RPM
    if s.U is not None and s.R is not None:
        found["stall_current"] = s.U / s.R
        if k is not None:
            found["stall_torque"] = k * (found["stall_current"] - current)
            found["largest_efficiency"] = (1.0 - math.sqrt(min(current / found["stall_current"], 1.0))) ** 2
    if s.R is not None and k is not None and back is not None:
        found["speed_gradient_rpm_per_Nm"] = s.R / (k * back) / RPM
        if s.J is not None:
            found["mechanical_time_constant"] = s.R * s.J / (k * back)
    if s.R is not None and s.L is not None:
        found["electrical_time_constant"] = s.L / s.R
        if "mechanical_time_constant" in found:
            ratio = found["mechanical_time_constant"] / found["electrical_time_constant"]
            found["damping"] = 0.5 * math.sqrt(ratio)
    if s.IN is not None and k is not None:
        found["nominal_torque"] = k * (s.IN - current)
        if s.U is not None and s.R is not None and back is not None:
            found["nominal_speed_rpm"] = (s.U - s.R * s.IN) / back / RPM
    return found | _servo(s) | _thermal(s)


def _servo(s: MotorSheet) -> dict[str, float]:
    """What a servo motor's sheet says: K_e in V/krpm beside K_t; percent to a tenth."""
    found: dict[str, float] = {}
    if s.Ke_V_per_krpm is not None:
        found["Ke_SI"] = 1e-3 * s.Ke_V_per_krpm / RPM
    k = s.Kt if s.Kt is not None else s.kM
    if k is not None and s.stall_current is not None:
        found["stall_torque_from_Kt"] = k * s.stall_current
    if k is not None and "Ke_SI" in found:
        found["Kt_agrees_with_Ke_percent"] = round(100.0 * abs(k / found["Ke_SI"] - 1.0), 1)
    return found


def _thermal(s: MotorSheet) -> dict[str, float]:
    if None in (s.R, s.Rth1, s.Rth2, s.tw, s.ts):
        return {}
    model = s.thermal()
    limit = f"{model.limit:g}C"
    found = {f"largest_continuous_current_for_{limit}": model.largest_current()}
    if s.IN is not None:
        with suppress(OutOfLimits):  # copper that heats for ever has no settled temperature
            settled = model.settled(s.IN)
            found |= {"winding_at_IN": settled.winding, "housing_at_IN": settled.housing}
        reached = model.time_to(2.0 * s.IN)
        if math.isfinite(reached):
            found[f"time_to_{limit}_at_2IN"] = reached
    return found


def _orders(s: MotorSheet) -> Iterator[Finding]:
    """Numbers whose order no motor can reverse."""
    pairs = (("n0", "nN", "rpm"), ("MH", "MN", "N m"), ("IA", "IN", "A"), ("IN", "I0", "A"), ("n_max", "n0", "rpm"))
    for larger, smaller, unit in pairs:
        high, low = getattr(s, larger), getattr(s, smaller)
        if high is None or low is None or high >= low:
            continue
        text = f"{larger} is {high:g} {unit}, {smaller} {low:g} {unit}; {larger} must be the larger one"
        if larger == "n0" and s.kn is not None and s.U is not None:
            text += f"; kn U is {s.kn * s.U:.5g} rpm: "
            text += "they are exchanged" if abs(s.kn * s.U / low - 1.0) < AGREES else "look at both"
        elif larger == "n0":
            text += ": they may be exchanged"
        yield Finding(f"{larger} below {smaller}", WARNING if larger == "n_max" else CONTRADICTION, text, high, low)


def _identities(s: MotorSheet, d: dict[str, float]) -> Iterator[Finding]:
    """Each printed number beside that of its identity."""
    swapped = s.n0 is not None and s.nN is not None and s.n0 < s.nN
    gradient = d.get("speed_gradient_rpm_per_Nm")
    rows = (
        ("n0", None if swapped else s.n0, d.get("no_load_speed_rpm"), "n0 = (U - R I0)/kM", "rpm"),
        ("IA", s.IA, d.get("stall_current"), "IA = U/R", "A"),
        ("MH", s.MH, d.get("stall_torque"), "MH = kM (IA - I0)", "N m"),
        ("MN", s.MN, d.get("nominal_torque"), "MN = kM (IN - I0)", "N m"),
        ("nN", None if swapped else s.nN, d.get("nominal_speed_rpm"), "nN = (U - R IN)/kM", "rpm"),
        ("gradient", s.gradient_rpm_per_mNm, None if gradient is None else 1e-3 * gradient, "R/kM^2", "rpm/mNm"),
        ("eta_max", s.eta_max, d.get("largest_efficiency") if s.I0 else None, "(1 - sqrt(I0/IA))^2", ""),
        ("kn against kM", s.kn, None if s.kM is None else 1.0 / (s.kM * RPM), "kn kM = 30/pi", "rpm/V"),
        ("Kt against kM", s.Kt, s.kM, "both are the torque per current", "N m/A"),
        ("stall_torque", s.stall_torque, d.get("stall_torque_from_Kt"), "Kt times stall_current", "N m"),
        ("Ke against Kt", d.get("Ke_SI"), s.Kt if s.Kt is not None else s.kM, "K_e = K_t in SI", "V s/rad"),
    )
    for name, printed, expected, law, unit in rows:
        if printed is not None and expected is not None and expected > 0.0:
            yield from _compared(name, printed, expected, law, unit)


def _inertia(s: MotorSheet, d: dict[str, float]) -> Iterator[Finding]:
    """The inertia beside the mechanical time constant: of the sheet, of a motor with the same winding, or of any."""
    time = d.get("mechanical_time_constant")
    if time is None or s.J is None:
        return
    if s.tau_m is not None:
        yield from _compared("inertia against tau_m", time, s.tau_m, "tau_m = R J/kM^2", "s")
        return
    twin = _twin(s)
    if twin is not None and twin.sheet.J is not None:
        same = s.R or 0.0, twin.sheet.R or 1.0
        known = time * twin.sheet.J / s.J
        law = f"tau_m of {twin.title}, which has the same winding ({same[0]:g} and {same[1]:g} ohm)"
        yield from _compared("inertia against tau_m", time, known, law, "s")
    elif time > SLOW:
        text = (
            f"R J/kM^2 is {time:.4g} s; bare rotors have a few milliseconds: an inertia of g cm2 read as "
            "1e-6 kg m2 is 10 times too large; the sheet's tau_m would tell"
        )
        yield Finding("inertia against tau_m (none printed)", WARNING, text, time, SLOW)


def _twin(s: MotorSheet) -> MotorCard | None:
    """A motor of `MOTORS` with the same R and torque constant, and L where it is printed, if there is one."""
    k = s.torque_constant
    if s.R is None or k is None:
        return None
    for name in MOTORS.own:
        card: MotorCard = MOTORS.make(name)
        pairs = ((s.R, card.sheet.R), (k, card.sheet.torque_constant), (s.L, card.sheet.L))
        known = [(mine, theirs) for mine, theirs in pairs if mine is not None and theirs is not None]
        if len(known) >= 2 and all(abs(mine / theirs - 1.0) < 0.01 for mine, theirs in known):
            return card
    return None


def _compared(name: str, printed: float, expected: float, law: str, unit: str) -> Iterator[Finding]:
    ratio = printed / expected
    factor = max(ratio, 1.0 / ratio)
    if factor <= 1.0 + AGREES:
        return
    named = _named(factor, CONVENTIONS)
    level = CONTRADICTION if factor > CONTRADICTS * (1.0 - AGREES) and named is None else WARNING
    slip = named or _named(factor, SLIPS)
    text = f"{printed:.5g} {unit} beside {expected:.5g} {unit} by {law}, factor {factor:.3g}".replace("  ", " ")
    if slip is not None:
        text += f"; that is {slip}"
    if name in ("MH", "MN") and ratio < 1.0:
        text += "; less than the law's: iron that saturates, or a rating that counts more losses"
        level = WARNING if ratio > 0.4 else level
    title = f"{name} (factor {factor:.2g})" if factor >= 1.95 else name
    yield Finding(title, level, text, printed, expected)


def _named(factor: float, table: tuple[tuple[float, str], ...]) -> str | None:
    return next((text for value, text in table if abs(factor / value - 1.0) < 0.04), None)


def _limits(s: MotorSheet, d: dict[str, float]) -> Iterator[Finding]:
    """Limits of the current, each its own: nominal, thermal, demagnetising."""
    thermal = next((value for key, value in d.items() if key.startswith("largest_continuous_current")), None)
    if thermal is not None and s.IN is not None and abs(s.IN / thermal - 1.0) > 0.01:
        text = (
            f"IN is {s.IN:.4g} A, the two-body model allows {thermal:.4g} A for ever; a rating may count no-load "
            "losses and other limits, the model counts copper only: both are shown, neither is fitted"
        )
        yield Finding("IN is not the thermal limit", NOTE if thermal > s.IN else WARNING, text, s.IN, thermal)
    stall = s.IA if s.IA is not None else d.get("stall_current")
    if s.I_demag is not None and stall is not None and stall > s.I_demag:
        text = (
            f"U drives {stall:.4g} A at standstill, {s.I_demag:.4g} A weaken the magnets for ever; limit the current "
            "of the power stage below that"
        )
        yield Finding("stall current above the demagnetising current", WARNING, text, stall, s.I_demag)
    if s.I_demag is not None and s.IN is not None and s.I_demag < s.IN:
        text = f"I_demag is {s.I_demag:.4g} A, IN {s.IN:.4g} A; a motor bears its nominal current"
        yield Finding("I_demag below IN", CONTRADICTION, text, s.I_demag, s.IN)

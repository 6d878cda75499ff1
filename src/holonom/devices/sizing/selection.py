"""Which motor and gear make a load cycle, what of each is used, and why others do not.

At the motor, with the ratio nu and efficiency eta:

    m = J_m nu a + tau / (nu eta)   (tau eta / nu while the load drives),      i = m / k_t + I_0 sign w,
    u = R i + k_e w.

Speed, torque and current are judged by their peaks, heat by the rms of the current. Of each motor the gear counts that
uses the limits least; motors that do come in the order of their motor constant `k^2/R`, the smallest first.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from holonom.devices.motors.catalogue import MotorCard
from holonom.devices.motors.data_sheet import RPM
from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.sizing.cycle import LoadCycle, best_ratio
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["Choice", "GearChoice", "Rejection", "SizingLimits", "select_drive"]


@dataclass(frozen=True, slots=True)
class GearChoice:
    """A gear that may be taken.

    Raises
    ------
    ModelError
    """

    ratio: float = parameter(meaning="motor turns per joint turn", above=0.0, example=50.0)
    efficiency: float = parameter(1.0, meaning="both ways", above=0.0, most=1.0)
    inertia: float = parameter(0.0, meaning="at the motor's shaft", unit="kg m2", least=0.0)
    max_torque: float = parameter(math.inf, meaning="at its output, now and then", unit="N m", above=0.0, most=math.inf)
    name: str = parameter("", meaning="what it is called")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class SizingLimits:
    """What a choice has to keep to, beside the sheet of its motor.

    Raises
    ------
    ModelError
    """

    voltage: float | None = parameter(None, meaning="of the supply; each motor's own unless given", unit="V", above=0.0)
    current: float = parameter(math.inf, meaning="of the power stage", unit="A", above=0.0, most=math.inf)
    inertia_ratio: float = parameter(10.0, meaning="load over rotor, at the motor", above=0.0, most=math.inf)
    ambient: float = parameter(25.0, meaning="temperature of the air", unit="degC", least=-60.0, most=120.0)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class Rejection:
    """Why a choice does not do: "torque", "speed", "thermal", "inertia ratio", "current", "gear", "unknown"."""

    name: str
    text: str
    value: float
    limit: float


@dataclass(frozen=True, slots=True)
class Choice:
    """A motor with a gear under a cycle; all values at the motor's shaft.

    Attributes
    ----------
    motor, gear
        Which.
    peak_torque, rms_torque
        N m.
    peak_current, rms_current
        A.
    peak_speed
        rad/s.
    peak_voltage
        V.
    inertia_ratio
        Of the load over the rotor's; 0 where the load's is not known.
    best_ratio
        With the greatest acceleration for a torque; 0 where the load's inertia is not known.
    thermal_limit, nominal_current
        A rms: what the two-body model allows for ever, and what the sheet prints; 0 where it tells neither. The lower
        one is kept to, neither is fitted to the other.
    winding_temperature
        Settled, degC; 0 where the sheet does not tell, infinite where it never settles.
    used
        Largest part of a limit that is known, which is used.
    rejections
        Empty where the choice does.
    """

    motor: MotorCard
    gear: GearChoice
    peak_torque: float
    rms_torque: float
    peak_current: float
    rms_current: float
    peak_speed: float
    peak_voltage: float
    inertia_ratio: float
    best_ratio: float
    thermal_limit: float
    nominal_current: float
    winding_temperature: float
    used: float
    rejections: tuple[Rejection, ...] = field(default=())


def select_drive(
    cycle: LoadCycle, motors: Iterable[MotorCard], gears: Sequence[GearChoice], limits: SizingLimits = SizingLimits()
) -> tuple[tuple[Choice, ...], tuple[Choice, ...]]:
    """Rank motors and gears for a load cycle.

    Parameters
    ----------
    cycle : of the joint.
    motors : that may be taken.
    gears : that may be taken, each with any motor.
    limits : that all keep to.

    Returns
    -------
    Choices that do, one for each motor, the smallest motor first; and of each other motor the one that comes nearest,
    with its rejections.

    Raises
    ------
    ModelError
        No gear; a sheet that tells too little to make a motor.
    """
    if not gears:
        raise ModelError("select_drive: no gear came; one at least is needed, of ratio 1 where there is none")
    fitting: list[Choice] = []
    others: list[Choice] = []
    for card in motors:
        choices = [_judged(cycle, card, gear, limits) for gear in gears]
        nearest = min(choices, key=lambda choice: (len(choice.rejections) > 0, choice.used, choice.gear.ratio))
        (others if nearest.rejections else fitting).append(nearest)
    return tuple(sorted(fitting, key=_size)), tuple(sorted(others, key=lambda choice: choice.used))


def _size(choice: Choice) -> float:
    sheet = choice.motor.sheet
    assert sheet.R is not None and sheet.torque_constant is not None  # noqa: PT018
    return sheet.torque_constant**2 / sheet.R


def _judged(cycle: LoadCycle, card: MotorCard, gear: GearChoice, limits: SizingLimits) -> Choice:
    motor = card.sheet.motor(max_voltage=limits.voltage)
    ratio, rotor = gear.ratio, motor.rotor_inertia + gear.inertia
    middle = 0.5 * (cycle.start + cycle.end)
    power = cycle.torque * middle
    share = np.where(power > 0.0, 1.0 / gear.efficiency, np.where(power < 0.0, gear.efficiency, 1.0))
    torque = rotor * ratio * cycle.acceleration + cycle.torque * share / ratio
    current = torque / motor.torque_constant + motor.no_load_current * np.sign(middle)
    ends = (cycle.start, cycle.end)
    voltage = max(
        float(np.abs(motor.resistance * current + motor.back_emf_constant * ratio * end).max()) for end in ends
    )
    rms = cycle.rms(current)
    thermal, nominal, winding = _heat(card, rms, limits)
    peaks = {
        "torque": float(np.abs(torque).max()),
        "current": float(np.abs(current).max()),
        "speed": ratio * cycle.peak_speed,
        "voltage": voltage,
        "inertia": cycle.inertia / (ratio**2 * rotor),
    }
    uses = _uses(cycle, card, gear, motor, limits, peaks, rms, min(filter(None, (thermal, nominal)), default=0.0))
    return Choice(
        card,
        gear,
        peaks["torque"],
        cycle.rms(torque),
        peaks["current"],
        rms,
        peaks["speed"],
        voltage,
        peaks["inertia"],
        best_ratio(rotor, cycle.inertia) if cycle.inertia > 0.0 else 0.0,
        thermal,
        nominal,
        winding,
        max(use.value / use.limit for use in uses if use.limit > 0.0),
        tuple(use for use in uses if use.value > use.limit),
    )


def _heat(card: MotorCard, rms: float, limits: SizingLimits) -> tuple[float, float, float]:
    """Currents that the model and the sheet allow for ever (A), 0 where unknown, and the winding's temperature."""
    sheet = card.sheet
    nominal = sheet.IN or 0.0
    if None in (sheet.Rth1, sheet.Rth2, sheet.tw, sheet.ts):
        return 0.0, nominal, 0.0
    model = sheet.thermal(ambient=limits.ambient)
    hottest = model.hottest(rms, 1.0, 1.0)
    return model.largest_current(), nominal, hottest


def _uses(
    cycle: LoadCycle,
    card: MotorCard,
    gear: GearChoice,
    motor: DcMotor,
    limits: SizingLimits,
    peaks: dict[str, float],
    rms: float,
    heat: float,
) -> list[Rejection]:
    """Every limit with what of it is used, as a rejection would say it."""
    sheet = card.sheet
    stall = motor.max_voltage / motor.resistance
    most = min(limits.current, sheet.I_demag or math.inf, stall)
    whose = "the power stage" if most == limits.current else "the magnets" if most == sheet.I_demag else "the supply"
    fastest = motor.no_load_speed if sheet.n_max is None else min(motor.no_load_speed, sheet.n_max * RPM)
    constant, voltage, speed, current = motor.torque_constant, peaks["voltage"], peaks["speed"], peaks["current"]
    found = [
        Rejection("torque", f"{peaks['torque']:.4g} N m at the shaft; stall torque is {motor.stall_torque:.4g} N m",
                  peaks["torque"], constant * stall),
        Rejection("speed", f"{speed:.4g} rad/s at the shaft; {fastest:.4g} rad/s without load", speed, fastest),
        Rejection("voltage", f"torque and speed together need {voltage:.4g} V; the supply has {motor.max_voltage:g} V",
                  voltage, motor.max_voltage),
        Rejection("current", f"peaks of {current:.4g} A; {whose} allows {most:.4g} A", current, most),
    ]  # fmt: skip
    if heat > 0.0:
        found.append(Rejection("thermal", f"{rms:.4g} A rms; {heat:.4g} A for ever", rms, heat))
    else:
        found.append(
            Rejection("unknown", "the sheet prints neither IN nor thermal data: its rms limit is not known", rms, 0.0)
        )
    if cycle.inertia > 0.0:
        text = f"the load's inertia is {peaks['inertia']:.4g} times the rotor's; {limits.inertia_ratio:g} are allowed"
        found.append(Rejection("inertia ratio", text, peaks["inertia"], limits.inertia_ratio))
    if math.isfinite(gear.max_torque):
        text = f"{cycle.peak_torque:.4g} N m at its output; {gear.max_torque:.4g} N m are allowed"
        found.append(Rejection("gear", text, cycle.peak_torque, gear.max_torque))
    return found

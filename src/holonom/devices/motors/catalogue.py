"""`MOTORS`: real motors, each with its sheet, the source of it and what is assumed (spec 03.1).

Sheets differ between editions of a catalogue: the one of your order decides. Where an identity does not hold on what a
catalogue prints (saturation, a rating with other losses), the number is left out here, not mended.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial

from holonom.devices.motors.data_sheet import MotorSheet
from holonom.errors import InputError, UnknownName
from holonom.registry import Method, NoParams, Table

__all__ = ["MOTORS", "MotorCard", "motor_card"]


@dataclass(frozen=True, slots=True)
class MotorCard:
    """A motor that can be bought.

    Attributes
    ----------
    name
        Of its line in `MOTORS`.
    title
        As its maker calls it, with order number and voltage.
    sheet
        What its maker prints.
    source
        Where the numbers are from.
    assumed
        Keys of the sheet that its source does not state or that were not compared with it; empty where there is none.
    """

    name: str
    title: str
    sheet: MotorSheet
    source: str
    assumed: str = ""


_MAXON = "maxon motor, catalogue, values at nominal voltage"
_FAULHABER = "Faulhaber, data sheet of the series"
_REMEMBERED = "all numbers: written down without the sheet at hand, checked by the identities alone; compare yours"

_CARDS = (
    MotorCard(
        "maxon_re40_48v",
        "maxon RE 40 148877 48 V",
        MotorSheet(
            U=48.0, n0=7590.0, I0=0.0686, nN=7000.0, MN=0.187, IN=3.17, MH=2.56, IA=42.4, eta_max=0.92, R=1.13,
            L=0.33e-3, kM=60.3e-3, kn=158.0, gradient_rpm_per_mNm=2.97, tau_m=4.28e-3, J=137e-7, Rth1=4.65, Rth2=1.93,
            tw=41.5, ts=809.0,
        ),
        _MAXON,
    ),
    MotorCard(
        "maxon_re40_24v",
        "maxon RE 40 148867 24 V",
        MotorSheet(
            U=24.0, n0=7580.0, I0=0.137, MN=0.177, IN=6.0, MH=2.42, IA=80.2, R=0.299, L=82.3e-6, kM=30.2e-3, kn=317.0,
            gradient_rpm_per_mNm=3.14, tau_m=4.67e-3, J=142e-7,
        ),
        _MAXON,
        _REMEMBERED,
    ),
    MotorCard(
        "maxon_re25_24v",
        "maxon RE 25 118752 24 V",
        MotorSheet(U=24.0, R=2.32, L=0.24e-3, kM=23.4e-3, kn=407.0, J=10.8e-7),
        "parameter file of a public MATLAB project",
        "J 10.8 g cm2: remembered of the series' catalogue, not in that file",
    ),
    MotorCard(
        "maxon_re30_24v",
        "maxon RE 30 310007 24 V",
        MotorSheet(
            U=24.0, n0=8810.0, I0=0.164, MN=85.6e-3, IN=3.44, MH=1.02, IA=39.3, R=0.611, L=0.119e-3, kM=25.9e-3,
            kn=369.0, gradient_rpm_per_mNm=8.69, tau_m=3.05e-3, J=33.5e-7,
        ),
        _MAXON,
        _REMEMBERED,
    ),
    MotorCard(
        "maxon_re50_24v",
        "maxon RE 50 370354 24 V",
        MotorSheet(
            U=24.0, n0=5950.0, I0=0.236, nN=5680.0, MN=0.405, IN=10.8, MH=8.92, IA=232.0, R=0.103, L=0.0717e-3,
            kM=38.5e-3, kn=248.0, gradient_rpm_per_mNm=0.668, tau_m=3.75e-3, J=536e-7,
        ),
        _MAXON,
        _REMEMBERED,
    ),
    MotorCard(
        "maxon_amax32",
        "maxon A-max 32",
        MotorSheet(U=24.0, R=3.99, L=0.556e-3, kM=35.216e-3, J=45.3e-7),
        "parameters of a public project; its inertia of 45.3e-6 kg m2 is 45.3 g cm2 with a slipped unit",
        "U 24 V: the winding's usual supply",
    ),
    MotorCard(
        "maxon_dcx22l_9v",
        "maxon DCX 22 L 9 V",
        MotorSheet(
            U=9.0, n0=12300.0, nN=11400.0, MH=0.371, IA=53.4, R=0.168, L=18e-6, kM=6.95e-3, kn=1370.0, J=9.37e-7
        ),
        "specification file of a public course project; it has n0 and nN exchanged",
    ),
    MotorCard(
        "maxon_ec45flat_18v",
        "maxon EC 45 flat 339285 50 W 18 V",
        MotorSheet(U=18.0, R=0.464, L=0.322e-3, kM=25.1e-3, kn=380.0, tau_m=9.92e-3, J=135e-7),
        "constants of a public MATLAB project; terminal values",
        "U 18 V: remembered of the series' catalogue",
    ),
    MotorCard(
        "maxon_ec45flat_24v",
        "maxon EC 45 flat 251601 50 W 24 V",
        MotorSheet(
            U=24.0, n0=6710.0, I0=0.185, IN=2.33, R=0.608, L=0.463e-3, kM=33.5e-3, kn=285.0, gradient_rpm_per_mNm=5.17,
            tau_m=7.3e-3, J=135e-7,
        ),
        f"{_MAXON}; terminal values; its nominal and stall torques are not kM times the currents: left out",
        _REMEMBERED,
    ),
    MotorCard(
        "maxon_ec90flat_24v",
        "maxon EC 90 flat 323772 90 W 24 V",
        MotorSheet(
            U=24.0, n0=3190.0, I0=0.538, IN=6.06, MH=4.94, IA=70.0, R=0.343, L=0.264e-3, kM=70.5e-3, kn=135.0,
            gradient_rpm_per_mNm=0.659, tau_m=21.1e-3, J=3060e-7,
        ),
        f"{_MAXON}; terminal values; its nominal torque and speed are not those of IN by kM and R: left out",
        _REMEMBERED,
    ),
    MotorCard(
        "faulhaber_2224_6v",
        "Faulhaber 2224 006SR 6 V",
        MotorSheet(
            U=6.0, n0=8200.0, I0=0.029, MH=21.2e-3, R=1.94, L=45e-6, kM=6.92e-3, kn=1380.0, tau_m=11e-3, J=2.7e-7
        ),
        _FAULHABER,
        _REMEMBERED,
    ),
    MotorCard(
        "faulhaber_2224_12v",
        "Faulhaber 2224 012SR 12 V",
        MotorSheet(U=12.0, I0=0.014, R=8.71, L=450e-6, kM=14.4e-3, kn=664.0, tau_m=11e-3, J=2.7e-7),
        _FAULHABER,
        _REMEMBERED,
    ),
    MotorCard(
        "faulhaber_2342_12v",
        "Faulhaber 2342 012CR 12 V",
        MotorSheet(U=12.0, I0=0.075, R=1.9, L=65e-6, kM=13.4e-3, kn=713.0, tau_m=6e-3, J=5.8e-7),
        f"{_FAULHABER}; its no-load speed is 4 % below kn U",
        _REMEMBERED,
    ),
    MotorCard(
        "faulhaber_3257_24v",
        "Faulhaber 3257 024CR 24 V",
        MotorSheet(U=24.0, I0=0.129, R=1.63, L=270e-6, kM=37.7e-3, kn=253.0, tau_m=4.7e-3, J=41e-7),
        _FAULHABER,
        _REMEMBERED,
    ),
    MotorCard(
        "faulhaber_2338_6v",
        "Faulhaber 2338S006 6 V",
        MotorSheet(U=6.0, R=2.6, L=0.18e-3, kM=7.68e-3, J=3.9e-7),
        "Quanser, user manual of the rotary servo plant SRV02",
        _REMEMBERED,
    ),
    MotorCard(
        "allied_cl40_18v",
        "Allied Motion CL40 16705 18 V",
        MotorSheet(U=18.0, n0=4050.0, MN=22e-3, IN=0.54, R=8.4, L=1.16e-3, kM=0.042, J=4.0e-6),
        "Quanser, user manual of the QUBE-Servo 2",
        _REMEMBERED,
    ),
)  # fmt: skip


def _card(card: MotorCard, none: NoParams) -> MotorCard:
    """Return the card: it takes no parameters."""
    del none
    return card


MOTORS = Table(
    "motors",
    "motor",
    "its card: title, sheet, source, what is assumed",
    {card.name: Method(card.title, partial(_card, card), card.source) for card in _CARDS},
)


def motor_card(name: str) -> MotorCard:
    """Return the card of a motor by its name in `MOTORS`, or by words of its title that no other title has.

    Raises
    ------
    UnknownName
        No such motor; the message lists them.
    InputError
        More than one motor has these words.
    """
    if name in MOTORS:
        found: MotorCard = MOTORS.make(name)
        return found
    words = _words(name)
    fitting = [card for card in _CARDS if words and words <= _words(card.title)]
    if len(fitting) > 1:
        raise InputError(f"motor {name!r} may be {' or '.join(card.name for card in fitting)}; say which")
    if not fitting:
        raise UnknownName("motor", name, MOTORS)
    return fitting[0]


def _words(text: str) -> set[str]:
    found: Iterable[str] = re.findall(r"[a-z]+|\d+", text.lower())
    return set(found)

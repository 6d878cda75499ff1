"""A differential base on its floor: our plant beside MuJoCo with a like model, steps of half a millisecond both."""

from __future__ import annotations

import numpy as np
from peers import mujoco_base, peer

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.devices import DcMotor, Encoder, Gear
from holonom.mobile import BaseDrive, Wheel, WheelBase
from holonom.sim import BasePlant

BASE = WheelBase(
    [
        Wheel.at("fixed", 0.0, 0.15, radius=0.05, driven=True, name="left"),
        Wheel.at("fixed", 0.0, -0.15, radius=0.05, driven=True, name="right"),
        Wheel.at("spherical", -0.2, 0.0, radius=0.02, name="ball"),
    ],
    mass=8.0, com=(-0.05, 0.0), com_height=0.06, inertia=0.16,
)  # fmt: skip
DRIVE = BaseDrive(
    DcMotor(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 9.25e-6, 14.8, 20.0), Gear(12.0), Encoder(4096), wheel_inertia=1e-4
)
SUBSTEPS = 2
STEP = 1e-3 / SUBSTEPS


def measure(setting: Setting) -> list[Figure]:
    ticks = 100 if setting.small else 2000
    plant, volts = BasePlant(BASE, DRIVE, substeps=SUBSTEPS), np.tile([5.0, 3.0], (ticks, 1))
    ours = seconds(lambda: plant.drive_open(volts), setting, rounds=7) / ticks
    theirs, mujoco = None, peer("mujoco")
    if mujoco is not None:
        model = mujoco.MjModel.from_xml_string(mujoco_base(BASE, DRIVE, plant.floor.material.peak, STEP))
        data = mujoco.MjData(model)
        data.ctrl[:] = volts[0]
        theirs = seconds(lambda: mujoco.mj_step(model, data, SUBSTEPS * ticks), setting, rounds=7) / ticks
    return [
        Figure(
            f"differential base, its plant alone, {SUBSTEPS} steps per ms",
            1e-3 / ours,
            "x real time",
            "" if theirs is None else "MuJoCo mj_step",
            None if theirs is None else 1e-3 / theirs,
            more_is_better=True,
        )
    ]

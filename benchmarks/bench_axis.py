"""One axis at 10 kHz with its three loops, beside a MuJoCo step of a hinge that a like DC motor turns."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from peers import peer

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.control import design_cascade
from holonom.devices import DcMotor, Encoder, Friction
from holonom.machine.axis.drive import DriveSettings
from holonom.sim import Axis, Load, simulate_axis

RE40 = DcMotor(1.13, 0.33e-3, 0.0603, 0.0603, 1.37e-5, 48.0, 10.0, 0.0686)
AXIS = Axis(RE40, Load(3e-5, coulomb=0.002), Encoder(2000), friction=Friction(0.0, 0.004, 0.004))
STEP = 1e-4
FRICTION = 0.006  # N m, of rotor and load
HINGE = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody><body>
    <joint name="axis" type="hinge" axis="0 0 1" armature="{armature}" frictionloss="{friction}"/>
    <inertial pos="0 0 0" mass="0.1" diaginertia="{load} {load} {load}"/>
  </body></worldbody>
  <actuator>
    {actuator}
  </actuator>
</mujoco>
"""
MOTORS = (
    # from MuJoCo 4 on; before, voltage through the lag L/R to torque, back-emf as damping
    '<dcmotor joint="axis" motorconst="{constant}" resistance="{resistance}" inductance="{inductance}"/>',
    '<general joint="axis" gainprm="{gain}" biastype="affine" biasprm="0 0 {damping}" dyntype="filter" '
    'dynprm="{lag}"/>',
)


def measure(setting: Setting) -> list[Figure]:
    """Steps of 1 rad to and fro each second: rigid and with backlash, watched and not; times of a step."""
    samples = 100 if setting.small else 100_000
    reference = np.where((np.arange(samples) // 1000) % 2 == 0, 1.0, 0.0)
    gains = design_cascade(AXIS.servo_axis())
    theirs = _mujoco(setting, samples)
    figures = []
    for name, gap, supervised in (
        ("motor, encoder, stick, three loops", 0.0, False),
        ("motor, encoder, backlash, stick, three loops", 0.01, False),
        ("motor, encoder, stick, three loops, supervised", 0.0, True),
        ("motor, encoder, backlash, stick, three loops, supervised", 0.01, True),
    ):
        axis, drive = dataclasses.replace(AXIS, gap=gap), DriveSettings(supervised=supervised)
        one = seconds(lambda: simulate_axis(axis, gains, reference, drive=drive), setting, rounds=9) / samples  # noqa: B023
        figures.append(Figure(f"axis at 10 kHz: {name}", 1e-3 / one, "x real time", goal=2000.0, more_is_better=True))
        if gap > 0.0 and theirs is not None:
            what = "axis at 10 kHz, a step of 0.1 ms" + (", supervised" if supervised else "")
            figures.append(Figure(what, 1e8 * one, "ns", "MuJoCo mj_step", 1e9 * theirs, 100.0))
    return figures


def _mujoco(setting: Setting, samples: int) -> float | None:
    """Time (s) of one step of MuJoCo, from a whole call that takes many; None where it is not installed."""
    mujoco = peer("mujoco")
    if mujoco is None:
        return None
    k, R, L = RE40.torque_constant, RE40.resistance, RE40.inductance
    motor = MOTORS[0 if int(mujoco.__version__.split(".")[0]) >= 4 else 1].format(
        constant=k, resistance=R, inductance=L, gain=k / R, damping=-k * k / R, lag=L / R
    )
    model = mujoco.MjModel.from_xml_string(
        HINGE.format(step=STEP, armature=RE40.rotor_inertia, friction=FRICTION, load=AXIS.load.inertia, actuator=motor)
    )
    data = mujoco.MjData(model)
    data.ctrl[0] = 5.0
    mujoco.mj_step(model, data, 5000)
    settled = (5.0 - FRICTION * R / k) / k
    assert math.isclose(data.qvel[0], settled, rel_tol=0.02), (data.qvel[0], settled)
    steps = samples // 10
    return seconds(lambda: mujoco.mj_step(model, data, steps), setting, rounds=9) / steps

"""A four-wheel omni base, motors to path keeping, against real time; its plant beside SciPy's solver."""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from holonom.app.about.bench import Figure, Setting, seconds
from holonom.closed_loop import BaseLoop, simulate_base
from holonom.devices import DcMotor, Encoder, Gear
from holonom.machine import PATHS, BaseController, PathLimits, plan_path
from holonom.mobile import BaseDrive, omni
from holonom.sim import CARPET, BasePlant

BASE = omni(
    angles=np.deg2rad([57.0, 135.0, 225.0, 303.0]), radius=0.0789, wheel_radius=0.02711, mass=6.35, com_height=0.0
)
DRIVE = BaseDrive(
    DcMotor(1.2, 0.56e-3, 25.5e-3, 25.5e-3, 9.25e-6, 14.8, 8.0), Gear(3.0), Encoder(4096), roller_drag=0.0
)
SUBSTEPS = 2


def measure(setting: Setting) -> list[Figure]:
    path = plan_path(PATHS.make("figure_of_eight", {"size": 5.0}), PathLimits(1.6, 2.0), laps=1 if setting.small else 4)
    closed = seconds(
        lambda: simulate_base(BASE, DRIVE, path, rng=np.random.default_rng(0), substeps=SUBSTEPS), setting, rounds=7
    )
    loop = BaseLoop(BaseController(BASE, DRIVE), BasePlant(BASE, DRIVE, rng=np.random.default_rng(0)))
    plant, volts = BasePlant(BASE, DRIVE, substeps=SUBSTEPS), _voltages(200 if setting.small else 2000)
    ours = seconds(lambda: plant.drive_open(volts), setting, rounds=7) / len(volts)
    peer = seconds(lambda: _solve(volts[:100]), setting, rounds=2) / 100
    per_second = 1e-3
    driven = seconds(lambda: _drive(loop, 20 if setting.small else 500), setting, rounds=7)
    return [
        Figure(
            "omni base driven by velocities at 100 Hz",
            0.01 * (20 if setting.small else 500) / driven,
            "x real time",
            goal=300.0,
            more_is_better=True,
        ),
        Figure(
            "omni base: motors, slip, sensors, loops, log",
            path.time[-1] / closed,
            "x real time",
            goal=500.0,
            more_is_better=True,
        ),
        Figure(
            f"its plant alone, {SUBSTEPS} steps per ms",
            per_second / ours,
            "x real time",
            "solve_ivp LSODA, rtol 1e-4",
            per_second / peer,
            goal=100.0,
            more_is_better=True,
        ),
    ]


def _drive(loop: BaseLoop, ticks: int) -> None:
    """A velocity each 10 ms, as a joystick or a planner gives them."""
    loop.place((0.0, 0.0, 0.0))
    for k in range(ticks):
        loop.controller.follow_velocity((0.5, 0.3 * (k % 2), 0.2))
        loop.advance(10)


def _voltages(n: int) -> np.ndarray:
    t = 1e-3 * np.arange(n)[:, None]
    return 3.0 * np.sin(2.0 * np.pi * t + np.arange(4))


def _solve(volts: np.ndarray) -> None:
    """The same equations (no gear losses, constant wheel loads) by a stiff solver of the shelf."""
    rows, motor, r, ratio = BASE.velocity_coupling * [1.0, 1.0, BASE.radius], DRIVE.motor, 0.02711, DRIVE.gear.ratio
    load, mass = 6.35 * 9.80665 / 4.0, np.array([6.35, 6.35, 0.5 * 6.35 * BASE.radius**2])
    B, C, D = CARPET.stiffness, CARPET.shape, CARPET.peak

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        u = volts[min(int(1e3 * t), len(volts) - 1)]
        v, wheels, current = y[3:6], y[6:10], y[10:]
        force = load * D * np.sin(C * np.arctan(B * (r * wheels - rows @ v)))
        a = rows.T @ force / mass + [v[2] * v[1], -v[2] * v[0], 0.0]
        c, s = np.cos(y[2]), np.sin(y[2])
        spin = (ratio * motor.torque_constant * current - r * force) / DRIVE.inertia
        change = (u - motor.resistance * current - motor.back_emf_constant * ratio * wheels) / motor.inductance
        return np.concatenate([[c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]], a, spin, change])

    solve_ivp(rate, (0.0, 1e-3 * len(volts)), np.zeros(14), method="LSODA", rtol=1e-4, atol=1e-6, max_step=1e-3)

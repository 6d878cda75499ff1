"""A base that balances as its controller knows it: the linear model of its body, its law, how it leans for a path."""

from __future__ import annotations

import math

import numpy as np

from holonom.arrays import Array
from holonom.control.balance.contract import BalanceLaw, Pendulum, TiltSettings
from holonom.machine.base.balance_kernels import BalanceParams
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import GRAVITY, BaseDrive, base_mass

__all__ = ["balance_params", "leaning_path", "pendulum_of"]

MOST = 1.0  # m, of the place that velocities leave behind


def pendulum_of(base: WheelBase, drive: BaseDrive, max_force: float) -> Pendulum:
    """The linear model of a base that balances, upright on rolling wheels; `max_force` (N) of all its rims.

    Raises
    ------
    ModelError
        A centre of mass that is not above the axle.
    """
    mass, r, N = base_mass(base), float(np.mean(base.wheel_radii)), drive.gear.ratio
    axle = float(np.mean([wheel.x for wheel in base.wheels]))
    ahead, rise = float(base.com[0]) - axle, base.com_height - r
    length = math.copysign(math.hypot(ahead, rise), rise)
    count, rotor = len(base.driven), drive.motor.rotor_inertia
    return Pendulum(
        rolling=mass + count * (drive.wheel_inertia + N * N * rotor) / r**2,
        coupling=mass * length - count * rotor * N * (N - 1.0) / r,
        pitching=float(base.inertia[1, 1]) + mass * length**2 + count * rotor * N * (N - 2.0),
        stiffness=mass * GRAVITY * length,
        radius=r,
        rest=-math.atan2(ahead, rise),
        max_force=max_force,
    )


def balance_params(base: WheelBase, drive: BaseDrive, law: BalanceLaw, max_force: float, dt: float) -> BalanceParams:
    """Params of a base that balances by a law.

    Raises
    ------
    ModelError
        A centre of mass that is not above the axle.
    """
    body = pendulum_of(base, drive, max_force)
    return BalanceParams(
        gains=law.gains(body), tilt=TiltSettings().params(dt, GRAVITY), radius=body.radius, rest=body.rest,
        lean=body.lean, time=body.time, mass=body.rolling, coupling=body.coupling, most=MOST,
    )  # fmt: skip


def leaning_path(body: Pendulum, acceleration: Array, dt: float) -> Array:
    """Pitch from rest, its rate and the force (N, 3) that accelerations (N,) along a path take, m/s^2 at steps dt.

    Notes
    -----
    With the force eliminated `t^2 phi'' = phi - k a`. Its one solution that does not run away looks ahead and back:
    `phi(t) = k/(2 t) int exp(-|u|/t) a(t + u) du` (stable inversion; Devasia, Chen & Paden, IEEE Trans. Automatic
    Control 41(7), 1996). A body that leans by it keeps up with a path that it could not follow by feedback.
    """
    from scipy.signal import lfilter  # heavy: on first use

    keep = math.exp(-dt / body.time)
    pad = math.ceil(8.0 * body.time / dt)
    a = np.pad(acceleration, pad)
    past = lfilter([1.0], [1.0, -keep], a)
    future = lfilter([1.0], [1.0, -keep], a[::-1])[::-1]
    pitch = body.lean * (1.0 - keep) / (1.0 + keep) * (past + future - a)
    second = (pitch - body.lean * a) / body.time**2
    force = body.rolling * a + body.coupling * second
    found: Array = np.ascontiguousarray(
        np.column_stack([pitch, np.gradient(pitch, dt), force])[pad : pad + len(acceleration)]
    )
    return found

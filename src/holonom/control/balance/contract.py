"""What laws of balance share: the linear model of the body, `BalanceLaw`, settings of the estimate of its pitch."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import inf

import numpy as np

from holonom.arrays import Array
from holonom.control.balance.kernels import BalanceGains, TiltParams
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["BalanceLaw", "Pendulum", "TiltSettings"]


@dataclass(frozen=True, slots=True)
class Pendulum:
    """A body on rolling wheels near its rest: `m v' + c phi'' = F`, `c v' + J phi'' = G phi - r F`.

    F is the sum of the rims' forces that the motors make (torque over radius), which turns the body back.

    Attributes
    ----------
    rolling, coupling, pitching
        m (kg) with wheels and rotors that roll along, c (kg m), J (kg m^2) about the axle.
    stiffness
        G, N m/rad: mass times gravity times the height of the centre of mass over the axle.
    radius
        r of the wheels, m.
    rest
        Pitch at which it stands, rad.
    max_force
        N, of all rims.

    Raises
    ------
    ModelError
        A centre of mass that is not above the axle, a body that nothing moves.
    """

    rolling: float
    coupling: float
    pitching: float
    stiffness: float
    radius: float
    rest: float
    max_force: float

    def __post_init__(self) -> None:
        if not self.stiffness > 0.0:
            raise ModelError(
                f"Pendulum: weight times height of the centre of mass over the axle is {self.stiffness:g} N m; a body "
                "that balances has it above its axle: state its height (com_height=)"
            )
        if not (self.rolling > 0.0 and self.inertia > 0.0 and self.max_force > 0.0):
            raise ModelError(f"Pendulum: masses {self.rolling:g} kg, {self.pitching:g} kg m2 are no body's")

    @property
    def inertia(self) -> float:
        """Determinant `m J - c^2`, kg^2 m^2."""
        return self.rolling * self.pitching - self.coupling**2

    @property
    def lever(self) -> float:
        """`c + r m`, kg m: pitch moment per acceleration of the wheels."""
        return self.coupling + self.radius * self.rolling

    @property
    def lean(self) -> float:
        """Pitch per steady acceleration, rad s^2/m."""
        return self.lever / self.stiffness

    @property
    def time(self) -> float:
        """Time constant (s) of its falling on wheels that run as they are told; 1/time is the zero of its speed."""
        return math.sqrt((self.pitching + self.radius * self.coupling) / self.stiffness)

    @property
    def matrices(self) -> tuple[Array, Array]:
        """A (4, 4), B (4, 1) of pitch, its rate, speed, place under the force F."""
        m, c, J, G, r, D = self.rolling, self.coupling, self.pitching, self.stiffness, self.radius, self.inertia
        A = np.zeros((4, 4))
        A[0, 1] = A[3, 2] = 1.0
        A[1, 0], A[2, 0] = m * G / D, -c * G / D
        B = np.array([[0.0], [-(m * r + c) / D], [(J + c * r) / D], [0.0]])
        return A, B


@dataclass(frozen=True, slots=True, kw_only=True)
class BalanceLaw(ABC):
    """A law with its settings: frozen dataclasses with fields made by `parameter`; what all of them have.

    Raises
    ------
    OutOfLimits
        A number outside its range.
    """

    max_lean: float = parameter(
        0.25, meaning="largest lean that errors of speed and place ask for", unit="rad", above=0.0, most=1.0
    )
    max_place: float = parameter(1.0, meaning="largest error of place that counts", unit="m", above=0.0)
    trim_time: float = parameter(
        30.0, meaning="in which slopes and payloads are learnt, in parts of its time", unit="", above=0.0, most=inf
    )

    def __post_init__(self) -> None:
        check_fields(self)

    @abstractmethod
    def gains(self, body: Pendulum) -> BalanceGains:
        """Gains of `balance_step` for a body."""


@dataclass(frozen=True, slots=True)
class TiltSettings:
    """Estimate of pitch from gyro, accelerometers and wheels; equations in `tilt_step`.

    Raises
    ------
    OutOfLimits
        A number that is not positive.
    """

    acceleration_noise: float = parameter(
        0.5, meaning="of what the accelerometers miss of a sample: shaking, slopes", unit="m/s2", above=0.0
    )
    rate_noise: float = parameter(5e-3, meaning="of a sample of the gyro", unit="rad/s", above=0.0)
    bias_walk: float = parameter(
        1e-3, meaning="of the gyro's zero in the square root of a second", unit="rad/s", above=0.0
    )
    speed_noise: float = parameter(0.03, meaning="of a sample of the wheels' speed", unit="m/s", above=0.0)

    def __post_init__(self) -> None:
        check_fields(self)

    def params(self, dt: float, gravity: float) -> TiltParams:
        """Params of `tilt_step` at a sample time (s), in gravity (m/s2)."""
        from scipy.linalg import solve_discrete_are  # heavy: on first use

        F = np.array([[1.0, gravity * dt, 0.0], [0.0, 1.0, -dt], [0.0, 0.0, 1.0]])
        H = np.array([[1.0, 0.0, 0.0]])
        noise = [self.acceleration_noise * dt, self.rate_noise * dt, self.bias_walk * math.sqrt(dt)]
        P = solve_discrete_are(F.T, H.T, np.diag(np.square(noise)), np.array([[self.speed_noise**2]]))
        speed, pitch, bias = (P[:, 0] / (P[0, 0] + self.speed_noise**2)).tolist()
        return TiltParams(dt, speed, pitch, bias)

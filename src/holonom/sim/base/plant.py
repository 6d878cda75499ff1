"""`BasePlant`: a base with fixed or Swedish driven wheels, motors, slip and a rigid body (specification 06.2)."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.control import ServoAxis
from holonom.control.base_tuning import WheelLoop, tune_wheel
from holonom.devices import DcMotor, Encoder, Friction, Gear, tracking_params
from holonom.errors import ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base import WheelBase
from holonom.mobile.wheel import Wheel
from holonom.sim.base.floor import Floor, floor_table
from holonom.sim.base.kernels import BLOCKED, DEAD, GRAVITY
from holonom.closed_loop.base_log import BaseLog, log_of
from holonom.closed_loop.base_kernels import drive_open
from holonom.sim.base.records import (
    BODY,
    BODY_SAMPLE,
    BODY_STATE,
    WHEEL,
    WHEEL_SAMPLE,
    WHEEL_STATE,
    aligned_records,
    side_by_side,
)

__all__ = ["FAULTS", "TICK", "BaseDrive", "BasePlant"]

Array = NDArray[np.float64]

TICK = 1e-3
"""Sample time of the controller and of the log, s."""
FAULTS = {"dead": DEAD, "blocked": BLOCKED}
"""What may happen to a motor: an open winding (it turns freely), or a jam."""
SUPPORTS = ("castor", "spherical")
COULOMB_SMOOTHING = 2.0  # rad/s of the motor, below which Coulomb friction goes over into its opposite


@dataclass(frozen=True, slots=True)
class BaseDrive:
    """What drives each wheel of a base; all wheels alike.

    Attributes
    ----------
    motor, gear, encoder, friction
        Data sheets of chapter 03; encoder and friction at the motor's shaft. The gear's ratio is motor turns per wheel
        turn.
    wheel_inertia
        Wheel about its axle, without the rotor, kg m^2.
    roller_drag
        Bearing drag of the rollers of a Swedish wheel over its load.

    Raises
    ------
    ModelError
        An inertia that is not positive, a drag outside [0, 1).
    """

    motor: DcMotor
    gear: Gear
    encoder: Encoder
    friction: Friction = field(default_factory=Friction)
    wheel_inertia: float = 2.5e-5
    roller_drag: float = 0.02

    def __post_init__(self) -> None:
        if not 0.0 < self.wheel_inertia < math.inf:
            raise ModelError(f"BaseDrive: wheel_inertia is {self.wheel_inertia!r} kg m2; it must be greater than 0")
        if not 0.0 <= self.roller_drag < 1.0:
            raise ModelError(f"BaseDrive: roller_drag is {self.roller_drag!r}; it must be at least 0 and below 1")

    @property
    def inertia(self) -> float:
        """Wheel and geared rotor about the wheel's axle, kg m^2."""
        return self.wheel_inertia + self.gear.ratio**2 * self.motor.rotor_inertia


class BasePlant:
    """A base on a floor. Mutable state: `state` and `states` (records, four wheels in each), `ticks`.

    Parameters
    ----------
    base
        Mass, centre of mass and alpha are its own: the centre of mass stands above the origin of base_link. Driven
        wheels are fixed or Swedish; castors and passive spheres bear load without friction.
    drive
        Motors, gears, encoders of the wheels.
    floor
        What it stands on.
    substeps
        Steps of the plant per millisecond.

    Raises
    ------
    ModelError
        No mass, a centre of mass elsewhere, wheels of a kind that is not simulated.
    OutOfLimits
        `substeps` below 1.
    """

    def __init__(self, base: WheelBase, drive: BaseDrive, floor: Floor = Floor(), *, substeps: int = 2) -> None:
        if substeps < 1:
            raise OutOfLimits(f"BasePlant: substeps is {substeps!r}; it must be at least 1")
        self.base, self.drive = base, drive
        self.mass, self.inertia = _mass(base), base.alpha * _mass(base) * base.radius**2
        self.driven = _driven_wheels(base)
        self.rows = base.velocity_coupling * [1.0, 1.0, base.radius]
        """(m, 3) rim speeds (m/s) of the driven wheels per (vx, vy, w): D with w in rad/s."""
        self.loop = _wheel_loop(base, drive, self.rows, self.mass, self.inertia)
        """Tuned speed loop of the wheels, with its margins."""
        dt = TICK / substeps
        self.body = aligned_records([(self.mass, self.inertia, base.com_height, dt, substeps)], BODY)
        reach = max(math.hypot(wheel.x, wheel.y) for wheel in self.driven)
        self.support = _support(base, self.driven)
        self.radii = np.array([wheel.radius for wheel in self.driven])
        """(m,) m, of the driven wheels."""
        of_wheel = zip(self.driven, self.support, self.rows, strict=False)
        rows = [_wheel_row(w, share, row, drive, self.loop, dt, reach) for w, share, row in of_wheel]
        self.wheels = side_by_side(np.array(rows, WHEEL), share=0.0, share_x=0.0, share_y=0.0)
        self.floor, self.patches = floor_table(floor)
        self.state = aligned_records(np.zeros(1, BODY_STATE), BODY_STATE)
        states = np.zeros(len(self.driven), WHEEL_STATE)
        states["conducts"] = states["works"] = states["cut"] = 1.0
        self.states = side_by_side(states, conducts=0.0, works=0.0)
        self.ticks = 0
        self.place((0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return self.ticks * TICK

    def place(self, pose: ArrayLike, twist: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Put the base at a pose (3,) with a twist (3,) in base_link, wheels rolling, estimates true."""
        state, states = self.state[0], self.states
        for names, values in ((("x", "y", "theta"), pose), (("vx", "vy", "w"), twist)):
            for name, value in zip(names, np.asarray(values, float), strict=True):
                state[name] = state[f"seen_{name}"] = value
        for name in ("vx", "vy", "w"):
            state[f"command_{name}"] = state[name]
        states["speed"].flat[: len(self.driven)] = self.rows @ np.asarray(twist, float) / self.radii
        turns = self.wheels["gear"]["ratio"] * states["angle"] * self.wheels["encoder"]["counts_per_rad"]
        states["count"] = np.floor(turns).astype(np.int64)
        states["seen_angle"] = states["counted"] = (states["count"] + 0.5) * self.wheels["encoder"]["resolution"]
        states["seen_speed"] = self.wheels["gear"]["ratio"] * states["speed"]

    def drive_open(self, voltages: ArrayLike) -> BaseLog:
        """Drive with motor voltages (N, m), V, one row each millisecond, without a controller.

        The log's `energy` and true quantities hold; its references and what a controller would know are zero.

        Raises
        ------
        ShapeError
            Voltages of another shape, or not finite.
        """
        u = np.ascontiguousarray(voltages, float)
        m = len(self.driven)
        if u.ndim != 2 or u.shape[1] != m or not np.isfinite(u).all():
            raise ShapeError(f"voltages have shape {u.shape}; they must be (N, {m}), finite: one column per motor")
        body_log, wheel_log = np.zeros(len(u), BODY_SAMPLE), np.zeros((len(u), len(self.wheels)), WHEEL_SAMPLE)
        drive_open(
            self.body, self.state, self.wheels, self.states, self.passive, self.floor, self.patches, u,
            body_log, wheel_log,
        )  # fmt: skip
        time = self.time + TICK * np.arange(len(u), dtype=np.float64)
        self.ticks += len(u)
        return log_of(time, body_log, wheel_log, np.zeros((len(u), 4), np.int64), self.base.driven)

    def kinetic_energy(self) -> float:
        """Kinetic energy (J) of body, wheels and rotors."""
        s = self.state[0]
        body = 0.5 * self.mass * (s["vx"] ** 2 + s["vy"] ** 2) + 0.5 * self.inertia * s["w"] ** 2
        return float(body + 0.5 * (self.wheels["inertia"] * self.states["speed"] ** 2).sum())

    @property
    def passive(self) -> Array:
        """(k, 3) rows of `support` of what bears load beside the driven wheels."""
        return self.support[len(self.driven) :]

    @property
    def push(self) -> Array:
        """(m,) N along its rim per ampere of each motor."""
        motor, gear = self.drive.motor, self.drive.gear
        force: Array = motor.torque_constant * gear.ratio * gear.efficiency / self.radii
        return force

    def max_force(self, friction: float) -> float:
        """Force (N) along its rim that a wheel can be asked for: its motor's, or what an assumed friction carries."""
        motor = self.drive.motor
        torque = motor.torque_constant * min(motor.max_current, motor.max_voltage / motor.resistance)
        load = self.mass * GRAVITY * float(self.support[: len(self.driven), 0].min())
        return min(abs(self.drive.gear.ratio) * self.drive.gear.efficiency * torque / self.radii.max(), friction * load)

    def wheel_index(self, wheel: int | str) -> int:
        """Index of a driven wheel given by name or index.

        Raises
        ------
        UnknownName
            No such wheel.
        """
        if isinstance(wheel, str):
            if wheel not in self.base.driven:
                raise UnknownName("driven wheel", wheel, self.base.driven)
            return self.base.driven.index(wheel)
        if not 0 <= wheel < len(self.driven):
            raise UnknownName("driven wheel", str(wheel), [str(k) for k in range(len(self.driven))])
        return wheel


def _mass(base: WheelBase) -> float:
    if base.mass is None:
        raise ModelError(f"base {base.name!r} has no mass, so it cannot be simulated; state mass= in kg")
    if np.abs(base.com).max() > 1e-9:
        raise ModelError(
            f"base {base.name!r} has its centre of mass at {base.com.tolist()} m; the simulation needs it above the "
            "origin of base_link: describe the wheels from there"
        )
    return base.mass


def _driven_wheels(base: WheelBase) -> list[Wheel]:
    for wheel in base.wheels:
        simulated = wheel.driven and wheel.kind in ("fixed", "swedish")
        if not (simulated or (wheel.kind in SUPPORTS and not wheel.driven)):
            driven = "driven" if wheel.driven else "passive"
            raise ModelError(
                f"wheel {wheel.name!r} is {driven} and {wheel.kind}; simulated are driven fixed and Swedish wheels, "
                "passive castors and spheres"
            )
    return [wheel for wheel in base.wheels if wheel.driven]


def _wheel_loop(base: WheelBase, drive: BaseDrive, rows: Array, mass: float, inertia: float) -> WheelLoop:
    """Tune for the largest share of the base that the wheels carry in any of its motions."""
    mobile = np.linalg.svd(rows / np.sqrt([mass, mass, inertia]), compute_uv=False)
    share = 1.0 / float(mobile[mobile > 1e-6 * mobile[0]].min()) ** 2 * float(max(w.radius for w in base.wheels)) ** 2
    at_motor = 1.0 / drive.gear.ratio**2
    motor = drive.motor
    axis = ServoAxis(
        resistance=motor.resistance,
        inductance=motor.inductance,
        torque_constant=motor.torque_constant,
        back_emf_constant=motor.back_emf_constant,
        inertia=at_motor * (drive.inertia + share),
        max_voltage=motor.max_voltage,
        max_current=motor.max_current,
        max_speed=motor.no_load_speed,
        counts_per_rev=drive.encoder.counts_per_rev,
        viscous=drive.friction.viscous,
    )
    return tune_wheel(axis, at_motor * drive.inertia, dt=TICK)


def _wheel_row(
    wheel: Wheel, share: Array, row: Array, drive: BaseDrive, loop: WheelLoop, dt: float, reach: float
) -> tuple[object, ...]:
    gamma = wheel.roller_angle
    ratio, efficiency = drive.gear.ratio, drive.gear.efficiency
    armature = drive.motor.armature(dt)
    slope = armature.conductance * (1.0 - armature.decay) * armature.back_emf
    turned = wheel.axle + gamma
    along, across = (math.sin(turned), -math.cos(turned)), (math.cos(turned), math.sin(turned))
    return (
        wheel.x, wheel.y,
        *along, wheel.x * along[1] - wheel.y * along[0],
        *across, wheel.x * across[1] - wheel.y * across[0],
        wheel.radius * math.cos(gamma), -wheel.radius * math.sin(gamma),
        *row, wheel.radius, reach, ratio * efficiency, ratio / efficiency, slope,
        wheel.kind == "swedish", drive.roller_drag, *share, drive.inertia, drive.motor.torque_constant,
        tuple(armature), tuple(drive.friction.params(COULOMB_SMOOTHING)), tuple(drive.gear.params()),
        tuple(drive.encoder.params()), tuple(tracking_params(loop.observer_bandwidth, TICK)), tuple(loop.speed),
    )  # fmt: skip


def _support(base: WheelBase, driven: list[Wheel]) -> Array:
    """How weight and its two moments spread over the wheels (k, 3): the least-squares loads, driven wheels first."""
    wheels = [*driven, *(w for w in base.wheels if not w.driven)]
    A = np.array([[1.0, w.x, w.y] for w in wheels]).T
    return np.ascontiguousarray(np.linalg.pinv(A))

"""`BasePlant`: a base with fixed or Swedish driven wheels, motors, slip and a rigid body (specification 06.2)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, finite_array, real_array, whole_number
from holonom.devices.drive_signals import WheelSignals
from holonom.errors import ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, BaseSensors, base_mass, load_shares, supports
from holonom.mobile.drive.coupling import base_twist
from holonom.sim.base.floor import Floor, floor_table
from holonom.sim.base.kernels import BLOCKED, DEAD, Supports
from holonom.sim.base.log import BaseTruth, truth_of
from holonom.sim.base.log_kernels import drive_open
from holonom.sim.base.records import BODY, BODY_SAMPLE, BODY_STATE, WHEEL, WHEEL_SAMPLE, WHEEL_STATE
from holonom.sim.base.step_kernels import BasePlantParams, SensorParams, base_acceleration, sense
from holonom.trace.call.records import aligned_records, side_by_side
from holonom.trace.code.simd import WIDTH

__all__ = ["FAULTS", "SIMULATED", "TICK", "BaseFault", "BasePlant", "driven_wheels"]


TICK = 1e-3
"""Time (s) that one step of the plant takes; sensors are read after each."""
FAULTS = {"dead": DEAD, "blocked": BLOCKED}
"""What may happen to a motor: an open winding (it turns freely), or a jam."""
SIMULATED, SUPPORTS = ("fixed", "swedish"), ("castor", "spherical")
"""Kinds of driven wheels, and of passive ones."""
COULOMB_SMOOTHING = 2.0  # rad/s of the motor, below which Coulomb friction goes over into its opposite


@dataclass(frozen=True, slots=True)
class BaseFault:
    """A motor that fails: time (s), wheel (name or index), "dead" (open winding, turns freely) or "blocked"."""

    time: float
    wheel: int | str
    kind: str = "dead"

    def __post_init__(self) -> None:
        if self.kind not in FAULTS:
            raise UnknownName("fault", self.kind, FAULTS)
        if not 0.0 <= self.time < math.inf:
            raise OutOfLimits(f"BaseFault: time is {self.time!r} s; it must be finite and at least 0")


class BasePlant:
    """A base on a floor. Mutable state: `state` and `states` (records, four wheels in each), `signals`, `rng`.

    Parameters
    ----------
    base
        Mass, centre of mass and alpha are its own. Driven wheels are fixed or Swedish; castors and passive spheres
        bear load without friction.
    drive
        Motors, gears, encoders of the wheels.
    floor
        What it stands on.
    sensors
        How its sensors err.
    faults
        What breaks, and when.
    rng
        Source of the sensors' noise; without one they have none.
    substeps
        Steps of the plant per millisecond.
    ideal
        Wheels turn as they are told and never slip: no motors, no floor.

    Raises
    ------
    ModelError
        No mass, wheels of a kind that is not simulated.
    OutOfLimits
        `substeps` below 1.
    UnknownName
        A fault of a wheel that there is not.
    """

    def __init__(
        self,
        base: WheelBase,
        drive: BaseDrive,
        floor: Floor = Floor(),
        *,
        sensors: BaseSensors = BaseSensors(),
        faults: Sequence[BaseFault] = (),
        rng: np.random.Generator | None = None,
        substeps: int = 2,
        ideal: bool = False,
    ) -> None:
        substeps = whole_number("BasePlant: substeps", substeps, least=1)
        self.base, self.drive, self.rng = base, drive, rng
        self.mass = base_mass(base)
        self.driven = driven_wheels(base)
        self.rows = base.velocity_coupling * [1.0, 1.0, base.radius]
        """(m, 3) rim speeds (m/s) of the driven wheels per (vx, vy, w): D with w in rad/s."""
        self.radii = np.array([wheel.radius for wheel in self.driven])
        """(m,) m, of the driven wheels."""
        self.support, contacts = load_shares(base), supports(base)
        count, dt = len(self.driven), TICK / substeps
        reach = float(np.hypot(*contacts[:count].T).max())
        rows = [
            _wheel_row(w, at, part, drive, dt, reach)
            for w, at, part in zip(self.driven, contacts, self.support, strict=False)
        ]
        broken = sorted((round(f.time / TICK), self.wheel_index(f.wheel), FAULTS[f.kind]) for f in faults)
        inertia = base.alpha * self.mass * base.radius**2
        self.params = BasePlantParams(
            aligned_records([(self.mass, inertia, base.com_height, dt, substeps, *base.com.tolist())], BODY),
            side_by_side(np.array(rows, WHEEL), share=0.0, share_x=0.0, share_y=0.0),
            Supports(
                self.support[count:], np.ascontiguousarray(contacts), np.zeros(len(contacts)), contacts.mean(axis=0)
            ),
            *floor_table(floor),
            np.array(broken, dtype=np.int64).reshape(-1, 3),
            SensorParams(*astuple(sensors)),
            ideal,
            self._forward(),
        )
        self.state = aligned_records(np.zeros(1, BODY_STATE), BODY_STATE)
        states = np.zeros(len(self.driven), WHEEL_STATE)
        states["conducts"] = 1.0
        self.states = side_by_side(states, conducts=0.0)
        lanes = WIDTH * len(self.states)
        zeros = (np.zeros(lanes), np.zeros(lanes))
        self.signals = WheelSignals(np.zeros(lanes, np.int64), np.zeros(lanes), np.zeros(3), *zeros)
        """What its sensors read last, and the voltages that it is driven with."""
        self._place((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), np.zeros(3 + WIDTH * len(self.states)))

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return float(self.state["tick"][0]) * TICK

    @property
    def pose(self) -> Array:
        """True pose (3,) of base_link: x, y, theta in the world."""
        x, y, theta = (float(self.state[name][0]) for name in ("x", "y", "theta"))
        (dx, dy), c, s = self.base.com, math.cos(theta), math.sin(theta)
        return np.array([x - c * dx + s * dy, y - s * dx - c * dy, theta])

    @property
    def twist(self) -> Array:
        """True twist (3,) of base_link, along its axes."""
        vx, vy, w = (float(self.state[name][0]) for name in ("vx", "vy", "w"))
        return np.array([vx + w * self.base.com[1], vy - w * self.base.com[0], w])

    @property
    def acceleration(self) -> Array:
        """True acceleration (2,) of base_link, along its axes, m/s^2."""
        return np.array(base_acceleration(self.params.body[0], self.state[0]))

    @property
    def tipped(self) -> float | None:
        """When it fell over, s; None while it stands."""
        tick = int(self.state["tipped"][0])
        return tick * TICK if tick else None

    def place(self, pose: ArrayLike, twist: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Put the base at a pose (3,) with a twist (3,) in base_link, wheels rolling, and read its sensors.

        Raises
        ------
        ShapeError
            Not three finite numbers each; it stays where it is.
        """
        self._place(finite_array("pose", pose, (3,)), finite_array("twist", twist, (3,)), self.noise(1)[0])

    def _place(self, pose: ArrayLike, twist: ArrayLike, noise: Array) -> None:
        state, states, (dx, dy) = self.state[0], self.states, self.base.com
        (x, y, theta), (vx, vy, w) = np.asarray(pose, float), np.asarray(twist, float)
        c, s = math.cos(theta), math.sin(theta)
        state["x"], state["y"], state["theta"] = x + c * dx - s * dy, y + s * dx + c * dy, theta
        state["vx"], state["vy"], state["w"] = vx - w * dy, vy + w * dx, w
        state["tipping"] = state["tipped"] = 0
        state["near"], state["fault"] = True, 0
        states["speed"].flat[: len(self.driven)] = self.rows @ np.asarray(twist, float) / self.radii
        sense(self.params, self.state, states, self.signals, noise)

    def noise(self, ticks: int) -> Array:
        """Standard normal numbers (ticks, 3 + 4 n) for the sensors of as many milliseconds.

        Raises
        ------
        OutOfLimits
            Not a whole number of them, or a negative one.
        """
        ticks = whole_number("ticks", ticks)
        found = np.zeros((ticks, 3 + WIDTH * len(self.states)))
        if self.rng is not None:
            found[:, : 3 + len(self.driven)] = self.rng.standard_normal((ticks, 3 + len(self.driven)))
        return found

    def _forward(self) -> Array:
        """(3, 4 n) twist of the centre of mass per wheel speed, rad/s, by least squares among those that drag none."""
        found, (x, y) = np.zeros((3, -(-len(self.radii) // WIDTH) * WIDTH)), self.base.com
        moved = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        found[:, : len(self.radii)] = moved @ base_twist(self.base, np.diag(self.radii)).T
        return found

    def drive_open(self, voltages: ArrayLike) -> BaseTruth:
        """Drive with motor voltages (N, m), V, one row each millisecond, without a controller.

        Raises
        ------
        ShapeError
            Voltages of another shape, or not finite.
        """
        u = np.ascontiguousarray(real_array("voltages", voltages))
        m = len(self.driven)
        if u.ndim != 2 or u.shape[1] != m or not np.isfinite(u).all():
            raise ShapeError(f"voltages have shape {u.shape}; they must be (N, {m}), finite: one column per motor")
        body_log, wheel_log = np.zeros(len(u), BODY_SAMPLE), np.zeros((len(u), len(self.states)), WHEEL_SAMPLE)
        time = self.time + TICK * np.arange(len(u), dtype=np.float64)
        still = np.zeros(3 + WIDTH * len(self.states))
        drive_open(self.params, self.state, self.states, self.signals, still, u, body_log, wheel_log)
        return truth_of(time, body_log, wheel_log, m)

    def kinetic_energy(self) -> float:
        """Kinetic energy (J) of body, wheels and rotors."""
        s, body = self.state[0], self.params.body[0]
        moving = 0.5 * body["mass"] * (s["vx"] ** 2 + s["vy"] ** 2) + 0.5 * body["inertia"] * s["w"] ** 2
        return float(moving + 0.5 * (self.params.wheels["inertia"] * self.states["speed"] ** 2).sum())

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


def driven_wheels(base: WheelBase) -> list[Wheel]:
    """Return the driven wheels of a base that can be simulated.

    Raises
    ------
    ModelError
        A wheel that is driven and neither fixed nor Swedish, or passive and neither castor nor sphere; names it.
    """
    for wheel in base.wheels:
        simulated = wheel.driven and wheel.kind in SIMULATED
        if not (simulated or (wheel.kind in SUPPORTS and not wheel.driven)):
            driven = "driven" if wheel.driven else "passive"
            raise ModelError(
                f"wheel {wheel.name!r} is {driven} and {wheel.kind}; simulated are driven fixed and Swedish wheels, "
                "passive castors and spheres"
            )
    return [wheel for wheel in base.wheels if wheel.driven]


def _wheel_row(
    wheel: Wheel, at: Array, share: Array, drive: BaseDrive, dt: float, reach: float
) -> tuple[object, ...]:  # fmt: skip
    (x, y), gamma = at.tolist(), wheel.roller_angle
    ratio, efficiency = drive.gear.ratio, drive.gear.efficiency
    armature = drive.motor.armature(dt)
    slope = armature.conductance * (1.0 - armature.decay) * armature.back_emf
    turned = wheel.axle + gamma
    along, across = (math.sin(turned), -math.cos(turned)), (math.cos(turned), math.sin(turned))
    return (
        x, y,
        *along, x * along[1] - y * along[0],
        *across, x * across[1] - y * across[0],
        wheel.radius * math.cos(gamma), -wheel.radius * math.sin(gamma),
        reach, ratio * efficiency, ratio / efficiency, slope,
        wheel.kind == "swedish", drive.roller_drag, *share, drive.inertia, drive.motor.torque_constant,
        tuple(armature), tuple(drive.friction.params(COULOMB_SMOOTHING)), tuple(drive.gear.params()),
        tuple(drive.encoder.params()),
    )  # fmt: skip

"""`BasePlant`: a base with its wheels, motors, steering, slip and a rigid body (specification 06.2)."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from holonom.arrays import Array, finite_array, real_array, whole_number
from holonom.devices.drive_signals import WheelSignals
from holonom.errors import ModelError, OutOfLimits, ShapeError, UnknownName
from holonom.mobile.base.payload import Payload, loaded
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, BaseSensors
from holonom.sim.base.balancing import axle_of, kinetic_energy
from holonom.sim.base.bodies import bodies_of
from holonom.sim.base.floor import Floor, floor_table, step_table, wheel_grips
from holonom.sim.base.kernels import BLOCKED, DEAD, FROZEN, OFF, STUCK
from holonom.sim.base.log import BaseTruth, truth_of
from holonom.sim.base.log_kernels import drive_open
from holonom.sim.base.records import BODY_SAMPLE, BODY_STATE, WHEEL_SAMPLE, WHEEL_STATE
from holonom.sim.base.step_kernels import BasePlantParams, SensorParams, base_acceleration, sense
from holonom.sim.base.wheel_rows import Lane, lanes_of
from holonom.trace.call.records import aligned_records, side_by_side
from holonom.trace.code.simd import WIDTH

__all__ = ["FAULTS", "TICK", "BaseFault", "BasePlant", "simulated_lanes"]


Records = NDArray[np.void]
TICK = 1e-3
"""Time (s) that one step of the plant takes; sensors are read after each."""
FAULTS = {"dead": DEAD, "blocked": BLOCKED, "stuck": STUCK, "frozen": FROZEN, "off": OFF}
"""What may happen to a motor: an open winding (it turns freely), a jam; to a steering motor: it stays where it is;
to an encoder: it counts no more; to a wheel: it has come off, or loose on its axle, and pushes no more."""


@dataclass(frozen=True, slots=True)
class BaseFault:
    """A motor that fails: time (s), wheel (name or index), one of `FAULTS`."""

    time: float
    wheel: int | str
    kind: str = "dead"

    def __post_init__(self) -> None:
        if self.kind not in FAULTS:
            raise UnknownName("fault", self.kind, FAULTS)
        if not 0.0 <= self.time < math.inf:
            raise OutOfLimits(f"BaseFault: time is {self.time!r} s; it must be finite and at least 0")

    def text(self, driven: Sequence[str]) -> str:
        """What breaks, in words; `driven` are the names of the base's driven wheels."""
        name = self.wheel if isinstance(self.wheel, str) else driven[self.wheel]
        does = {
            "dead": "the motor of {} dies",
            "blocked": "the motor of {} jams",
            "stuck": "the steering of {} is stuck",
            "frozen": "the encoder of {} is stuck",
            "off": "{} comes off",
        }
        return does[self.kind].format(name)


class BasePlant:
    """A base on a floor. Mutable state: `state` and `states` (records, four wheels in each), `signals`, `rng`.

    Parameters
    ----------
    base
        Mass, centre of mass and inertia are its own. Passive balls bear load without friction; castors bear theirs at
        their pivots.
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
        Steps of the plant per millisecond; None: 2, 4 where wheels steer, trail or skid, 8 where the body balances.
    ideal
        Wheels turn as they are told and never slip: no motors, no floor.
    grips
        Name of a wheel -> its friction over that of the floor's material: worn or soft tyres; 1 unless given.

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
        substeps: int | None = None,
        ideal: bool = False,
        grips: Mapping[str, float] | None = None,
    ) -> None:
        quick = all(wheel.kind in ("swedish", "fixed", "spherical", "ball") for wheel in base.wheels)
        usual = 8 if base.balances else 2 if quick else 4
        substeps = whole_number("BasePlant: substeps", usual if substeps is None else substeps, least=1)
        self.base, self.drive, self.rng = base, drive, rng
        self.floor, self._empty, self._substeps = floor, base, substeps
        self.lanes, self.radii = simulated_lanes(base), base.wheel_radii
        self.rows = base.rest_coupling * [1.0, 1.0, base.radius]
        """(m, 3) rim speeds (m/s) of the driven wheels per (vx, vy, w), steered ones at rest."""
        bodies = bodies_of(base, drive, floor, self.lanes, substeps)
        self.centre = bodies.centre
        """(2,) in base_link: the centre of mass; of a body that balances the place on its axle beside it."""
        broken = sorted((round(f.time / TICK), self._broken_lane(f), FAULTS[f.kind]) for f in faults)
        turns = any(lane.wheel.kind in ("steered", "castor") for lane in self.lanes)
        self.params = BasePlantParams(
            bodies.body,
            bodies.wheels,
            bodies.supports,
            *floor_table(floor),
            np.array(broken, dtype=np.int64).reshape(-1, 3),
            SensorParams(*astuple(sensors)),
            1 if turns else None,
            bodies.lean,
            step_table(floor),
            ideal,
            self._forward(),
        )
        self.state = aligned_records(np.zeros(1, BODY_STATE), BODY_STATE)
        states = np.zeros(len(self.lanes), WHEEL_STATE)
        states["conducts"] = [lane.wheel.driven for lane in self.lanes]
        states["free"] = states["counts"] = 1.0
        states["grips"] = wheel_grips([lane.wheel.name for lane in self.lanes], grips or {})
        self.states = side_by_side(states, conducts=0.0)
        lanes = WIDTH * len(self.states)
        zeros = [np.zeros(lanes) for _ in range(4)]
        inertial = np.zeros(5 if base.balances else 3)
        self.signals = WheelSignals(np.zeros(lanes, np.int64), np.zeros(lanes), inertial, *zeros)
        """What its sensors read last, and the voltages that it is driven with."""
        self._place((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), self.noise(1)[0] * 0.0)

    @property
    def time(self) -> float:
        """Simulated time, s."""
        return float(self.state["tick"][0]) * TICK

    @property
    def pose(self) -> Array:
        """True pose (3,) of base_link: x, y, theta in the world."""
        x, y, theta = (float(self.state[name][0]) for name in ("x", "y", "theta"))
        (dx, dy), c, s = self.centre, math.cos(theta), math.sin(theta)
        return np.array([x - c * dx + s * dy, y - s * dx - c * dy, theta])

    @property
    def twist(self) -> Array:
        """True twist (3,) of base_link, along its axes."""
        vx, vy, w = (float(self.state[name][0]) for name in ("vx", "vy", "w"))
        return np.array([vx + w * self.centre[1], vy - w * self.centre[0], w])

    @property
    def pitch(self) -> Array:
        """True pitch (2,) of a body that balances, forwards, and its rate: rad, rad/s."""
        return np.array([self.state["pitch"][0], self.state["pitch_rate"][0]])

    @property
    def acceleration(self) -> Array:
        """True acceleration (2,) of base_link, along its axes, m/s^2."""
        return np.array(base_acceleration(self.params.body[0], self.state[0]))

    @property
    def tipped(self) -> float | None:
        """When it fell over, s; None while it stands."""
        tick = int(self.state["tipped"][0])
        return tick * TICK if tick else None

    def lean(self, pitch: float, rate: float = 0.0) -> None:
        """Lean a body that balances forwards by an angle (rad), turning at a rate (rad/s); its wheels roll on.

        Raises
        ------
        ModelError
            A body that does not balance.
        OutOfLimits
            An angle at which it has fallen, a number that is none.
        """
        lean = self.params.lean
        if lean is None:
            raise ModelError(f"base {self.base.name!r} does not balance its body; only a segway leans")
        if not (abs(pitch) < lean.limit and math.isfinite(rate)):
            raise OutOfLimits(f"pitch is {pitch!r} rad, its rate {rate!r} rad/s; it must be below {lean.limit:.3g} rad")
        self.states["speed"] -= np.where(self.params.wheels["coupled"] > 0.0, rate - self.state["pitch_rate"][0], 0.0)
        self.state["pitch"], self.state["pitch_rate"] = pitch, rate
        sense(self.params, self.state, self.states, self.signals, self.noise(1)[0])

    def place(self, pose: ArrayLike, twist: ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Put the base at a pose (3,) with a twist (3,) in base_link, wheels steered and rolling, and read its sensors.

        A body that balances stands upright.

        Raises
        ------
        ShapeError
            Not three finite numbers each; it stays where it is.
        OutOfLimits
            A twist beyond what its wheels can be steered to.
        """
        pose, twist = finite_array("pose", pose, (3,)), finite_array("twist", twist, (3,))
        self._place(pose, twist, self.noise(1)[0], self._steered_to(twist))

    def carry(self, payload: Payload) -> None:
        """Carry a payload from now on, instead of what was carried; it goes on as it moved.

        Nobody tells the controller.

        Raises
        ------
        ModelError
            With it, a body that balances would be turned by its pitch.
        """
        base, pose, twist = loaded(self._empty, payload), self.pose, self.twist
        bodies = bodies_of(base, self.drive, self.floor, self.lanes, self._substeps)
        self.base, self.centre = base, bodies.centre
        self.params = self.params._replace(
            body=bodies.body, wheels=bodies.wheels, supports=bodies.supports, lean=bodies.lean
        )
        self.params = self.params._replace(forward=self._forward())
        self._locate(pose, twist)
        wheels, states = bodies.wheels, self.states
        for name in ("along", "across"):
            x, y = states[f"{name}_x"], states[f"{name}_y"]
            states[f"{name}_arm"] = wheels["x"] * y - wheels["y"] * x

    def _steered_to(self, twist: Array) -> Array:
        """Angles of the lanes against rest with which the base moves so; castors trail."""
        angles, turned = self.base.steering(twist), np.zeros(len(self.lanes))
        for group, angle in zip(self.base.layout.groups, angles, strict=True):
            names = [self.base.wheels[i].name for i in group]
            turned[[k for k, lane in enumerate(self.lanes) if lane.wheel.name in names]] = angle
        for k, (wheel, heading, _) in enumerate(self.lanes):
            vx, vy = twist[0] - wheel.y * twist[2], twist[1] + wheel.x * twist[2]
            if wheel.kind == "castor" and math.hypot(vx, vy) > 0.0:
                towards = math.copysign(1.0, -wheel.castor_offset)
                turned[k] = math.remainder(math.atan2(towards * vy, towards * vx) - heading, 2.0 * math.pi)
        return turned

    def _roll(self, turned: Array, vx: float, vy: float, w: float) -> None:
        """Turn the lanes by angles, and let their wheels roll with a twist of the centre of mass."""
        states, wheels, count = self.states, self.params.wheels, len(self.lanes)
        flat = {name: wheels[name].reshape(-1) for name in ("x", "y", "rest_x", "rest_y", "along_radius", "turns")}
        angle = flat["turns"].copy()
        angle[:count] *= turned
        c, s = np.cos(angle), np.sin(angle)
        along = c * flat["rest_x"] - s * flat["rest_y"], s * flat["rest_x"] + c * flat["rest_y"]
        for name, (x, y) in (("along", along), ("across", (-along[1], along[0]))):
            states[f"{name}_x"].flat[:], states[f"{name}_y"].flat[:] = x, y
            states[f"{name}_arm"].flat[:] = flat["x"] * y - flat["y"] * x
        rolled = along[0] * vx + along[1] * vy + (flat["x"] * along[1] - flat["y"] * along[0]) * w
        states["speed"].flat[:count] = (rolled / flat["along_radius"])[:count]
        states["turned"].flat[:] = states["motor"].flat[:] = states["asked"].flat[:] = angle
        self.signals.steering[:] = angle
        states["swing"].flat[:] = flat["turns"] * w

    def _place(self, pose: ArrayLike, twist: ArrayLike, noise: Array, steering: Array | None = None) -> None:
        state, states = self.state[0], self.states
        self._locate(np.asarray(pose, float), np.asarray(twist, float))
        state["pitch"] = state["pitch_rate"] = state["pitch_acceleration"] = 0.0
        state["tipping"] = state["tipped"] = 0
        state["near"], state["fault"] = True, 0
        self._roll(
            np.zeros(len(self.lanes)) if steering is None else steering, *(float(state[v]) for v in ("vx", "vy", "w"))
        )
        sense(self.params, self.state, states, self.signals, noise)

    def _locate(self, pose: Array, twist: Array) -> None:
        """Put the centre of mass where it is at a pose and a twist of base_link."""
        state, (dx, dy), (x, y, theta), (vx, vy, w) = self.state[0], self.centre, pose, twist
        c, s = math.cos(theta), math.sin(theta)
        state["x"], state["y"], state["theta"] = x + c * dx - s * dy, y + s * dx + c * dy, theta
        state["vx"], state["vy"], state["w"] = vx - w * dy, vy + w * dx, w
        known = self.params.body[0]
        state["down_x"] = c * known["slope_x"] + s * known["slope_y"]
        state["down_y"] = c * known["slope_y"] - s * known["slope_x"]

    def noise(self, ticks: int) -> Array:
        """Standard normal numbers (ticks, 3 + 4 n) for the sensors of as many milliseconds; 2 more where it balances.

        Raises
        ------
        OutOfLimits
            Not a whole number of them, or a negative one.
        """
        ticks = whole_number("ticks", ticks)
        more = 2 if self.base.balances else 0
        found = np.zeros((ticks, 3 + WIDTH * len(self.states) + more))
        if self.rng is not None:
            count = 3 + len(self.base.driven)
            found[:, :count] = self.rng.standard_normal((ticks, count))
            found[:, found.shape[1] - more :] = self.rng.standard_normal((ticks, more))
        return found

    def _forward(self) -> Array:
        """(3, 4 n) twist of the centre of mass per wheel speed, rad/s, by least squares among those that drag none."""
        found, (x, y) = np.zeros((3, -(-len(self.lanes) // WIDTH) * WIDTH)), self.centre
        if self.base.steered:
            return found
        moved = np.array([[1.0, 0.0, -y], [0.0, 1.0, x], [0.0, 0.0, 1.0]])
        found[:, : len(self.base.driven)] = moved @ self.base.twist(np.eye(len(self.base.driven))).T
        return found

    def drive_open(self, voltages: ArrayLike) -> BaseTruth:
        """Drive with motor voltages (N, m), V, one row each millisecond, without a controller.

        Raises
        ------
        ShapeError
            Voltages of another shape, or not finite.
        """
        u = np.ascontiguousarray(real_array("voltages", voltages))
        m = len(self.base.driven)
        if u.ndim != 2 or u.shape[1] != m or not np.isfinite(u).all():
            raise ShapeError(f"voltages have shape {u.shape}; they must be (N, {m}), finite: one column per motor")
        body_log, wheel_log = np.zeros(len(u), BODY_SAMPLE), np.zeros((len(u), len(self.states)), WHEEL_SAMPLE)
        time = self.time + TICK * np.arange(len(u), dtype=np.float64)
        still = np.zeros(self.noise(0).shape[1])
        drive_open(self.params, self.state, self.states, self.signals, still, u, body_log, wheel_log)
        return truth_of(time, body_log, wheel_log, m)

    def kinetic_energy(self) -> float:
        """Kinetic energy (J) of body, wheels and rotors."""
        if self.params.lean is not None:
            return kinetic_energy(self.params.lean, self.state[0], self.params.wheels, self.states)
        s, body = self.state[0], self.params.body[0]
        moving = 0.5 * body["mass"] * (s["vx"] ** 2 + s["vy"] ** 2) + 0.5 * body["inertia"] * s["w"] ** 2
        wheels, states = self.params.wheels, self.states
        turning = wheels["turns"] * wheels["steering"]["inertia"] * states["swing"] ** 2
        return float(moving + 0.5 * (wheels["inertia"] * states["speed"] ** 2 + turning).sum())

    def _broken_lane(self, fault: BaseFault) -> int:
        """Lane of what breaks: of a driven wheel, or of a steered one.

        Raises
        ------
        UnknownName
            No such wheel, or none with such a motor.
        """
        if FAULTS[fault.kind] != STUCK:
            return self.wheel_index(fault.wheel)
        steered = {lane.wheel.name: k for k, lane in enumerate(self.lanes) if lane.wheel.steers}
        if fault.wheel not in steered:
            raise UnknownName("steered wheel", str(fault.wheel), steered)
        return steered[str(fault.wheel)]

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
        if not 0 <= wheel < len(self.base.driven):
            raise UnknownName("driven wheel", str(wheel), [str(k) for k in range(len(self.base.driven))])
        return wheel


def simulated_lanes(base: WheelBase) -> list[Lane]:
    """Return the lanes of a base that can be simulated.

    Raises
    ------
    ModelError
        A kind of wheel that is not, or steered wheels beside such with rollers; a body that balances on
        anything but one axle.
    """
    if base.balances:
        axle_of(base)
    rolling = [wheel.name for wheel in base.wheels if wheel.kind in ("swedish", "ball")]
    if base.steered and rolling:
        raise ModelError(f"base {base.name!r} has steered wheels beside {rolling[0]!r}, which is not simulated yet")
    return lanes_of(base)

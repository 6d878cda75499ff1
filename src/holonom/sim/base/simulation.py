"""`simulate_base`: a base keeps a path at 1 kHz while wheels slip and motors die, all in one compiled loop."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from holonom.control.path_keeping import EstimateSettings, KeepingSettings
from holonom.control.traction import TractionSettings, WatchSettings
from holonom.devices import Accelerometer, CurrentShunt, Gyro
from holonom.errors import ModelError, OutOfLimits, UnknownName
from holonom.mobile.base import WheelBase
from holonom.mobile.drive.coupling import Coupling
from holonom.mobile.drive.slip import SlipSettings, slip_params
from holonom.mobile.drive.slip_kernels import BOUND, SlipParams
from holonom.signals import Event
from holonom.sim.base.floor import Floor
from holonom.sim.base.kernels import GRAVITY
from holonom.sim.base.log import BaseLog, log_of
from holonom.sim.base.loop import CUT_OFF, DONE, STOPPED, LoopParams, SensorParams, run_loop
from holonom.sim.base.paths import ReferencePath
from holonom.sim.base.plant import FAULTS, TICK, BaseDrive, BasePlant
from holonom.sim.base.records import BODY_SAMPLE, WHEEL_SAMPLE
from holonom.trace.simd import WIDTH

__all__ = ["BaseFault", "BaseSensors", "BaseSettings", "Creep", "simulate_base", "slip_settings"]

Array = NDArray[np.float64]

SLOWEST = 0.2  # part of the path's speed below which a run is cut off
RESERVE = 0.85  # part of the largest force that a slowed-down path may need; the rest is for errors
RATE_CHANGE = 1.0  # 1/s, how fast a path is slowed down
CREEP_ERROR = 0.003  # m/s, standard deviation of what is not known of a gripping wheel's creep
COUNT_RATE = 120.0  # 1/s, standard deviation of measured speed per encoder count, through the wheels' observer
LEAST_RATE_NOISE = 2e-3  # rad/s
TILT = 0.1  # m/s2, of a floor that is not quite level
ENDINGS = {DONE: "done", STOPPED: "jammed", CUT_OFF: "cut off"}


@dataclass(frozen=True, slots=True)
class BaseSensors:
    """Noise of a base's sensors; encoders quantise by themselves.

    Attributes
    ----------
    gyro_noise, gyro_bias
        Standard deviation of a 1 kHz sample, constant offset, rad/s.
    accelerometer_noise, accelerometer_bias
        The same, m/s^2, on both axes.
    current_noise
        Standard deviation of a shunt's sample, A.
    """

    gyro_noise: float = Gyro().noise
    gyro_bias: float = Gyro().bias
    accelerometer_noise: float = Accelerometer().noise
    accelerometer_bias: float = Accelerometer().bias
    current_noise: float = CurrentShunt().noise

    def params(self) -> SensorParams:
        """Params of the compiled loop."""
        return SensorParams(
            self.gyro_noise, self.gyro_bias, self.accelerometer_noise, self.accelerometer_bias, self.current_noise
        )


@dataclass(frozen=True, slots=True)
class Creep:
    """What the controller knows of gripping wheels: they creep, the more the harder they push.

    Attributes
    ----------
    slope
        Slip speed (m/s) over the part of the load that is pushed with, where both are small.
    grip
        Largest part of the load that a wheel can push with.

    Raises
    ------
    OutOfLimits
        A negative slope, a grip that is not positive.
    """

    slope: float
    grip: float

    def __post_init__(self) -> None:
        if not (0.0 <= self.slope < math.inf and 0.0 < self.grip < math.inf):
            raise OutOfLimits(
                f"Creep: slope is {self.slope!r} m/s, grip {self.grip!r}; slope must be at least 0, grip above 0"
            )


def slip_settings(sensors: BaseSensors, drive: BaseDrive, radius: float = 0.03) -> SlipSettings:
    """Slip detection for sensors, encoders and a wheel radius (m): what is noise to them is none of a slipping wheel.

    Rim speed: an encoder count, through the observer of the wheel's speed, beside what the creep of a gripping wheel
    is known to. Gyro and accelerometers: what they state, at least what good ones have, and a floor that is not quite
    level; in 10 ms noise averages out to a third.
    """
    count = radius * 2.0 * math.pi / drive.encoder.counts_per_rev / abs(drive.gear.ratio)
    return SlipSettings(
        noise=math.hypot(CREEP_ERROR, count * COUNT_RATE),
        rate_noise=max(sensors.gyro_noise, LEAST_RATE_NOISE),
        rate_bias=abs(sensors.gyro_bias) + LEAST_RATE_NOISE,
        max_acceleration=8.0,
        max_angular_acceleration=150.0,
        acceleration_error=abs(sensors.accelerometer_bias) + sensors.accelerometer_noise / 3.0 + TILT,
        angular_acceleration_error=math.inf,
        persistence=0.012,
        confirmation=0.006,
    )


@dataclass(frozen=True, slots=True)
class BaseSettings:
    """Controllers of a base; None switches traction control, slip detection or the watch over the motors off.

    Attributes
    ----------
    keeping, estimate, traction, watch, sensors
        Their settings.
    slip
        Settings of slip detection; "sensors": `slip_settings` of these sensors and the drive's encoders.
    creep
        What is known of gripping wheels; None: as measured on the floor's own material. What wheels creep at their
        forces is taken from their speeds before these are asked for slip.
    friction
        Friction coefficient that the controller counts on; limits the force asked of a wheel.

    Raises
    ------
    OutOfLimits
        A friction coefficient that is not positive.
    """

    keeping: KeepingSettings = field(default_factory=KeepingSettings)
    estimate: EstimateSettings = field(default_factory=EstimateSettings)
    traction: TractionSettings | None = field(default_factory=TractionSettings)
    slip: SlipSettings | Literal["sensors"] | None = "sensors"
    watch: WatchSettings | None = field(default_factory=WatchSettings)
    sensors: BaseSensors = BaseSensors()
    friction: float = 0.6
    creep: Creep | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.friction < math.inf:
            raise OutOfLimits(f"BaseSettings: friction is {self.friction!r}; it must be finite and greater than 0")


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


def simulate_base(
    base: WheelBase,
    drive: BaseDrive,
    path: ReferencePath,
    *,
    floor: Floor = Floor(),
    faults: Sequence[BaseFault] = (),
    settings: BaseSettings = BaseSettings(),
    rng: np.random.Generator,
    substeps: int = 2,
) -> BaseLog:
    """Drive a base along a path; it starts where the path does.

    Controller at 1 kHz: encoders, gyro, accelerometers and shunts; slip detection; watch over the motors; velocity
    and pose by dead reckoning without the slipping wheel; path keeping; forces by the wheels that work; traction
    control; speed loops. It is told of no fault and no patch. Where the motors that are left cannot give the path's
    accelerations it is driven slower (same curve), for at most five times as long; a jammed wheel stops the base. The
    log's `ended` and `driven` say how it went. Plant at 1 kHz times `substeps`.

    Parameters
    ----------
    base, drive, floor
        What moves, what drives it, what it stands on.
    path
        Reference at 1 kHz.
    faults
        What breaks, and when.
    settings
        Controllers and sensors.
    rng
        Source of all noise: the same one gives the same bits.
    substeps
        Steps of the plant per millisecond.

    Raises
    ------
    ModelError
        A base that cannot be simulated (`BasePlant`), or that cannot move in all three directions.
    UnknownName
        A fault of a wheel that there is not.
    """
    plant = BasePlant(base, drive, floor, substeps=substeps)
    if np.linalg.matrix_rank(plant.rows) < 3:
        raise ModelError(f"base {base.name!r} cannot move in all directions; this path keeping needs one that can")
    reference = np.ascontiguousarray(np.hstack([path.pose, path.twist, path.acceleration]), float)
    n = math.ceil(len(reference) / SLOWEST)
    plant.place(reference[0, :3], reference[0, 3:6])
    table = sorted((round(f.time / TICK), plant.wheel_index(f.wheel), FAULTS[f.kind]) for f in faults)
    body_log, wheel_log = np.zeros(n, BODY_SAMPLE), np.zeros((n, len(plant.wheels)), WHEEL_SAMPLE)
    said = np.zeros((n, 4), np.int64)
    params = _loop_params(plant, settings, floor)
    done, ending, phase = run_loop(
        params,
        settings.sensors.params(),
        plant.body,
        plant.state,
        plant.wheels,
        plant.states,
        plant.passive,
        plant.floor,
        plant.patches,
        reference,
        np.array(table, dtype=np.int64).reshape(-1, 3),
        rng,
        body_log,
        wheel_log,
        said,
    )
    time, ended, driven = TICK * np.arange(done, dtype=np.float64), ENDINGS[ending], _driven(path, phase)
    events = [Event(f.time, "warning", "plant", _fault_text(f, plant)) for f in faults]
    events += _ending_events(ended, driven, TICK * (done - 1))
    logs, residual = (body_log[:done], wheel_log[:done], said[:done]), params.residual * plant.radii
    return log_of(time, *logs, base.driven, events, residual=residual, ended=ended, driven=driven)


def _loop_params(plant: BasePlant, settings: BaseSettings, floor: Floor) -> LoopParams:
    base = plant.base
    coupling = Coupling(plant.rows / [1.0, 1.0, base.radius], base.radius, base.alpha)
    inverse = np.linalg.pinv(coupling.velocity)
    slip = settings.slip
    if slip is None or isinstance(slip, str):
        slip = slip_settings(settings.sensors, plant.drive, float(plant.radii.max()))
    slipping = slip_params(coupling, slip)
    creep = settings.creep or Creep(floor.material.creep, floor.material.peak or 1.0)
    loads = plant.mass * GRAVITY * plant.support[: len(plant.driven), 0]
    return LoopParams(
        keeping=settings.keeping.params(TICK),
        estimate=settings.estimate.params(TICK),
        traction=(settings.traction or TractionSettings()).params(TICK),
        watch=(settings.watch or WatchSettings()).params(TICK),
        slip=slipping,
        rows=np.ascontiguousarray(plant.rows),
        residual=np.eye(len(plant.rows)) - coupling.velocity @ inverse,
        inverse=np.ascontiguousarray(inverse),
        quiet=_quiet(slip, slipping),
        push=np.append(plant.push / (loads * creep.grip), np.zeros(-len(loads) % WIDTH)),
        creep=creep.slope * creep.grip,
        mass=plant.mass,
        inertia=plant.inertia,
        max_force=plant.max_force(settings.friction),
        reserve=RESERVE,
        rate_change=RATE_CHANGE,
        detect=settings.slip is not None,
        control_traction=settings.traction is not None,
        compensate=settings.watch is not None,
    )


def _quiet(slip: SlipSettings, params: SlipParams) -> float:
    """Bound of the detector on the square sum of the residual, (m/s)^2, where it is one number for all wheels."""
    if params.redundancy <= 0 or not isinstance(slip.noise, float):
        return -1.0
    return float(params.hypotheses[0, BOUND]) * slip.noise**2


def _driven(path: ReferencePath, phase: float) -> float:
    """Part of a path's length (of its turn, on the spot; else of its time) before a phase in samples."""
    if phase >= len(path.pose) - 1:
        return 1.0
    steps = np.abs(np.diff(path.pose, axis=0))
    for length in (np.hypot(steps[:, 0], steps[:, 1]), steps[:, 2], np.ones(len(steps))):
        if (total := float(length.sum())) > 0.0:
            gone = np.concatenate([[0.0], np.cumsum(length)])
            return float(np.interp(phase, np.arange(len(gone)), gone)) / total
    return 1.0


def _ending_events(ended: str, driven: float, time: float) -> list[Event]:
    """What cut a run short; nothing where it went to the end of the path."""
    texts = {
        "jammed": f"stopped with a jammed wheel after {100.0 * driven:.0f} % of the path",
        "cut off": f"cut off after {100.0 * driven:.0f} % of the path: driven too slowly, it takes more than "
        f"{1.0 / SLOWEST:g} times its time",
    }
    return [Event(time, "error", "simulation", texts[ended])] if ended in texts else []


def _fault_text(fault: BaseFault, plant: BasePlant) -> str:
    name = plant.base.driven[plant.wheel_index(fault.wheel)]
    return f"the motor of {name} {'dies' if fault.kind == 'dead' else 'jams'}"

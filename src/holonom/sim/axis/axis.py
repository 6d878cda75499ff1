"""`Axis`: a motor, its gear, a load and an encoder, as they truly are."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from holonom.control import ServoAxis
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.devices.motors.dc_motor import mean_weight
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter
from holonom.sim.axis.kernels import AxisPlantParams, AxisState

__all__ = ["Axis", "Load"]

CONTACT = 0.25  # stiffness of stiff teeth: part of the reduced inertia over the step squared
CONTACT_DAMPING = 0.5  # of critical


@dataclass(frozen=True, slots=True)
class Load:
    """What an axis moves, behind its gear.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    inertia: float = parameter(meaning="about the joint", unit="kg m2", above=0.0, example=3e-5)
    coulomb: float = parameter(0.0, meaning="Coulomb friction", unit="N m", least=0.0)
    viscous: float = parameter(0.0, meaning="viscous friction", unit="N m s/rad", least=0.0)
    torque: float = parameter(0.0, meaning="constant torque against the positive direction", unit="N m")

    def __post_init__(self) -> None:
        check_fields(self, ModelError)


@dataclass(frozen=True, slots=True)
class Axis:
    """An axis: what `simulate_axis` moves, and `design_cascade` tunes (`servo_axis`).

    Attributes
    ----------
    motor
        With the supply's voltage and the power stage's current as its limits.
    load
        Behind the gear.
    encoder
        On the motor's shaft.
    gear
        Ratio and efficiency.
    friction
        At the motor's shaft; its no-load current unless given.
    gap
        Backlash: how far the joint turns between the flanks, rad.
    stiffness
        Of gear and shaft at the joint, N m/rad; infinite: rigid, where there is no gap.
    max_speed
        Of the joint, rad/s; None: what the motor reaches at nine tenths of its supply.
    load_encoder
        On the joint, beside that of the motor; its counts are of a turn of the joint.

    Raises
    ------
    ModelError
        A number outside its range.
    """

    motor: DcMotor
    load: Load
    encoder: Encoder
    gear: Gear = field(default_factory=lambda: Gear(1.0))
    friction: Friction | None = None
    gap: float = parameter(0.0, meaning="backlash at the joint", unit="rad", least=0.0)
    stiffness: float = parameter(math.inf, meaning="at the joint", unit="N m/rad", above=0.0, most=math.inf)
    max_speed: float | None = None
    load_encoder: Encoder | None = None

    def __post_init__(self) -> None:
        check_fields(self, ModelError)

    @property
    def rubbing(self) -> Friction:
        """Friction of the motor's shaft."""
        if self.friction is not None:
            return self.friction
        idle = self.motor.torque_constant * self.motor.no_load_current
        return Friction(0.0, idle, idle)

    @property
    def known_friction(self) -> Friction:
        """Friction of motor and load together, at the motor's shaft, which a controller may feed forward.

        Its static ratio is that of both, weighted by their Coulomb friction, the mean of the two directions.
        """
        own, ratio, load = self.rubbing, abs(self.gear.ratio), self.load
        coulomb = load.coulomb / ratio
        both = own.coulomb_positive + own.coulomb_negative
        return Friction(
            own.viscous + load.viscous / ratio**2,
            own.coulomb_positive + coulomb,
            own.coulomb_negative + coulomb,
            1.0 + own.rise * both / (both + 2.0 * coulomb) if both > 0.0 else 1.0,
            own.stribeck_speed,
        )

    @property
    def load_inertia(self) -> float:
        """Of the load at the motor's shaft, kg m2."""
        return self.load.inertia / self.gear.ratio**2

    @property
    def rigid(self) -> bool:
        """Whether rotor and load turn as one."""
        return self.gap == 0.0 and math.isinf(self.stiffness)

    @property
    def top_speed(self) -> float:
        """Greatest speed of the motor, rad/s."""
        if self.max_speed is not None:
            return self.max_speed * abs(self.gear.ratio)
        return 0.9 * self.motor.max_voltage * self.motor.speed_gain

    def servo_axis(self) -> ServoAxis:
        """What its regulators are designed for: rotor and load as one inertia."""
        m, ratio = self.motor, abs(self.gear.ratio)
        return ServoAxis(
            resistance=m.resistance,
            inductance=m.inductance,
            torque_constant=m.torque_constant,
            back_emf_constant=m.back_emf_constant,
            inertia=m.rotor_inertia + self.load_inertia,
            max_voltage=m.max_voltage,
            max_current=m.max_current,
            max_speed=self.top_speed,
            counts_per_rev=self.encoder.counts_per_rev,
            viscous=self.rubbing.viscous + self.load.viscous / self.gear.ratio**2,
            load_inertia=self.load_inertia,
            stiffness=self.stiffness / ratio**2,
            gap=self.gap * ratio,
            load_counts=0.0 if self.load_encoder is None else self.load_encoder.counts_per_rev / ratio,
        )

    def plant(self, dt: float) -> AxisPlantParams:
        """Params of `axis_step` for a step of `dt` (s)."""
        eta, ratio, rotor, load = (
            self.gear.efficiency,
            abs(self.gear.ratio),
            self.motor.rotor_inertia,
            self.load_inertia,
        )
        mean, lost = 0.5 * (1.0 / eta + eta), 0.5 * (1.0 / eta - eta)
        reduced = rotor * load / (rotor + load)
        stiff = CONTACT * reduced / dt**2
        stiffness = min(self.stiffness / ratio**2, stiff)
        weight = mean_weight(dt / self.motor.electrical_time_constant)
        rubbing, load_viscous = self.rubbing, self.load.viscous / ratio**2
        inertia = rotor + mean * load if self.rigid else rotor
        viscous = rubbing.viscous + mean * load_viscous if self.rigid else rubbing.viscous
        return AxisPlantParams(
            dt=dt,
            armature=self.motor.armature(dt),
            torque_before=(1.0 - weight) * self.motor.torque_constant,
            torque_after=weight * self.motor.torque_constant,
            per_torque=dt / (inertia + viscous * dt),  # viscous friction of the speed after the step: always stable
            viscous=rubbing.viscous,
            coulomb_positive=rubbing.coulomb_positive,
            coulomb_negative=rubbing.coulomb_negative,
            rise=rubbing.rise,
            per_stribeck=rubbing.per_stribeck,
            load_per_torque=dt / (load if self.rigid else load + load_viscous * dt),
            load_viscous=load_viscous,
            load_coulomb=self.load.coulomb / ratio,
            rigid=self.rigid,
            half_gap=0.5 * self.gap * ratio,
            stiffness=stiffness,
            damping=2.0 * CONTACT_DAMPING * math.sqrt(stiff * reduced) if math.isinf(self.stiffness) else 0.0,
            mean=mean,
            lost=lost,
        )

    def at(self, angle: float = 0.0) -> AxisState:
        """Return its state at rest at a joint angle, rad, without current."""
        shaft = angle * self.gear.ratio
        return AxisState(0.0, 0.0, shaft, 0.0, shaft, 0.0)

"""What an arm is: frozen data, no algorithms beyond checking itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, get_args

import numpy as np

from holonom.arrays import Array
from holonom.errors import ModelError, UnknownName
from holonom.model.gravity import GRAVITY
from holonom.model.joint_kinds import kind_of
from holonom.model.limits import JointLimits

__all__ = [
    "ArmModel",
    "Body",
    "Frame",
    "Friction",
    "Joint",
    "Mimic",
    "Motor",
    "Rotors",
    "constant_transform",
]

Transform = tuple[tuple[float, ...], ...]
"""A constant 4x4 pose as nested tuples, so that a model is hashable and its repr is complete."""

Rotors = Literal["reflected", "full"]
"""What of spinning rotors counts."""

IDENTITY: Transform = ((1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0))


def constant_transform(matrix: Array | Transform) -> Transform:
    """Return a 4x4 matrix as nested tuples of floats, rounding noise below 1e-15 taken as zero.

    Raises
    ------
    ModelError
        Not a rigid transform.
    """
    T = np.array(matrix, dtype=float)
    if T.shape != (4, 4) or not np.isfinite(T).all():
        raise ModelError(f"a pose is a finite 4x4 matrix; shape {T.shape} came")
    R = T[:3, :3]
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-9 or np.linalg.det(R) < 0 or np.abs(T[3] - [0, 0, 0, 1]).max() > 0:
        raise ModelError("a pose needs a rotation matrix (R R^T = I, det R = 1) over the row 0 0 0 1")
    T[np.abs(T) < 1e-15] = 0.0
    return tuple(tuple(float(x) for x in row) for row in T)


@dataclass(frozen=True, slots=True)
class Body:
    """A link's mass (kg), centre of mass (m) and inertia about that centre (kg m2), in its link frame.

    `inertia` is (Ixx, Iyy, Izz, Ixy, Iyz, Ixz).
    """

    mass: float
    com: tuple[float, float, float]
    inertia: tuple[float, float, float, float, float, float]

    def __post_init__(self) -> None:
        if not self.mass >= 0.0:
            raise ModelError(f"mass is {self.mass} kg; it must not be negative")


@dataclass(frozen=True, slots=True)
class Motor:
    """What drives a joint. Signs: motor angle = gear_ratio * joint angle.

    Torque constant in N m/A (= back-EMF constant in V s/rad), resistance in ohm, inductance in H, inertia in kg m2
    at the motor, voltage in V, current in A.

    The rotor turns about `axis` (a unit vector) at `position`, both in the frame that carries the joint. `mass` (kg)
    and `transverse_inertia` (about the other two axes) count where the links' do not include the rotors.

    `gear_efficiency`, in (0, 1], is what simulated gears pass on, either way; a controller knows nothing of it.
    """

    gear_ratio: float
    rotor_inertia: float
    torque_constant: float = 0.0
    resistance: float = 0.0
    inductance: float = 0.0
    max_voltage: float = 0.0
    max_current: float = 0.0
    encoder_counts: int = 0
    axis: tuple[float, float, float] | None = None
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mass: float = 0.0
    transverse_inertia: float = 0.0
    gear_efficiency: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.gear_efficiency <= 1.0:
            raise ModelError(f"gear_efficiency is {self.gear_efficiency}; it must be greater than 0 and at most 1")
        if self.axis is not None and not abs(float(np.linalg.norm(self.axis)) - 1.0) < 1e-9:
            raise ModelError(f"motor axis {self.axis} is no unit vector; divide it by its length")
        if not (self.mass >= 0.0 and self.transverse_inertia >= 0.0):
            raise ModelError(f"rotor mass {self.mass} kg or inertia {self.transverse_inertia} kg m2 is negative")


@dataclass(frozen=True, slots=True)
class Friction:
    """Joint-side friction: viscous (N m s/rad) and Coulomb torque magnitudes for positive and negative speed (N m).

    With a `stribeck_speed` (rad/s) the Coulomb torques grow by `static_ratio` towards rest.
    """

    viscous: float
    coulomb_positive: float
    coulomb_negative: float
    static_ratio: float = 1.0
    stribeck_speed: float = 0.0


@dataclass(frozen=True, slots=True)
class Mimic:
    """A joint that follows joint number `joint`: q = multiplier * q_joint + offset."""

    joint: int
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class Joint:
    """`T_pi(q) = before @ motion(q) @ after`; motion turns about or slides along z.

    `kind` is one of `JOINT_KINDS` that has one freedom. `parent` is the number of the joint whose frame carries this
    one, -1 for the base; None means the one before.
    """

    name: str
    kind: str
    before: Transform = IDENTITY
    after: Transform = IDENTITY
    limits: JointLimits = JointLimits()
    motor: Motor | None = None
    friction: Friction | None = None
    parent: int | None = None
    mimic: Mimic | None = None

    def __post_init__(self) -> None:
        if not kind_of(self.kind).single:
            raise ModelError(
                f"joint {self.name!r} is {self.kind}; the joints of an arm have one freedom each: "
                "`joints_of` makes those of another kind"
            )

    @property
    def turns(self) -> bool:
        """Whether its position is an angle."""
        return kind_of(self.kind).turns

    @property
    def unit(self) -> str:
        """Of its position: rad or m."""
        return kind_of(self.kind).unit

    def scaled(self, speed: float, acceleration: float) -> Joint:
        """The joint with its speed and acceleration limits scaled by factors."""
        bounds = self.limits
        limits = replace(bounds, speed=bounds.speed * speed, acceleration=bounds.acceleration * acceleration)
        return replace(self, limits=limits)


@dataclass(frozen=True, slots=True)
class Frame:
    """A named frame fixed to a joint's frame (number `joint`, -1: the base), at `pose` in it."""

    name: str
    joint: int
    pose: Transform = IDENTITY


@dataclass(frozen=True, slots=True)
class ArmModel:
    """An arm, or a tree of joints with one tool. `base` is T_w0, `gravity` in m/s2 in the world.

    `bodies[i]` is fixed to joint i's frame, `base_body` to the base's: its mass counts where the base moves. Nothing
    holds a `floating` base (`mechanics.dynamics.floating`).

    `tip` is the number of the joint that carries the tool (the last one unless given), `tool` the tool's pose in its
    frame.

    `rotors` says what of the spinning rotors counts: "reflected" their inertia on the diagonal of B, "full" their
    coupling with what carries them and the gyroscopic moments too (every motor must state its axis then). Where
    `links_include_rotors` is false the rotors' masses and locked inertias are added to the bodies that carry them.

    `tool_frame` is the frame that the tool was read from. `no_inertia` says why there are no `bodies`, where a
    description states some that cannot be; `notes` what of a description was passed over or guessed.
    """

    name: str
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...] | None = None
    base: Transform = IDENTITY
    tool: Transform = IDENTITY
    tip: int | None = None
    frames: tuple[Frame, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -GRAVITY)
    poses: Mapping[str, tuple[float, ...]] = field(default_factory=dict, hash=False)
    card: str = ""
    rotors: Rotors = "reflected"
    links_include_rotors: bool = True
    base_body: Body | None = None
    floating: bool = False
    tool_frame: str = field(default="", compare=False)
    no_inertia: str = field(default="", compare=False)
    notes: tuple[str, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        if self.rotors not in get_args(Rotors):
            raise UnknownName("rotor model", str(self.rotors), get_args(Rotors))
        if not self.joints:
            raise ModelError(f"arm {self.name!r} has no joints")
        if self.bodies is not None and len(self.bodies) != len(self.joints):
            raise ModelError(
                f"arm {self.name!r} has {len(self.joints)} joints and {len(self.bodies)} bodies; "
                "one body per joint is needed"
            )
        for i, joint in enumerate(self.joints):
            if not -1 <= self.parent(i) < i:
                raise ModelError(
                    f"joint {joint.name!r} has parent {self.parent(i)}; a joint must come after the one that carries it"
                )
            master = None if joint.mimic is None else joint.mimic.joint
            if master is not None and (not 0 <= master < len(self.joints) or self.joints[master].mimic is not None):
                raise ModelError(f"joint {joint.name!r} mimics joint {master}, which does not move on its own")

    def parent(self, i: int) -> int:
        """Number of the joint that carries joint i, -1 for the base."""
        parent = self.joints[i].parent
        return i - 1 if parent is None else parent

    @property
    def tool_joint(self) -> int:
        """Number of the joint that carries the tool."""
        return len(self.joints) - 1 if self.tip is None else self.tip

    @property
    def tool_name(self) -> str:
        """Of the frame at which the tool is, as far as it is the one that was read; "" elsewhere."""
        here = any(
            frame.name == self.tool_frame and frame.joint == self.tool_joint and frame.pose == self.tool
            for frame in self.frames
        )
        return self.tool_frame if here else ""

    @property
    def independent(self) -> tuple[int, ...]:
        """Numbers of the joints that move on their own: the entries of q."""
        return tuple(i for i, joint in enumerate(self.joints) if joint.mimic is None)

    def limits(self, i: int) -> JointLimits:
        """Limits of independent joint i: its own, narrowed by those of the joints that follow it."""
        found = self.joints[i].limits
        for joint in self.joints:
            if joint.mimic is not None and joint.mimic.joint == i:
                found = found.leading(joint.limits, joint.mimic.multiplier, joint.mimic.offset)
        return found

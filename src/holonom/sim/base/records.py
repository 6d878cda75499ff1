"""Memory layout of a simulated base: records of parameters, of state, and of what is true each millisecond."""

from __future__ import annotations

import numpy as np

from holonom.devices import SteeringParams
from holonom.devices.encoders.kernels import EncoderParams
from holonom.devices.motors.kernels import ArmatureParams
from holonom.devices.transmission.kernels import GearParams, StictionParams
from holonom.sim.base.floor import MATERIAL
from holonom.trace.call.records import layout_of, padded
from holonom.trace.code.simd import WIDTH

__all__ = ["BODY", "BODY_SAMPLE", "BODY_STATE", "WHEEL", "WHEEL_SAMPLE", "WHEEL_STATE"]

F, I = np.float64, np.int64

WHEEL = np.dtype(
    [
        ("x", F),  # contact point, of a wheel that turns its pivot, about the centre of mass, axes of base_link, m
        ("y", F),
        ("rest_x", F),  # direction in which the contact carries the drive force, where the wheel is not turned
        ("rest_y", F),
        ("along_radius", F),  # slip along and across per wheel speed, m: r cos(gamma), -r sin(gamma)
        ("across_radius", F),
        ("reach", F),  # of the base: from its centre of mass to the farthest contact, m
        ("radius", F),
        ("largest", F),  # of the base: radius of its largest wheel
        ("gain", F),  # gear: wheel torque per motor torque, driving and driven back
        ("gain_back", F),
        ("current_slope", F),  # A s/rad that back-emf takes in a step as the motor turns faster
        ("rollers", F),  # 1 or 0: across: rollers with bearing drag, or tyre with friction
        ("roller_drag", F),  # drag over wheel load
        ("share", F),  # of the weight, and of its moments (1/m), that the wheel bears
        ("share_x", F),
        ("share_y", F),
        ("inertia", F),  # wheel and geared rotor, kg m2
        ("coupled", F),  # that a pitching body shares with it: I + N J of wheel and rotor, kg m2
        ("torque_constant", F),  # N m/A
        ("turns", F),  # 1 or 0: about its vertical axis, as a steered wheel and a castor do
        ("servo", F),  # 1 or 0: a motor turns it
        ("lever", F),  # of a castor, from its pivot to the contact, m
        ("pivot_drag", F),  # of a castor, N m s/rad
        ("steering", layout_of(SteeringParams)),
        ("armature", layout_of(ArmatureParams)),
        ("friction", layout_of(StictionParams)),
        ("gear", layout_of(GearParams)),
        ("encoder", layout_of(EncoderParams)),
    ]
)
"""One wheel with its motor."""

BODY = np.dtype(
    [(name, F) for name in ("mass", "inertia", "height", "dt")]
    + [("substeps", I)]
    + [(name, F) for name in ("com_x", "com_y", "slope_x", "slope_y", "gravity")]
)
"""The rigid body: kg, kg m2 about its centre of mass, height of that (m); step of the plant (s), steps per millisecond;
where the centre of mass is in base_link, m; gravity along the floor, in the world, and into it, m/s2."""

WHEEL_STATE = np.dtype(
    [
        ("speed", F),  # wheel, rad/s
        ("angle", F),  # wheel, rad
        ("current", F),  # A
        ("voltage", F),  # V, asked of the power stage
        ("held", F),  # by Coulomb friction, N m at the motor
        ("conducts", F),  # 1 or 0: current can flow in the motor, or its winding is open
        ("jam", F),  # kg m2 that are added to a wheel that cannot turn
        ("along_x", F),  # direction in which the contact carries the drive force; its lever arm, m
        ("along_y", F),
        ("along_arm", F),
        ("across_x", F),  # at right angles to it
        ("across_y", F),
        ("across_arm", F),
        ("turned", F),  # about its vertical axis, against the base, rad
        ("swing", F),  # how fast it turns there, against the floor, rad/s
        ("motor", F),  # where its steering motor stands, rad
        ("motor_rate", F),
        ("asked", F),  # angle asked of the steering motor, rad
        ("free", F),  # 1 or 0: the steering motor turns, or is stuck
        ("counts", F),  # 1 or 0: the encoder counts, or shows what it showed last, rad of the wheel
        ("shown", F),
        ("grips", F),  # part of the floor's grip that it has: 1, or next to none where the wheel is off
        ("moment", F),  # scratch of one step: torque on the wheel about its vertical axis, N m, and its fall with swing
        ("moment_slope", F),
        ("along", F),  # force on the base, N
        ("across", F),
        ("slip", F),  # along, m/s: rim faster than ground
        ("load", F),  # N
        ("material", MATERIAL),  # of the floor under it
        ("torque", F),  # scratch of one step: driving torque, N m
        ("effective", F),  # wheel inertia and what the motor's fall with speed adds in a step, kg m2
        ("turn", F),  # change of wheel speed in a step, rad/s
        ("along_stiffness", F),  # force per slip speed, N s/m
        ("across_stiffness", F),
        ("yielding", F),  # change of wheel speed in a step per torque, with its own slip, s/(kg m2)
    ]
)
"""State of one wheel."""

BODY_STATE = padded(
    [
        ("x", F),  # of the centre of mass
        ("y", F),
        ("theta", F),
        ("cosine", F),  # of theta; set anew each millisecond
        ("sine", F),
        ("vx", F),  # of the centre of mass along the axes of base_link, m/s; rad/s
        ("vy", F),
        ("w", F),
        ("ax", F),  # the same, m/s2 and rad/s2
        ("ay", F),
        ("aw", F),
        ("pitch", F),  # of a body that balances, forwards, rad; rad/s; rad/s2
        ("pitch_rate", F),
        ("pitch_acceleration", F),
        ("down_x", F),  # gravity along the floor, along the axes of base_link, m/s2; set anew each millisecond
        ("down_y", F),
        (
            "push_x",
            F,
        ),  # of the edges of steps, at the centre of mass: N, N, N m; work done against them, J
        ("push_y", F),
        ("push_turn", F),
        ("lifted", F),
        ("light", I),  # 1 or 0: no loads of its wheels carry it
        ("tipping", I),  # ms for which no loads of its wheels carried it, less those for which some did
        ("tipped", I),  # tick at which it fell over; 0: it stands
        ("supplied", F),  # energies since the start, J
        ("heat", F),
        ("airgap", F),
        ("drag", F),  # motor friction and gears
        ("ground", F),  # slip and rollers
        ("tick", I),  # ms since the start
        ("fault", I),  # faults that have come
        ("near", I),  # 1 or 0: whether a patch of another floor is near
    ]
)
"""State of the body, and where the clock stands."""

BODY_SAMPLE = np.dtype(
    [
        (name, F)
        for name in (
            "x", "y", "theta", "vx", "vy", "w", "ax", "ay", "supplied", "heat", "airgap", "drag", "ground", "pitch",
        )
    ]
)  # fmt: skip
"""base_link at one millisecond: pose and twist; acceleration of the centre of mass along its axes; energies; pitch."""

WHEEL_SAMPLE = np.dtype(
    [
        (name, F, (WIDTH,))
        for name in (
            "speed",
            "angle",
            "current",
            "voltage",
            "force",
            "cross_force",
            "load",
            "slip",
            "friction_limit",
            "turned",
            "asked",
        )
    ]
)
"""Four wheels at one millisecond."""

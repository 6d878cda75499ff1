"""Memory layout of a simulated base: records of parameters, of state, and of what is true each millisecond."""

from __future__ import annotations

import numpy as np

from holonom.devices.kernels import ArmatureParams, EncoderParams, FrictionParams, GearParams
from holonom.sim.base.floor import MATERIAL
from holonom.trace.call.records import layout_of, padded
from holonom.trace.code.simd import WIDTH

__all__ = ["BODY", "BODY_SAMPLE", "BODY_STATE", "WHEEL", "WHEEL_SAMPLE", "WHEEL_STATE"]

F, I = np.float64, np.int64

WHEEL = np.dtype(
    [
        ("x", F),  # contact point about the centre of mass, along the axes of base_link, m
        ("y", F),
        ("along_x", F),  # direction in which the contact carries the drive force; its lever arm, m
        ("along_y", F),
        ("along_arm", F),
        ("across_x", F),  # at right angles to it
        ("across_y", F),
        ("across_arm", F),
        ("along_radius", F),  # slip along and across per wheel speed, m: r cos(gamma), -r sin(gamma)
        ("across_radius", F),
        ("reach", F),  # of the base: from its centre of mass to the farthest contact, m
        ("gain", F),  # gear: wheel torque per motor torque, driving and driven back
        ("gain_back", F),
        ("current_slope", F),  # A s/rad that back-emf takes in a step as the motor turns faster
        ("rollers", F),  # 1 or 0: across: rollers with bearing drag, or tyre with friction
        ("roller_drag", F),  # drag over wheel load
        ("share", F),  # of the weight, and of its moments (1/m), that the wheel bears
        ("share_x", F),
        ("share_y", F),
        ("inertia", F),  # wheel and geared rotor, kg m2
        ("torque_constant", F),  # N m/A
        ("armature", layout_of(ArmatureParams)),
        ("friction", layout_of(FrictionParams)),
        ("gear", layout_of(GearParams)),
        ("encoder", layout_of(EncoderParams)),
    ]
)
"""One driven wheel with its motor."""

BODY = np.dtype([("mass", F), ("inertia", F), ("height", F), ("dt", F), ("substeps", I), ("com_x", F), ("com_y", F)])
"""The rigid body: kg, kg m2 about its centre of mass, height of that (m); step of the plant (s), steps per millisecond;
where the centre of mass is in base_link, m."""

WHEEL_STATE = np.dtype(
    [
        ("speed", F),  # wheel, rad/s
        ("angle", F),  # wheel, rad
        ("current", F),  # A
        ("voltage", F),  # V, asked of the power stage
        ("conducts", F),  # 1 or 0: current can flow in the motor, or its winding is open
        ("jam", F),  # kg m2 that are added to a wheel that cannot turn
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
"""State of one driven wheel."""

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
            "x", "y", "theta", "vx", "vy", "w", "ax", "ay", "supplied", "heat", "airgap", "drag", "ground",
        )
    ]
)  # fmt: skip
"""base_link at one millisecond: pose and twist; acceleration of the centre of mass along its axes; energies."""

WHEEL_SAMPLE = np.dtype(
    [
        (name, F, (WIDTH,))
        for name in ("speed", "angle", "current", "voltage", "force", "cross_force", "load", "slip", "friction_limit")
    ]
)
"""Four wheels at one millisecond."""

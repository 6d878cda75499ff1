"""Memory layout of a simulated base: records of parameters, of state, and of what is logged each millisecond."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from holonom.sim.arm.records import AXIS
from holonom.sim.base.floor import MATERIAL
from holonom.trace.simd import WIDTH

__all__ = [
    "BODY",
    "BODY_GROUPS",
    "BODY_SAMPLE",
    "BODY_STATE",
    "FLAGGED",
    "HELD",
    "LOST",
    "STATUS",
    "WHEEL",
    "WHEEL_SAMPLE",
    "WHEEL_STATE",
    "aligned_records",
    "side_by_side",
]

F = np.float64

CACHE_LINE = 64


def _padded(fields: list[tuple[str, Any]]) -> np.dtype[np.void]:
    """Record of whole cache lines: the compiled step takes a quarter longer where fields lie across them."""
    plain = np.dtype(fields)
    spare = -plain.itemsize % CACHE_LINE // 8
    return np.dtype([*fields, ("spare", F, (spare,))]) if spare else plain


def aligned_records(rows: Any, dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Copy rows, as `np.array` takes them or fewer fields, into records that begin at a cache line."""
    buffer = np.zeros(len(rows) * dtype.itemsize + CACHE_LINE, np.uint8)
    first = -buffer.ctypes.data % CACHE_LINE
    records: NDArray[np.void] = buffer[first : first + len(rows) * dtype.itemsize].view(dtype)
    for record, row in zip(records, rows, strict=True):
        for name, value in zip(dtype.names or (), row, strict=False):
            record[name] = value
    return records


def side_by_side(rows: NDArray[np.void], **filling: float) -> NDArray[np.void]:
    """Lay records side by side, four in one, for `trace.simd.packed`.

    The last row is repeated until the four are full, with other values of the fields in `filling`.
    """
    count = -(-len(rows) // WIDTH)
    blocks = aligned_records([()] * count, _in_lanes(rows.dtype))
    _lay(blocks, rows[np.minimum(np.arange(count * WIDTH), len(rows) - 1)].reshape(count, WIDTH))
    for name, value in filling.items():
        blocks[name].flat[len(rows) :] = value
    return blocks


def _in_lanes(dtype: np.dtype[np.void]) -> np.dtype[np.void]:
    """A record of four records: each number is an array (4,)."""
    return np.dtype(
        [(name, _in_lanes(dtype[name]) if dtype[name].names else (dtype[name], (WIDTH,))) for name in dtype.names or ()]
    )


def _lay(blocks: NDArray[np.void], rows: NDArray[np.void]) -> None:
    for name in rows.dtype.names or ():
        if rows.dtype[name].names:
            _lay(blocks[name], rows[name])
        else:
            blocks[name] = rows[name]


WHEEL = np.dtype(
    [
        ("x", F),  # contact point in base_link, m
        ("y", F),
        ("along_x", F),  # direction in which the contact carries the drive force; its lever arm, m
        ("along_y", F),
        ("along_arm", F),
        ("across_x", F),  # at right angles to it
        ("across_y", F),
        ("across_arm", F),
        ("along_radius", F),  # slip along and across per wheel speed, m: r cos(gamma), -r sin(gamma)
        ("across_radius", F),
        ("rim_x", F),  # row of D: rim speed (m/s) per (vx, vy, w)
        ("rim_y", F),
        ("rim_turn", F),
        ("radius", F),
        ("reach", F),  # of the base: from its origin to the farthest contact, m
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
        ("armature", AXIS["armature"]),
        ("friction", AXIS["friction"]),
        ("gear", AXIS["gear"]),
        ("encoder", AXIS["encoder"]),
        ("tracking", AXIS["tracking"]),
        ("speed_loop", AXIS["speed"]),
    ]
)
"""One driven wheel with its motor."""

BODY = np.dtype([("mass", F), ("inertia", F), ("height", F), ("dt", F), ("substeps", np.int64)])
"""The rigid body: kg, kg m2, height of its centre of mass (m); step of the plant (s), steps per millisecond."""

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
        ("count", np.int64),  # what the controller knows: counter, observer (motor side)
        ("counted", F),  # motor angle at the middle of the count, rad
        ("seen_angle", F),
        ("seen_speed", F),
        ("seen_load", F),
        ("integral", F),  # of the speed loop, A
        ("current_reference", F),
        ("rim_reference", F),  # m/s
        ("rim", F),  # measured rim speed, m/s
        ("measured_current", F),
        ("modelled_current", F),
        ("open", F),  # s for which no current flowed where there must be some
        ("stuck", F),  # s for which it stood where it must not
        ("lost", np.int64),  # what the watch says: WORKS, OPEN, JAMMED
        ("works", F),  # 1 or 0: it is driven, or lost
        ("force_x", F),  # rim force (N) that is asked of it per (N, N, N m) on the base
        ("force_y", F),
        ("force_turn", F),
        ("cut", F),  # traction control: part of the drive force that is left, 0 to 1
    ]
)
"""State of one driven wheel: plant first, then its controller."""

BODY_STATE = _padded(
    [
        ("x", F),
        ("y", F),
        ("theta", F),
        ("cosine", F),  # of theta; set anew each millisecond
        ("sine", F),
        ("vx", F),  # base_link, m/s and rad/s
        ("vy", F),
        ("w", F),
        ("ax", F),  # of the centre, in base_link, m/s2
        ("ay", F),
        ("supplied", F),  # energies since the start, J
        ("heat", F),
        ("airgap", F),
        ("drag", F),  # motor friction and gears
        ("ground", F),  # slip and rollers
        ("seen_x", F),  # estimates
        ("seen_y", F),
        ("seen_theta", F),
        ("seen_vx", F),
        ("seen_vy", F),
        ("seen_w", F),
        ("gyro_bias", F),
        ("command_vx", F),
        ("command_vy", F),
        ("command_w", F),
        ("integral_x", F),  # of the pose error, world frame, m s
        ("integral_y", F),
        ("integral_theta", F),
        ("status", np.int64),  # of the slip detector
        ("flagged", np.int64),
    ]
)
"""State of the body, of the estimator and of the path keeping."""

WHEEL_SAMPLE = np.dtype(
    [
        ("count", np.int64, (WIDTH,)),
        *(
            (name, F, (WIDTH,))
            for name in (
                "angle",
                "speed",
                "measured_speed",
                "reference_speed",
                "current",
                "measured_current",
                "voltage",
                "force",
                "cross_force",
                "load",
                "slip",
                "friction_limit",
            )
        ),
    ]
)
"""Four wheels at one millisecond."""

BODY_GROUPS = {
    "pose": ("x", "y", "theta"),
    "twist": ("vx", "vy", "w"),
    "estimated_pose": ("seen_x", "seen_y", "seen_theta"),
    "estimated_twist": ("seen_vx", "seen_vy", "seen_w"),
    "reference_pose": ("ref_x", "ref_y", "ref_theta"),
    "reference_twist": ("ref_vx", "ref_vy", "ref_w"),
    "rate": ("rate",),
    "gyro": ("gyro",),
    "acceleration": ("imu_x", "imu_y"),
    "energy": ("supplied", "heat", "airgap", "drag", "ground"),
}
"""Neighbouring numbers of `BODY_SAMPLE` that make one array of the log."""

BODY_SAMPLE = np.dtype([(name, F) for group in BODY_GROUPS.values() for name in group])
"""The body at one millisecond; every field has 8 bytes."""

STATUS, FLAGGED, LOST, HELD = 0, 1, 2, 3
"""Columns of what the controller says each millisecond, (N, 4) integers: status of the slip detector; wheels that slip,
motors that are lost, those of them that are jammed: sets, bit i for wheel i."""

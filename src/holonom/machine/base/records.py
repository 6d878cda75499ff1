"""Memory layout of a base's controller: what it knows of each wheel, what it remembers, what it says."""

from __future__ import annotations

import numpy as np

from holonom.control.path_laws.compiled import NUMBERS
from holonom.control.servo.kernels import SpeedParams
from holonom.devices.encoders.kernels import EncoderParams, TrackingParams
from holonom.devices.motors.kernels import ArmatureParams
from holonom.devices.transmission.kernels import FrictionParams, GearParams
from holonom.mobile.drive.slip_kernels import SlipState
from holonom.trace.call.records import layout_of, padded

__all__ = ["CONTROL_SAMPLE", "CONTROL_STATE", "KNOWN_WHEEL", "SEEN_WHEEL", "SEEN_WHEEL_SAMPLE"]

F, I = np.float64, np.int64

KNOWN_WHEEL = np.dtype(
    [
        ("rim_x", F),  # row of D: rim speed (m/s) per (vx, vy, w)
        ("rim_y", F),
        ("rim_turn", F),
        ("radius", F),
        ("roller_cosine", F),  # of the angle at which its rollers push; 1 of other wheels
        ("max_force", F),  # N that it is asked for, along its rim
        ("inertia", F),  # wheel and geared rotor, kg m2
        ("torque_constant", F),  # N m/A
        ("armature", layout_of(ArmatureParams)),
        ("friction", layout_of(FrictionParams)),
        ("gear", layout_of(GearParams)),
        ("encoder", layout_of(EncoderParams)),
        ("tracking", layout_of(TrackingParams)),
        ("speed_loop", layout_of(SpeedParams)),
    ]
)
"""What the controller knows of one driven wheel and its motor: data sheets, gains."""

SEEN_WHEEL = np.dtype(
    [
        ("voltage", F),  # V, asked of the power stage
        ("count", I),  # extended counter
        ("counted", F),  # motor angle at the middle of the count, rad
        ("seen_angle", F),  # observer, motor side
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
        ("blind", F),  # s for which it turned and was not counted
        ("lost", I),  # what the watch says: WORKS, OPEN, JAMMED, BLIND, OFF
        ("works", F),  # 1 or 0: it is driven, or lost
        ("force_x", F),  # rim force (N) that is asked of it per (N, N, N m) on the base
        ("force_y", F),
        ("force_turn", F),
        ("cut", F),  # traction control: part of the drive force that is left, 0 to 1
        ("asked", F),  # rim force (N) that was asked of it, and what its current pushes beside turning it
        ("pushed", F),
        ("slips_for", F),  # s for which it slips and pushes nothing
        ("idle_ahead", F),  # s for which it pushed nothing while asked to push ahead, and back
        ("idle_back", F),
    ]
)
"""What the controller remembers of one driven wheel."""

CONTROL_STATE = padded(
    [
        ("seen_x", F),  # estimates; poses in odom, twists in base_link
        ("seen_y", F),
        ("seen_theta", F),
        ("seen_vx", F),
        ("seen_vy", F),
        ("seen_w", F),
        ("gyro_bias", F),
        ("skid_vx", F),  # of wheels that skid: by the balance of their friction
        ("skid_vy", F),
        ("skid_lean", F),  # rad, mean of the way that it goes against that which it looks
        ("skid_more", F),  # part by which its wheels have to turn more than its effective track says
        ("command_vx", F),
        ("command_vy", F),
        ("command_w", F),
        ("law", np.dtype((F, (NUMBERS,)))),  # numbers in and out of the path's law, and its memory
        ("integral_x", F),  # of the pose error, odom, m s
        ("integral_y", F),
        ("integral_theta", F),
        ("status", I),  # of the slip detector
        ("flagged", I),  # wheels that slip: a set, bit i for wheel i, as all sets here
        ("named", I),  # those of them that estimate and allocation go by
        ("dead", I),  # motors that are lost
        ("jams", I),  # those of them that are jammed
        ("blind", I),  # those whose encoders do not count
        ("loose", I),  # those whose wheels push nothing
        ("lodged", I),  # steering motors that are stuck: a set of the base's wheels
        ("astray", I),  # 1: a steering motor is not yet where it is asked to be
        ("known_lodged", I),  # those of them that it goes by
        ("pinned", I),  # 1: the path is kept with one that is stuck, and the base turns about it
        ("crippled", I),  # 1: what is left does not drive it
        ("check_vx", F),  # velocity by inertia, m/s, zeros of the accelerometers, m/s2
        ("check_vy", F),
        ("check_zero_x", F),
        ("check_zero_y", F),
        ("check_since", F),  # s for which no wheel agrees with it
        ("check_raised", I),  # samples that speak for slip
        ("unwatched", I),  # samples since it was looked at what wheels push
        ("lame", I),  # 1: the motors that are left cannot push every way
        ("unseen_x", F),  # then the twist that turns no wheel which is left
        ("unseen_y", F),
        ("unseen_turn", F),
        ("steady", I),  # 1: nothing slips, and the slip detector need not be asked
        ("mode", I),
        ("ended", I),  # how the path ended: RUNNING, DONE, STOPPED
        ("phase", F),  # on the path, samples
        ("rate", F),  # part of its speed at which the path is driven
        ("goal", F),  # what the rate goes to
        ("stood", I),  # samples for which the base had to stand
        ("hold_x", F),  # pose that is held
        ("hold_y", F),
        ("hold_theta", F),
        ("wanted_vx", F),  # twist that was asked for, and how long ago (samples)
        ("wanted_vy", F),
        ("wanted_w", F),
        ("age", I),
        ("shaped_vx", F),  # the same within limits of speed, acceleration and jerk
        ("shaped_vy", F),
        ("shaped_w", F),
        ("shaped_ax", F),
        ("shaped_ay", F),
        ("shaped_aw", F),
        ("stands", I),  # 1: it has stood since it was placed, and has not been told to move
        ("rests", I),  # samples for which it did
        ("rise_x", F),  # what accelerometers show of a slope, odom, m/s2: found where it stood at the start
        ("rise_y", F),
        ("slope_x", F),  # the same along the axes of base_link
        ("slope_y", F),
        ("gyro", F),  # last measured, rad/s and m/s2
        ("raw_x", F),
        ("raw_y", F),
        ("imu_x", F),  # the same less the slope
        ("imu_y", F),
        ("seen_pitch", F),  # estimate of a body that balances: pitch, its rate, the gyro's zero, speed along the way
        ("seen_pitch_rate", F),
        ("pitch_bias", F),
        ("seen_along", F),
        ("led", F),  # speed that it is led to while it follows velocities, and its changes
        ("led_rate", F),
        ("led_change", F),
        ("led_jerk", F),
        ("led_turn", F),  # the same of its turning rate
        ("led_turn_rate", F),
        ("led_turn_change", F),
        ("trim", F),  # what the rest of its pitch is off, rad
        ("ahead_of", F),  # how far it is ahead of where it was to be, m
        ("ref_x", F),  # reference of this sample
        ("ref_y", F),
        ("ref_theta", F),
        ("ref_vx", F),
        ("ref_vy", F),
        ("ref_w", F),
        ("ref_rate", F),
        ("slip", layout_of(SlipState)),
    ]
)
"""What the controller remembers of the base: estimate, path, findings."""

CONTROL_SAMPLE = np.dtype(
    [
        (name, F)
        for name in (
            "seen_x", "seen_y", "seen_theta", "seen_vx", "seen_vy", "seen_w", "ref_x", "ref_y", "ref_theta", "ref_vx",
            "ref_vy", "ref_w", "ref_rate", "gyro", "imu_x", "imu_y", "status", "flagged", "dead", "jams", "blind",
            "loose", "lodged", "pinned", "crippled", "seen_pitch",
        )
    ]
)  # fmt: skip
"""What the controller says each millisecond; fields of `CONTROL_STATE`, each of 8 bytes."""

SEEN_WHEEL_SAMPLE = ("measured_speed", "reference_speed", "measured_current", "count")
"""What it says of each wheel: rad/s, rad/s, A, counts."""

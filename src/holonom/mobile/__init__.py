"""Mobile bases: wheels, what drives them, slip and failed motors, odometry and its calibration (specification 06).

Twists are (vx, vy, w) in base_link, x forwards and y to the left; poses (x, y, theta) of base_link in the world.

Wheels and bases
    `Wheel`, `WheelBase`; arrangements by name: `differential`, `tricycle`, `bicycle`, `ackermann`, `dual_ackermann`,
    `skid_steer`, `rocker6`, `segway`, `synchro`, `omni`, `mecanum`, `swerve`, `sphere`; `mobility`,
    `degrees_of_freedom`, `is_holonomic`, `conflicting_wheels`; `centre_of_rotation`, `twist_about`,
    `centre_of_twist`, `centre_of_axles`, `castor_rates`, `castor_twist`; `wheel_rates` (second order).
    `load_base` reads wheels from a URDF or xacro file, `base_urdf` writes one.
Standing and tipping over
    `support_polygon`, `static_margin`, `zero_moment_point`, `dynamic_margin`, `acceleration_limit`, `lateral_limit`,
    `turning_speed`, `wheel_loads`; `footprint`, what it covers of the floor.
Motion in the plane
    `poses`: exact arcs, composition, twists in robot and world; `curves`: Dubins and Reeds-Shepp curves; `towed`:
    trailers along poses.
What drives a base
    `BaseDrive` (data sheets of motor, gear, encoder of its wheels), `BaseSensors` (how its sensors err).
Omni drives
    `Coupling`, `rim_speeds`, `base_twist`, `wheel_forces`, `base_acceleration`; `idle_patterns`, `split_pattern`;
    `effective_motors`, `force_envelope`, `acceleration_envelope`, `speed_envelope`, `critical_force`, `drive_limits`.
As fast as it can
    `speed_profile`: the fastest along a path that motors, floor and steering allow.
Faults
    `detect_slip` (status, wheel, twist without it); `redistribute`, `allocation`, `actuation`, `possible_twists` with
    motors out.
Odometry
    `odometry`: wheel increments to motion, covariance, what is wrong with a log; `calibration`: UMBmark, least squares.
"""

from holonom.mobile import curves, poses
from holonom.mobile.arrangements import (
    ackermann,
    ackermann_steering,
    bicycle,
    differential,
    dual_ackermann,
    mecanum,
    omni,
    rocker6,
    segway,
    skid_steer,
    sphere,
    swerve,
    synchro,
    tricycle,
)
from holonom.mobile.base.castors import CastorRates, castor_rates, castor_twist
from holonom.mobile.base.centre import (
    Centre,
    axle_miss,
    centre_of_axles,
    centre_of_rotation,
    centre_of_twist,
    twist_about,
)
from holonom.mobile.base.mobility import (
    Mobility,
    conflicting_wheels,
    degrees_of_freedom,
    is_holonomic,
    mobility,
)
from holonom.mobile.base.second_order import WheelRates, wheel_rates
from holonom.mobile.base.wheel import KINDS, Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.drive.base_drive import BaseDrive, BaseSensors
from holonom.mobile.drive.coupling import (
    Coupling,
    base_acceleration,
    base_force,
    base_twist,
    omni_coupling,
    rim_speeds,
    wheel_forces,
)
from holonom.mobile.drive.envelopes import (
    Envelope,
    Limit,
    acceleration_envelope,
    critical_force,
    effective_motors,
    force_envelope,
    speed_envelope,
)
from holonom.mobile.drive.failed_motor import (
    Actuation,
    Reach,
    Redistribution,
    actuation,
    allocation,
    feasible_twist,
    possible_twists,
    redistribute,
)
from holonom.mobile.drive.limits import DriveLimits, drive_limits
from holonom.mobile.drive.patterns import PatternParts, copper_loss, idle_patterns, readable_patterns, split_pattern
from holonom.mobile.drive.slip import SlipReport, SlipSettings, SlipStatus, detect_slip, separable_wheels
from holonom.mobile.drive.speed_profile import SpeedProfile, speed_profile
from holonom.mobile.footprint import footprint
from holonom.mobile.methods import ARRANGEMENTS, LOCALISERS, SLIP_DETECTORS, arrangement
from holonom.mobile.stability import (
    acceleration_limit,
    contact_points,
    dynamic_margin,
    lateral_limit,
    static_margin,
    support_polygon,
    turning_speed,
    wheel_loads,
    zero_moment_point,
)
from holonom.mobile.trailers import Towed, towed

__all__ = [
    "ARRANGEMENTS",
    "KINDS",
    "LOCALISERS",
    "SLIP_DETECTORS",
    "Actuation",
    "BaseDrive",
    "BaseSensors",
    "CastorRates",
    "Centre",
    "Coupling",
    "DriveLimits",
    "Envelope",
    "Limit",
    "Mobility",
    "PatternParts",
    "Reach",
    "Redistribution",
    "SlipReport",
    "SlipSettings",
    "SlipStatus",
    "SpeedProfile",
    "Towed",
    "Wheel",
    "WheelBase",
    "WheelRates",
    "acceleration_envelope",
    "acceleration_limit",
    "ackermann",
    "ackermann_steering",
    "actuation",
    "allocation",
    "arrangement",
    "axle_miss",
    "base_acceleration",
    "base_force",
    "base_twist",
    "bicycle",
    "castor_rates",
    "castor_twist",
    "centre_of_axles",
    "centre_of_rotation",
    "centre_of_twist",
    "conflicting_wheels",
    "contact_points",
    "copper_loss",
    "critical_force",
    "curves",
    "degrees_of_freedom",
    "detect_slip",
    "differential",
    "drive_limits",
    "dual_ackermann",
    "dynamic_margin",
    "effective_motors",
    "feasible_twist",
    "footprint",
    "force_envelope",
    "idle_patterns",
    "is_holonomic",
    "lateral_limit",
    "mecanum",
    "mobility",
    "omni",
    "omni_coupling",
    "poses",
    "possible_twists",
    "readable_patterns",
    "redistribute",
    "rim_speeds",
    "rocker6",
    "segway",
    "separable_wheels",
    "skid_steer",
    "speed_envelope",
    "speed_profile",
    "sphere",
    "split_pattern",
    "static_margin",
    "support_polygon",
    "swerve",
    "synchro",
    "towed",
    "tricycle",
    "turning_speed",
    "twist_about",
    "wheel_forces",
    "wheel_loads",
    "wheel_rates",
    "zero_moment_point",
]

"""Motors, gears, friction and encoders: what sits behind a joint (specification 03).

Data sheets, validated, each with a verb that makes the params of its compiled step:

======================  ========================================================================
`DcMotor`               armature, constants, limits; `A_M`, `A_T`, `T_M`, `T_V`, damping
`MotorSheet`            what a vendor prints; `check_sheet`: does it agree with itself
`ThermalModel`          winding and housing: duty, time to a limit, largest continuous current
`Gear`                  signed ratio, efficiency
`Friction`              viscous and asymmetric Coulomb
`LuGre`                 bristles: stick-slip, presliding, Stribeck
`Encoder`               counts, longest read interval; `tracking_params` for the speed observer
`SteeringMotor`         how fast, hard and exactly a wheel is steered
`Gyro`                  noise and offset; `Accelerometer` and `CurrentShunt` too
======================  ========================================================================

`DEVICES` lists those between motor and joint, `MOTORS` motors that can be bought (`motor_card`).

Compiled steps over scalars (`kernels.py` of each room), for a loop that keeps the state of its axes in rows of numbers:

======================  ========================================================================
`armature_step`         voltage and speed to current, exact between samples
`thermal_step`          current to temperatures of winding and housing, exact
`stiction_step`         friction of a simulated shaft, which holds at standstill
`lugre_step`            friction of bristles, integrated exactly
`friction_torque`       friction as a controller feeds it forward, by speed alone
`gear_torque`           motor torque to joint torque
`encoder_counter`       motor angle to the 16-bit counter
`extend_counter`        16-bit reads to a 64-bit count
`count_angle`           count to motor angle
`difference_speed`      M method: counts in an interval to speed
`tracking_step`         observer: angle, speed and load from each read
======================  ========================================================================
"""

from holonom.devices.encoders.incremental import Encoder, tracking_params
from holonom.devices.encoders.kernels import (
    EncoderParams,
    TrackingParams,
    TrackingState,
    count_angle,
    difference_speed,
    encoder_counter,
    extend_counter,
    tracking_step,
)
from holonom.devices.methods import DEVICES
from holonom.devices.motors.catalogue import MOTORS, MotorCard, motor_card
from holonom.devices.motors.data_sheet import MotorSheet
from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.motors.kernels import ArmatureParams, armature_step
from holonom.devices.motors.sheet_check import Finding, SheetCheck, check_sheet
from holonom.devices.motors.thermal import Temperatures, ThermalModel, ThermalParams, thermal_step
from holonom.devices.sensors import Accelerometer, CurrentShunt, Gyro
from holonom.devices.steering import SteeringMotor, SteeringParams
from holonom.devices.transmission.friction import Friction
from holonom.devices.transmission.gear import Gear
from holonom.devices.transmission.kernels import (
    FrictionParams,
    GearParams,
    LuGreParams,
    StictionParams,
    friction_torque,
    gear_torque,
    lugre_step,
    stiction_step,
)
from holonom.devices.transmission.lugre import LuGre

__all__ = [
    "DEVICES",
    "MOTORS",
    "Accelerometer",
    "ArmatureParams",
    "CurrentShunt",
    "DcMotor",
    "Encoder",
    "EncoderParams",
    "Finding",
    "Friction",
    "FrictionParams",
    "Gear",
    "GearParams",
    "Gyro",
    "LuGre",
    "LuGreParams",
    "MotorCard",
    "MotorSheet",
    "SheetCheck",
    "SteeringMotor",
    "SteeringParams",
    "StictionParams",
    "Temperatures",
    "ThermalModel",
    "ThermalParams",
    "TrackingParams",
    "TrackingState",
    "armature_step",
    "check_sheet",
    "count_angle",
    "difference_speed",
    "encoder_counter",
    "extend_counter",
    "friction_torque",
    "gear_torque",
    "lugre_step",
    "motor_card",
    "stiction_step",
    "thermal_step",
    "tracking_params",
    "tracking_step",
]

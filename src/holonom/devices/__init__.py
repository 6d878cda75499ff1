"""Motors, gears, friction and encoders: what sits behind a joint (specification 03).

Data sheets, validated, each with a verb that makes the params of its compiled step:

======================  ========================================================================
`DcMotor`               armature, constants, limits; `A_M`, `A_T`, `T_M`, `T_V`, damping
`MotorSheet`            what a vendor prints; `check_sheet`: does it agree with itself
`Pmsm`                  synchronous or brushless; `FieldOrientation` and `SixStep` drive it, `run_pmsm` runs it
`Stepper`               microsteps, resonance, lost steps (`run_stepper`)
`InductionMotor`        Kloss' characteristic; `InductionMachine` in space vectors
`SwitchedReluctance`    its switching angles, by speed and current (`check_angles`, `run_reluctance`)
`Cogging`               torque of the slots, and the dead band that it makes
`ThermalModel`          winding and housing: duty, time to a limit, largest continuous current
`PwmBridge`             ripple, dead time; `Supply` sags; `CurrentLimiter` with a dead band
`Gear`                  signed ratio, efficiency
`Friction`              viscous and asymmetric Coulomb
`LuGre`                 bristles: stick-slip, presliding, Stribeck
`Encoder`               counts, longest read interval; `tracking_params` for the speed observer
`SteeringMotor`         how fast, hard and exactly a wheel is steered
`Gyro`                  noise and offset; `Accelerometer` and `CurrentShunt` too
======================  ========================================================================

`select_drive` ranks motors and gears for a `LoadCycle`. `DEVICES` lists devices, `MOTORS` motors that can be bought
(`motor_card`).

Compiled steps over scalars (`kernels.py` of each room), for a loop that keeps the state of its axes in rows of numbers:

======================  ========================================================================
`armature_step`         voltage and speed to current, exact between samples
`pmsm_step`             dq voltages and speed to dq currents, exact
`field_step`            regulators of the field orientation
`six_step_step`         current of the conducting pair
`stepper_step`          rotor on its field
`induction_step`        fluxes and torque, exact
`reluctance_step`       flux of a phase
`bridge_voltage`        voltage asked for to voltage at the motor
`supply_step`           voltage of the DC link, exact
`limiter_voltage`       what a current limiter leaves of a voltage
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
from holonom.devices.motors.angle_check import check_angles
from holonom.devices.motors.catalogue import MOTORS, MotorCard, motor_card
from holonom.devices.motors.cogging import Cogging, CoggingParams, DeadBand, cogging_torque
from holonom.devices.motors.data_sheet import MotorSheet
from holonom.devices.motors.dc_motor import DcMotor
from holonom.devices.motors.field_orientation import (
    FieldOrientation,
    FieldParams,
    FieldState,
    PmsmRun,
    field_reference,
    field_step,
    run_pmsm,
)
from holonom.devices.motors.induction import (
    InductionMachine,
    InductionMotor,
    InductionParams,
    InductionState,
    induction_step,
)
from holonom.devices.motors.kernels import ArmatureParams, armature_step
from holonom.devices.motors.pmsm import Dq, Pmsm, PmsmParams, pmsm_step, pmsm_torque
from holonom.devices.motors.reluctance import (
    AngleTable,
    ReluctanceCycle,
    ReluctanceParams,
    ReluctanceRun,
    SwitchedReluctance,
    reluctance_cycle,
    reluctance_on,
    reluctance_step,
    reluctance_torque,
    run_reluctance,
)
from holonom.devices.motors.sheet_check import Finding, SheetCheck, check_sheet
from holonom.devices.motors.six_step import SixStep, SixStepParams, hall_sector, six_step_step, six_step_torque
from holonom.devices.motors.stepper import (
    Stepper,
    StepperParams,
    StepperRun,
    StepperState,
    run_stepper,
    stepper_step,
    stepper_torque,
)
from holonom.devices.motors.thermal import Temperatures, ThermalModel, ThermalParams, thermal_step
from holonom.devices.power.bridge import BridgeParams, PwmBridge, bridge_voltage
from holonom.devices.power.limiter import CurrentLimiter, LimiterParams, limiter_voltage
from holonom.devices.power.supply import Supply, SupplyParams, supply_step
from holonom.devices.sensors import Accelerometer, CurrentShunt, Gyro
from holonom.devices.sizing.cycle import LoadCycle, best_ratio
from holonom.devices.sizing.selection import Choice, GearChoice, Rejection, SizingLimits, select_drive
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
    "AngleTable",
    "ArmatureParams",
    "BridgeParams",
    "Choice",
    "Cogging",
    "CoggingParams",
    "CurrentLimiter",
    "CurrentShunt",
    "DcMotor",
    "DeadBand",
    "Dq",
    "Encoder",
    "EncoderParams",
    "FieldOrientation",
    "FieldParams",
    "FieldState",
    "Finding",
    "Friction",
    "FrictionParams",
    "Gear",
    "GearChoice",
    "GearParams",
    "Gyro",
    "InductionMachine",
    "InductionMotor",
    "InductionParams",
    "InductionState",
    "LimiterParams",
    "LoadCycle",
    "LuGre",
    "LuGreParams",
    "MotorCard",
    "MotorSheet",
    "Pmsm",
    "PmsmParams",
    "PmsmRun",
    "PwmBridge",
    "Rejection",
    "ReluctanceCycle",
    "ReluctanceParams",
    "ReluctanceRun",
    "SheetCheck",
    "SixStep",
    "SixStepParams",
    "SizingLimits",
    "SteeringMotor",
    "SteeringParams",
    "Stepper",
    "StepperParams",
    "StepperRun",
    "StepperState",
    "StictionParams",
    "Supply",
    "SupplyParams",
    "SwitchedReluctance",
    "Temperatures",
    "ThermalModel",
    "ThermalParams",
    "TrackingParams",
    "TrackingState",
    "armature_step",
    "best_ratio",
    "bridge_voltage",
    "check_angles",
    "check_sheet",
    "cogging_torque",
    "count_angle",
    "difference_speed",
    "encoder_counter",
    "extend_counter",
    "field_reference",
    "field_step",
    "friction_torque",
    "gear_torque",
    "hall_sector",
    "induction_step",
    "limiter_voltage",
    "lugre_step",
    "motor_card",
    "pmsm_step",
    "pmsm_torque",
    "reluctance_cycle",
    "reluctance_on",
    "reluctance_step",
    "reluctance_torque",
    "run_pmsm",
    "run_reluctance",
    "run_stepper",
    "select_drive",
    "six_step_step",
    "six_step_torque",
    "stepper_step",
    "stepper_torque",
    "stiction_step",
    "supply_step",
    "thermal_step",
    "tracking_params",
    "tracking_step",
]

"""Motors, gears, friction and encoders: what sits behind a joint (specification 03).

Data sheets, validated, each with a verb that makes the params of its compiled step:

======================  ========================================================================
`DcMotor`               armature, constants, limits; `A_M`, `A_T`, `T_M`, `T_V`, damping
`MotorSheet`            what a vendor prints; `check_sheet`: does it agree with itself
`Pmsm`                  synchronous or brushless; `FieldOrientation` and `SixStep` drive it, `run_pmsm` runs it
`Stepper`               microsteps, resonance, lost steps
`InductionMotor`        Kloss' characteristic; `InductionMachine` in space vectors
`SwitchedReluctance`    its switching angles, by speed and current; `check_angles`
`Cogging`               torque of the slots, and the dead band that it makes
`ThermalModel`          winding and housing: duty, time to a limit, largest continuous current
`Brake`                 holds without power, with its delays
`PwmBridge`             ripple, dead time; `Supply` sags; `CurrentLimiter` with a dead band
`Gear`                  signed ratio, efficiency
`HarmonicDrive`         ratio by its teeth, stiffness in pieces, ripple
`Backlash`              gap that a load floats in, its describing function; a preloaded pair
`DeadZone`              its inverse, and what a tachometer loop leaves of it
`TwoMass`               motor and load on an elastic shaft: resonance, antiresonance, exact step
`Friction`              viscous and asymmetric Coulomb, Stribeck's curve
`LuGre`                 bristles: stick-slip, presliding, Stribeck
`Encoder`               counts, longest read interval; `tracking_params` for the speed observer
`QuadratureEncoder`     lines, decoding; every edge, with `line_faults`; `LINE_RECEIVERS`, `Counter`
`IndexCorrection`       what the index finds lost; `HOMINGS`: ways to find the zero
`SinCosEncoder`         1 Vpp signals with their errors, `fit_heydemann` against them
`FRAMES`                kinds of `encode_frame`, `decode_frame`; `SPEED_METHODS`: ways to a speed
`SteeringMotor`         how fast, hard and exactly a wheel is steered
`Tachometer`            voltage in proportion to speed, ripple, filter
`CurrentSensor`         shunt, amplifier, filter and converter
`Gyro`                  noise and offset, of bases; `Accelerometer` and `CurrentShunt` too
`Imu`                   three axes: noise, bias that walks, scale; `allan_deviation`
`ForceSensor`           six axes: noise, bias, crosstalk; `fit_crosstalk`, `fit_tool`: what hangs on it
======================  ========================================================================

`contact_force` is what motor torques say of a contact.

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
`brake_step`            told to close or open, does it hold
`bridge_voltage`        voltage asked for to voltage at the motor
`supply_step`           voltage of the DC link, exact
`limiter_voltage`       what a current limiter leaves of a voltage
`thermal_step`          current to temperatures of winding and housing, exact
`stiction_step`         friction of a simulated shaft, which holds at standstill
`lugre_step`            friction of bristles, integrated exactly
`friction_torque`       friction as a controller feeds it forward, by speed alone
`gear_torque`           motor torque to joint torque; `geared_step`: with friction, holds at standstill
`harmonic_torques`      angles and speeds to torques at motor and joint
`flank_torque`          twist in a gap to torque; `play_step`: hysteresis of play
`dead_zone`             what is beyond it; `undo_dead_zone`
`two_mass_step`         torques to twist and speeds, exact
`quadrature_step`       motor angle to levels, edges, count and index pulses
`receive_pairs`         wires to signals, and which is broken or exchanged
`index_step`            index pulses to lost counts
`potentiometer_step`    homing; `switch_step` too
`fine_angle`            count, sine and cosine to motor angle
`capture_edges`         motor angles to what a timer latches, for the ways to a speed
`tachometer_step`       angle and speed to a voltage
`current_reading`       current to a reading
`drift_step`            one axis of an `Imu`
`encoder_counter`       motor angle to the 16-bit counter
`extend_counter`        16-bit reads to a 64-bit count
`count_angle`           count to motor angle
`difference_speed`      M method: counts in an interval to speed
`tracking_step`         observer: angle, speed and load from each read
======================  ========================================================================
"""

from holonom.devices.encoders.counters.counter import Counter, unwrap_count, wrap_count
from holonom.devices.encoders.counters.index import (
    INDEX_START,
    IndexCorrection,
    IndexFault,
    IndexParams,
    IndexState,
    corrected_count,
    index_step,
)
from holonom.devices.encoders.frames.biss import BissFrame
from holonom.devices.encoders.frames.crc import crc
from holonom.devices.encoders.frames.endat import EndatFrame
from holonom.devices.encoders.frames.gray import gray_decode, gray_encode, join_turns, split_turns
from holonom.devices.encoders.frames.methods import FRAMES, decode_frame, encode_frame
from holonom.devices.encoders.frames.record import DecodedFrame
from holonom.devices.encoders.frames.ssi import SsiFrame
from holonom.devices.encoders.homing.methods import HOMINGS
from holonom.devices.encoders.homing.potentiometer import PotentiometerHoming, PotentiometerParams, potentiometer_step
from holonom.devices.encoders.homing.states import HOMING_START, HomingFault, HomingPhase, HomingState
from holonom.devices.encoders.homing.switch import SwitchHoming, SwitchParams, switch_step
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
from holonom.devices.encoders.quadrature.encoder import QuadratureEncoder, line_faults
from holonom.devices.encoders.quadrature.kernels import (
    HEALTHY,
    LineFaults,
    QuadratureParams,
    QuadratureState,
    decode_levels,
    quadrature_step,
)
from holonom.devices.encoders.quadrature.receivers import (
    LINE_RECEIVERS,
    LineFault,
    LineReceiver,
    ReceiverParams,
    drive_pair,
    index_misplaced,
    line_receiver,
    receive_pair,
    receive_pairs,
)
from holonom.devices.encoders.sincos.encoder import (
    SinCosEncoder,
    SinCosParams,
    fine_angle,
    interpolate,
    quarter_of,
    sincos_signals,
)
from holonom.devices.encoders.sincos.heydemann import SinCosCorrection, correct_sincos, fit_heydemann
from holonom.devices.encoders.speeds.m import MMethod, MParams, MState, m_step
from holonom.devices.encoders.speeds.m_t import MTMethod, MTState, m_t_step
from holonom.devices.encoders.speeds.methods import SPEED_METHODS, equal_resolution_speed
from holonom.devices.encoders.speeds.observer import ObserverMethod, ObserverParams, ObserverState, observer_step
from holonom.devices.encoders.speeds.pll import PllMethod, PllParams, PllState, pll_step
from holonom.devices.encoders.speeds.readings import (
    CaptureParams,
    EdgeReading,
    capture_edges,
    capture_params,
    first_reading,
)
from holonom.devices.encoders.speeds.t import TMethod, TParams, TState, t_step
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
from holonom.devices.power.brake import Brake, BrakeParams, BrakeState, brake_step
from holonom.devices.power.bridge import BridgeParams, PwmBridge, bridge_voltage
from holonom.devices.power.limiter import CurrentLimiter, LimiterParams, limiter_voltage
from holonom.devices.power.supply import Supply, SupplyParams, supply_step
from holonom.devices.sensors.contact import ContactForce, contact_force
from holonom.devices.sensors.current import CurrentParams, CurrentSensor, CurrentShunt, current_reading
from holonom.devices.sensors.force import Crosstalk, ForceSensor, ToolLoad, fit_crosstalk, fit_tool
from holonom.devices.sensors.inertial import (
    Accelerometer,
    DriftParams,
    Gyro,
    Imu,
    ImuReadings,
    allan_deviation,
    drift_step,
)
from holonom.devices.sensors.tachometer import Tachometer, TachometerParams, tachometer_step
from holonom.devices.sizing.cycle import LoadCycle, best_ratio
from holonom.devices.sizing.selection import Choice, GearChoice, Rejection, SizingLimits, select_drive
from holonom.devices.steering import SteeringMotor, SteeringParams
from holonom.devices.transmission.backlash import Backlash, FlankParams, flank_torque, play_step
from holonom.devices.transmission.dead_zone import DeadZone, DeadZoneParams, dead_zone, undo_dead_zone
from holonom.devices.transmission.friction import Friction
from holonom.devices.transmission.gear import Gear
from holonom.devices.transmission.harmonic import HarmonicDrive, HarmonicParams, HarmonicTorques, harmonic_torques
from holonom.devices.transmission.kernels import (
    FrictionParams,
    GearParams,
    LuGreParams,
    StictionParams,
    friction_torque,
    gear_torque,
    geared_step,
    lugre_step,
    stiction_step,
)
from holonom.devices.transmission.lugre import LuGre
from holonom.devices.transmission.two_mass import TwoMass, TwoMassParams, TwoMassState, two_mass_step

__all__ = [
    "DEVICES", "FRAMES", "HEALTHY", "HOMINGS", "HOMING_START", "INDEX_START", "LINE_RECEIVERS", "MOTORS",
    "SPEED_METHODS", "Accelerometer", "AngleTable", "ArmatureParams", "Backlash", "BissFrame", "Brake",
    "BrakeParams", "BrakeState", "BridgeParams", "CaptureParams", "Choice", "Cogging", "CoggingParams",
    "ContactForce", "Counter", "Crosstalk", "CurrentLimiter", "CurrentParams", "CurrentSensor", "CurrentShunt",
    "DcMotor", "DeadBand", "DeadZone", "DeadZoneParams", "DecodedFrame", "Dq", "DriftParams", "EdgeReading",
    "Encoder", "EncoderParams", "EndatFrame", "FieldOrientation", "FieldParams", "FieldState", "Finding",
    "FlankParams", "ForceSensor", "Friction", "FrictionParams", "Gear", "GearChoice", "GearParams", "Gyro",
    "HarmonicDrive", "HarmonicParams", "HarmonicTorques", "HomingFault", "HomingPhase", "HomingState", "Imu",
    "ImuReadings", "IndexCorrection", "IndexFault", "IndexParams", "IndexState", "InductionMachine",
    "InductionMotor", "InductionParams", "InductionState", "LimiterParams", "LineFault", "LineFaults",
    "LineReceiver", "LoadCycle", "LuGre", "LuGreParams", "MMethod", "MParams", "MState", "MTMethod", "MTState",
    "MotorCard", "MotorSheet", "ObserverMethod", "ObserverParams", "ObserverState", "PllMethod", "PllParams",
    "PllState", "Pmsm", "PmsmParams", "PmsmRun", "PotentiometerHoming", "PotentiometerParams", "PwmBridge",
    "QuadratureEncoder", "QuadratureParams", "QuadratureState", "ReceiverParams", "Rejection", "ReluctanceCycle",
    "ReluctanceParams", "ReluctanceRun", "SheetCheck", "SinCosCorrection", "SinCosEncoder", "SinCosParams",
    "SixStep", "SixStepParams", "SizingLimits", "SsiFrame", "SteeringMotor", "SteeringParams", "Stepper",
    "StepperParams", "StepperRun", "StepperState", "StictionParams", "Supply", "SupplyParams", "SwitchHoming",
    "SwitchParams", "SwitchedReluctance", "TMethod", "TParams", "TState", "Tachometer", "TachometerParams",
    "Temperatures", "ThermalModel", "ThermalParams", "ToolLoad", "TrackingParams", "TrackingState", "TwoMass",
    "TwoMassParams", "TwoMassState", "allan_deviation", "armature_step", "best_ratio", "brake_step",
    "bridge_voltage", "capture_edges", "capture_params", "check_angles", "check_sheet", "cogging_torque",
    "contact_force", "correct_sincos", "corrected_count", "count_angle", "crc", "current_reading", "dead_zone",
    "decode_frame", "decode_levels", "difference_speed", "drift_step", "drive_pair", "encode_frame",
    "encoder_counter", "equal_resolution_speed", "extend_counter", "field_reference", "field_step", "fine_angle",
    "first_reading", "fit_crosstalk", "fit_heydemann", "fit_tool", "flank_torque", "friction_torque", "gear_torque",
    "geared_step", "gray_decode", "gray_encode", "hall_sector", "harmonic_torques", "index_misplaced", "index_step",
    "induction_step", "interpolate", "join_turns", "limiter_voltage", "line_faults", "line_receiver", "lugre_step",
    "m_step", "m_t_step", "motor_card", "observer_step", "play_step", "pll_step", "pmsm_step", "pmsm_torque",
    "potentiometer_step", "quadrature_step", "quarter_of", "receive_pair", "receive_pairs", "reluctance_cycle",
    "reluctance_on", "reluctance_step", "reluctance_torque", "run_pmsm", "run_reluctance", "run_stepper",
    "select_drive", "sincos_signals", "six_step_step", "six_step_torque", "split_turns", "stepper_step",
    "stepper_torque", "stiction_step", "supply_step", "switch_step", "t_step", "tachometer_step", "thermal_step",
    "tracking_params", "tracking_step", "two_mass_step", "undo_dead_zone", "unwrap_count", "wrap_count",
]  # fmt: skip

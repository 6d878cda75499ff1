"""Regulators of servo axes and of the arm (specification 04). No device is seen here: numbers come in.

Compiled steps over scalars (`servo.kernels`), for a loop that keeps the state of its axes in rows of numbers:

=======================  =======================================================================
`pi_step`, `pi_start`    the PI regulator of both inner loops; its bumpless start
`current_step`           current to voltage (10 kHz)
`speed_step`             speed to current reference (2 kHz)
`position_step`          position to speed reference (1 kHz)
`acceleration_step`      computed torque, the part before the inverse dynamics (1 kHz)
`torque_to_current`      computed torque, the part behind it
`axis_violation`         which limit of an axis does not hold
=======================  =======================================================================

Verbs that make their params:

=======================  =======================================================================
`design_cascade`         `ServoAxis` and `SampleTimes` to `CascadeGains` with margins
`acceleration_params`    a bandwidth to the gains of the computed-torque law; `greatest_bandwidth` at a sample time
`SERVOS`                 servos beside it, a `Servo` each: one, two, three loops, PD, notch, ...
`remaining_errors`       what a loop of some type number leaves of steps, ramps, parabolas
`acceleration_params`    a bandwidth to the gains of the computed-torque law; `greatest_bandwidth` at a sample time,
                         `least_inertia` of its model
`AxisLimits`             limits; `Violation` names them, `drive_fault` words the stop
=======================  =======================================================================

Loops on a mobile base (compiled steps in `base.kernels`):

=======================  =======================================================================
`KeepingSettings`        path keeping: feed-forward and PI on the pose error, acceleration limited
`EstimateSettings`       velocity from gyro, accelerometers and the wheels that are trusted
`TractionSettings`       traction control: how much slip is wanted
`WatchSettings`          when a motor counts as dead
`tune_wheel`             a motor's data sheet to the `WheelLoop` of its wheel, with margins
=======================  =======================================================================

Regulators (`regulators`): `REGULATORS`, a `Regulator` each, and `respond`, what one answers to a sequence.

Processes (`processes`): `PROCESSES`, `RULES`, `tune_process`, the guide `recommend`, `identify_step`, `identify_relay`.

Tables: `CONTROLLERS` of an arm's joints, `BASE_CONTROLLERS`, the parts above, `PATH_LAWS` for bases that roll
forwards and turn (`path_laws`; a `PathLaw` each), `BALANCE_LAWS` of an inverted pendulum (`balance`; a `BalanceLaw`).
"""

from holonom.control.balance.contract import BalanceLaw, Pendulum
from holonom.control.balance.methods import BALANCE_LAWS
from holonom.control.base.path_keeping import EstimateSettings, KeepingSettings
from holonom.control.base.traction import TractionSettings, WatchSettings
from holonom.control.base.tuning import WheelLoop, tune_wheel
from holonom.control.margins import LoopMargin
from holonom.control.methods import BASE_CONTROLLERS, CONTROLLERS, CascadeSettings, ComputedTorqueSettings
from holonom.control.path_laws.contract import PathLaw
from holonom.control.path_laws.methods import PATH_LAWS
from holonom.control.processes import (
    PROCESSES,
    RULES,
    Gains,
    Guide,
    Process,
    Tuning,
    closed_step,
    identify_relay,
    identify_step,
    largest_gain,
    loop_figures,
    make_process,
    open_loop,
    recommend,
    relay_cycle,
    sampled_limits,
    sampled_margin,
    sampled_step,
    step_info,
    step_response,
    tune_process,
    ultimate_gain,
)
from holonom.control.regulators import REGULATORS, Regulator, respond
from holonom.control.servo.cascade import (
    CascadeGains,
    DesignWarning,
    SampleTimes,
    ServoAxis,
    design_cascade,
    open_loops,
)
from holonom.control.servo.computed_torque import acceleration_params, greatest_bandwidth, least_inertia
from holonom.control.servo.kernels import (
    AccelerationParams,
    CurrentParams,
    LimitParams,
    PiParams,
    PositionParams,
    SpeedParams,
    acceleration_step,
    axis_violation,
    current_step,
    pi_start,
    pi_step,
    position_step,
    speed_step,
    torque_to_current,
)
from holonom.control.servo.law_design import Servo, ServoGains
from holonom.control.servo.limits import AxisLimits, Violation, drive_fault
from holonom.control.servo.methods import SERVOS
from holonom.control.servo.remaining import RemainingErrors, remaining_errors

__all__ = [
    "BALANCE_LAWS",
    "BASE_CONTROLLERS",
    "CONTROLLERS",
    "PATH_LAWS",
    "PROCESSES",
    "REGULATORS",
    "RULES",
    "SERVOS",
    "AccelerationParams",
    "AxisLimits",
    "BalanceLaw",
    "CascadeGains",
    "CascadeSettings",
    "ComputedTorqueSettings",
    "CurrentParams",
    "DesignWarning",
    "EstimateSettings",
    "Gains",
    "Guide",
    "KeepingSettings",
    "LimitParams",
    "LoopMargin",
    "PathLaw",
    "Pendulum",
    "PiParams",
    "PositionParams",
    "Process",
    "Regulator",
    "RemainingErrors",
    "SampleTimes",
    "Servo",
    "ServoAxis",
    "ServoGains",
    "SpeedParams",
    "TractionSettings",
    "Tuning",
    "Violation",
    "WatchSettings",
    "WheelLoop",
    "acceleration_params",
    "acceleration_step",
    "axis_violation",
    "closed_step",
    "current_step",
    "design_cascade",
    "drive_fault",
    "greatest_bandwidth",
    "identify_relay",
    "identify_step",
    "largest_gain",
    "least_inertia",
    "loop_figures",
    "make_process",
    "open_loop",
    "open_loops",
    "pi_start",
    "pi_step",
    "position_step",
    "recommend",
    "relay_cycle",
    "remaining_errors",
    "respond",
    "sampled_limits",
    "sampled_margin",
    "sampled_step",
    "speed_step",
    "step_info",
    "step_response",
    "torque_to_current",
    "tune_process",
    "tune_wheel",
    "ultimate_gain",
]

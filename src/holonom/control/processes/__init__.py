"""Processes, and the gains of their regulators (specification 04.2).

======================  ========================================================================
`PROCESSES`             kinds of processes; `make_process` makes a `Process` of its kind and keys
`RULES`                 rules of tuning; `tune_process` takes one, gives a `Tuning`
`recommend`             which form suits a process, and why: a `Guide`
`loop_figures`          margins, peak, stability of an `open_loop`; `ultimate_gain`, `phase_crossings`
`closed_step`           step response of a closed loop, dead time too; `overshoot_percent`
`sampled_margin`        what a sampled loop keeps; `largest_gain`, `sampled_limits`, `sampled_step`
`identify_step`         a process from a recorded step; `identify_relay`, from a relay experiment
`relay_cycle`           the exact limit cycle under a relay
`linear_system`         any linear system: `step_response`, `initial_response`, `impulse_response`, `step_info`
======================  ========================================================================
"""

from holonom.control.processes.closed import closed_step, overshoot_percent
from holonom.control.processes.contract import Rule, Tuning
from holonom.control.processes.guide import Guide, recommend
from holonom.control.processes.identify import Fit, RelayFit, identify_relay, identify_step
from holonom.control.processes.linear import (
    LinearSystem,
    StepInfo,
    impulse_response,
    initial_response,
    linear_system,
    steady_gain,
    step_info,
    step_response,
)
from holonom.control.processes.loop import (
    Gains,
    LoopFigures,
    OpenLoop,
    loop_figures,
    open_loop,
    phase_crossings,
    ultimate_gain,
)
from holonom.control.processes.methods import RULES
from holonom.control.processes.process import PROCESSES, Process, make_process
from holonom.control.processes.relay import RelayCycle, relay_cycle
from holonom.control.processes.sampled import (
    SampledLimits,
    SampledMargin,
    largest_gain,
    sampled_limits,
    sampled_margin,
    sampled_step,
)
from holonom.control.processes.tune import default_rule, tune_process

__all__ = [
    "PROCESSES",
    "RULES",
    "Fit",
    "Gains",
    "Guide",
    "LinearSystem",
    "LoopFigures",
    "OpenLoop",
    "Process",
    "RelayCycle",
    "RelayFit",
    "Rule",
    "SampledLimits",
    "SampledMargin",
    "StepInfo",
    "Tuning",
    "closed_step",
    "default_rule",
    "identify_relay",
    "identify_step",
    "impulse_response",
    "initial_response",
    "largest_gain",
    "linear_system",
    "loop_figures",
    "make_process",
    "open_loop",
    "overshoot_percent",
    "phase_crossings",
    "recommend",
    "relay_cycle",
    "sampled_limits",
    "sampled_margin",
    "sampled_step",
    "steady_gain",
    "step_info",
    "step_response",
    "tune_process",
    "ultimate_gain",
]

"""Speed loop with PD: faster than PI, with a remaining error under load."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from holonom.control.servo.axis import SampleTimes, ServoAxis
from holonom.control.servo.cascade import LOOP_DELAY, design_current, resolvable_crossover
from holonom.control.servo.kernels import SpeedParams
from holonom.control.servo.law_design import Servo, ServoGains, servo_law, slowed
from holonom.control.servo.law_kernels import BiquadParams
from holonom.registry import Method, parameter

__all__ = ["SPEED_PD", "SpeedPd", "pd_speed_loop", "pi_speed_loop"]

LEAD = 5.0  # T_A / T_B
MARGIN = math.radians(55.0)
SPEED_RATIO = 10.0  # T_i / T_V'


def pd_speed_loop(lag: float, gain: float) -> Callable[[Any], Any]:
    """Open speed loop without sampling: PD with `T_A` on the lag `T_V'` (s), `T_B = T_V'/5`, crossover `gain / T_B`.

    `L = (gain / T_B) / (s (1 + s T_B))`: gain 0.6 leaves 62.1 deg at 2.65 / T_V', 0.25 leaves 76.3 deg at 1.21 / T_V'.
    """
    tb = lag / LEAD
    return lambda s: gain / tb / (s * (1.0 + s * tb))


def pi_speed_loop(lag: float, ratio: float = SPEED_RATIO) -> Callable[[Any], Any]:
    """Open speed loop of type 2 without sampling: PI with `T_i = ratio T_V'`, crossover `1 / sqrt(T_i T_V')`.

    With ratio 10: 54.9 deg; a step of the reference overshoots by 23.2 %, behind a prefilter `1/(1 + s T_i)` by none.
    """
    ti = ratio * lag
    crossover = 1.0 / math.sqrt(ti * lag)
    return lambda s: crossover * (1.0 + s * ti) / (s * ti) / (s * (1.0 + s * lag))


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedPd(Servo):
    """Three loops whose speed loop has `K (1 + s T_A)/(1 + s T_B)`, `T_A = T_V'` and `T_B = T_V'/5`.

    Raises
    ------
    OutOfLimits
        A number outside its range.

    Notes
    -----
    The zero takes out the small lag T_V' (current loop, sampling). Where T_V' is mostly the delay of sampling there is
    little to take out: T_B is half a sample at least, and the gain is lowered until 55 deg are left.
    """

    gain: float = parameter(0.25, meaning="crossover times T_B", unit="", above=0.0, most=1.0)

    def design(self, axis: ServoAxis, *, times: SampleTimes | None = None) -> ServoGains:
        """Gains; the gain is the wanted one, or as high as margin and encoder let it be."""
        times = times or SampleTimes()
        current = design_current(axis, times.current, True)
        lag = axis.inductance / current.gain + LOOP_DELAY * times.speed
        ta, tb = lag, max(lag / LEAD, 0.5 * times.speed)
        wanted = min(self.gain / tb, resolvable_crossover(axis) * tb / ta)
        speed = SpeedParams(
            wanted * axis.inertia / axis.torque_constant, 0.0, axis.max_current, axis.max_voltage,
            axis.back_emf_constant, 1.0 / axis.resistance,
        )  # fmt: skip
        return slowed(axis, servo_law(lead=_lead(ta, tb, times.speed)), speed, times, MARGIN)


def _lead(ta: float, tb: float, dt: float) -> BiquadParams:
    """`(1 + s T_A)/(1 + s T_B)` by Tustin."""
    a, b = 2.0 * ta / dt, 2.0 * tb / dt
    return BiquadParams((1.0 + a) / (1.0 + b), (1.0 - a) / (1.0 + b), 0.0, (1.0 - b) / (1.0 + b), 0.0)


SPEED_PD = Method(
    "three loops, speed PD: no integral, a load leaves an error",
    lambda servo: servo,
    "Leonhard, Control of Electrical Drives; specification 04.3, 04.5",
    SpeedPd,
)

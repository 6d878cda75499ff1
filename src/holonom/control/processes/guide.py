"""Which form of regulator suits a process, and why (specification 04.2, 000 3.7)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from holonom.control.processes.loop import Gains, loop_figures, open_loop, ultimate_gain
from holonom.control.processes.process import Parts, Process, make_process, parts_of
from holonom.errors import ModelError, OutOfLimits, UnknownName

__all__ = ["DISTURBANCES", "Guide", "recommend"]

DISTURBANCES = ("before", "behind")
NEAR = 0.5  # smaller lag over the larger one, from which two count as near-equal
EQUAL = 0.9  # and as equal
RATIO = 10.0  # Ti over the largest lag of an integrating process


@dataclass(frozen=True, slots=True)
class Guide:
    """A form, why, and why not the others.

    Attributes
    ----------
    recommended
        "I", "P", "PI", "PD" or "PID".
    reasons
        Sentences.
    rejected
        Form to its reason.
    """

    recommended: str
    reasons: tuple[str, ...]
    rejected: Mapping[str, str]

    def data(self) -> dict[str, Any]:
        """Return it as JSON values."""
        return {"recommended": self.recommended, "reasons": list(self.reasons), "rejected": dict(self.rejected)}


def recommend(process: Process | Mapping[str, Any], *, disturbance: str = "before") -> Guide:
    """Which form suits a process.

    Parameters
    ----------
    process
        A `Process`, or its kind and keys.
    disturbance
        Of an integrating process: whether it enters "before" its integrator (a load on a motor) or "behind" it.

    Raises
    ------
    UnknownName, ModelError
        As `make_process`; a disturbance that is neither; two integrators.
    """
    process = make_process(process)
    if disturbance not in DISTURBANCES:
        raise UnknownName("place of the disturbance", disturbance, DISTURBANCES)
    parts = parts_of(process)
    if parts.integrators > 1:
        raise ModelError(
            "two integrators: neither P nor PI is stable on them; close a loop of the speed first, or take PD"
        )
    if parts.integrators:
        return _integrating(process, parts, disturbance)
    if parts.swings:
        return _swinging(process)
    lags = parts.lags
    if not lags:
        return _dead(parts)
    if len(lags) == 1:
        return _one_lag(parts)
    near, still = lags[1] / lags[0] >= NEAR, parts.dead_time > 0.0 or len(lags) > 2
    if still:
        return _near_and_dead(process, parts) if near else _unequal(parts)
    return _equal(parts) if near else _unequal(parts)


def _dead(parts: Parts) -> Guide:
    critical = 1.0 / parts.gain
    return Guide(
        "I",
        (
            f"dead time alone ({parts.dead_time:g} s): an integral of Kc/Ti = 1/(2 Kp TH) = "
            f"{0.5 / (parts.gain * parts.dead_time):.4g} 1/s leaves 61.4 deg and no offset",
        ),
        {
            "P": f"unstable from Kc Kp = 1 (Kc = {critical:.4g}), and below it with an offset of more than a half",
            "PI": "its proportional part meets no lag: it goes through unchanged and comes back a dead time later",
            "PD": "a derivative of what jumps; unstable at any gain that helps",
            "PID": "a derivative of what jumps; unstable at any gain that helps",
        },
    )


def _one_lag(parts: Parts) -> Guide:
    if parts.dead_time > 0.0:
        lag, dead = parts.lags[0], parts.dead_time
        return Guide(
            "PI",
            (f"one lag ({lag:g} s) and dead time ({dead:g} s): PI with Ti = {lag:g} s cancels the lag; the dead time "
             "alone bounds the gain",),
            {
                "P": f"an offset of 1/(1 + Kc Kp), and Kc is bounded by the dead time ({_bound(parts)})",
                "PD": "an offset, and a derivative of what the dead time hides",
                "PID": "little faster than PI; the derivative pays from a second lag on",
                "I": "the lag stays in the loop: slower than PI",
            },
        )  # fmt: skip
    return Guide(
        "P",
        (
            f"one lag ({parts.lags[0]:g} s): stable at any gain, P makes it 1 + Kc Kp times as fast with an offset of "
            "1/(1 + Kc Kp)",
            f"where no offset is allowed: PI with Ti = {parts.lags[0]:g} s, a single lag without offset",
        ),
        {
            "PD": "there is no second lag to lead; the derivative only adds noise",
            "PID": "there is no second lag to lead; the derivative only adds noise",
            "I": "slow: the lag stays in the loop and limits the gain",
        },
    )


def _equal(parts: Parts) -> Guide:
    words = "two equal lags" if parts.lags[1] >= EQUAL * parts.lags[0] else "two near-equal lags"
    return Guide(
        "PI",
        (f"{words} ({parts.lags[0]:g} and {parts.lags[1]:g} s): PI with Ti on one of them, Kc = 0.6 T1/(Kp T2) for 60 "
         "deg; no offset",),
        {
            "P": "an offset of 1/(1 + Kc Kp), and it swings the more the smaller that is",
            "PD": "fast, but with a large effort and an offset of 1/(1 + Kc Kp)",
            "PID": "cancels both lags: its gain is bounded by noise and effort only; take it where PI is too slow",
            "I": "slow: both lags stay in the loop",
        },
    )  # fmt: skip


def _unequal(parts: Parts) -> Guide:
    small = sum(parts.lags[1:]) + parts.dead_time
    return Guide(
        "PI",
        (f"unequal lags: PI with Ti on the larger ({parts.lags[0]:g} s); what is left ({small:g} s) bounds the gain, "
         f"Kc = 0.6 T1/(Kp T2) = {0.6 * parts.lags[0] / (parts.gain * small):.4g} for 60 deg",),
        {
            "P": "an offset of 1/(1 + Kc Kp)",
            "PD": "an offset, and it cancels the smaller lag only by a large effort",
            "PID": "little faster than PI: the smaller lag is small",
            "I": "slow: the larger lag stays in the loop",
        },
    )  # fmt: skip


def _near_and_dead(process: Process, parts: Parts) -> Guide:
    return Guide(
        "PID",
        (f"two near-equal lags ({parts.lags[0]:g} and {parts.lags[1]:g} s) and more delay: PID cancels both, and "
         f"the rest ({sum(parts.lags[2:]) + parts.dead_time:g} s) bounds the gain; PI is half as fast",),
        {
            "P": f"an offset of 1/(1 + Kc Kp), with Kc below {ultimate_gain(process)[0]:.4g}",
            "PI": "the second lag stays in the loop: about half as fast",
            "PD": "an offset of 1/(1 + Kc Kp)",
            "I": "slow: both lags stay in the loop",
        },
    )  # fmt: skip


def _integrating(process: Process, parts: Parts, disturbance: str) -> Guide:
    largest = max([*parts.lags, parts.dead_time])
    no_i = "two integrals in the loop and no zero: unstable at any gain"
    if disturbance == "behind":
        return Guide(
            "P",
            ("the process integrates, and the disturbance enters behind the integrator: P leaves no offset",
             f"with a lag ({largest:g} s) that is to be faster: PD, its zero on that lag"),
            {"PI": "not needed: a second integral costs phase and overshoots a step of the reference",
             "PID": "not needed: a second integral costs phase and overshoots a step of the reference", "I": no_i},
        )  # fmt: skip
    return Guide(
        "PI",
        ("the process integrates, and the disturbance enters before the integrator: only an integral of the regulator "
         "takes its offset away",
         f"PI with Ti of at least {RATIO:g} times the largest lag: {RATIO * largest:g} s; faster with PID, its second "
         "zero on that lag"),
        {"P": f"a load before the integrator leaves an offset of load/Kc{_p_bound(process)}",
         "PD": "a load before the integrator leaves an offset of load/Kc", "I": no_i},
    )  # fmt: skip


def _swinging(process: Process) -> Guide:
    figures = loop_figures(open_loop(process, Gains(1.0), "P"))
    peak = f"its response has complex poles; with P = 1 Ms is {figures.Ms:.2f}"
    return Guide(
        "PID",
        (f"{peak}: two zeros of the regulator lie on the poles; a notch does the same without noise",),
        {
            "P": "an offset, and less damping than the process has itself",
            "PI": "an integral takes phase where the poles take it, too: slow",
            "PD": "an offset",
            "I": "slow: it must cross far below the resonance",
        },
    )


def _bound(parts: Parts) -> str:
    return f"about {1.57 * parts.lags[0] / (parts.gain * parts.dead_time):.3g}"


def _p_bound(process: Process) -> str:
    try:
        return f", and Kc is below {ultimate_gain(process)[0]:.4g}"
    except OutOfLimits:
        return ""

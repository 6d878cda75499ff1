"""From a process to the gains of its regulator by a rule, and what they promise."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from holonom.control.processes.closed import overshoot_percent
from holonom.control.processes.contract import FORMS, Rule, Tuning, refuse_form
from holonom.control.processes.loop import Gains, LoopFigures, loop_figures, open_loop
from holonom.control.processes.methods import RULES
from holonom.control.processes.process import Process, make_process
from holonom.control.processes.sampled import SampledMargin, largest_gain, sampled_margin, sampled_step, too_short
from holonom.errors import InputError, ModelError, UnknownName

__all__ = ["default_rule", "tune_process", "verified"]

LOST_DEG = 10.0  # of phase margin to sampling, from which on a design says so
LEAST_DEG, MOST_MS = 30.0, 2.0  # phase margin and sensitivity, beyond which a design says so
SAMPLES = 2000  # of a sampled step response


def default_rule(process: Process, form: str | None = None, settings: Mapping[str, Any] = MappingProxyType({})) -> str:
    """Return the rule that is taken unless one is named: the first that fits with a stable loop.

    In the order of the table: by Bode where the process has such a form, optima, SIMC, lambda, reaction curves.

    Parameters
    ----------
    process, form
        As of `tune_process`.
    settings
        Of rules, by name; each takes its own.
    """
    form = _form(process, form)
    for rule in RULES.own:
        known = {field.name for field in RULES[rule].fields}
        try:
            made: Rule = RULES.make(rule, {key: value for key, value in settings.items() if key in known})
            if form in made.forms and loop_figures(open_loop(process, made.gains(process, form), form)).stable:
                return rule
        except InputError:
            continue
    return next(iter(RULES.own)) if len(process.den) == 1 else "lambda" if form == "P" else "simc"


def _form(process: Process, form: str | None) -> str:
    return ("PI" if len(process.den) > 1 else "I") if form is None else form


def tune_process(
    process: Process | Mapping[str, Any],
    rule: str | None = None,
    form: str | None = None,
    *,
    sample_time: float | None = None,
    delay_samples: int = 1,
    **settings: Any,
) -> Tuning:
    """Gains of a regulator for a process, with margins, sensitivity and overshoot of the closed loop.

    Parameters
    ----------
    process
        A `Process`, or its kind and keys.
    rule
        Of `RULES`; None: `default_rule`.
    form
        "P", "PI", "PD", "PID", or "I" for dead time alone; None: "PI", of dead time alone "I".
    sample_time, delay_samples
        s and whole samples: of the regulator that will compute it, whose margin is looked at, too; None: not asked.
        The rule "sampled" designs for it.
    settings
        Of the rule: `ratio`, `tau_c`, `closed_lag`, ...; `holonom methods rules` lists them.

    Notes
    -----
    Figures are of `K_c (1 + 1/(s T_i) + s T_d)` on the process itself, not on the model that a rule makes of it. Where
    the loop would not fall off at high frequencies with an ideal derivative, it is filtered by T_d/10.

    Raises
    ------
    UnknownName
        No such kind, rule, form or setting; lists what there is.
    ModelError
        An unstable or improper process; a rule that does not fit it, does not know the form, or gives an unstable loop.
    OutOfLimits
        A number outside its range.
    """
    process = make_process(process)
    form = _form(process, form)
    if form not in FORMS:
        raise UnknownName("form", form, FORMS)
    rule = default_rule(process, form, settings) if rule is None else rule
    if not isinstance(rule, str):
        raise UnknownName("rule", str(rule), RULES)
    RULES[rule]
    if rule == "sampled":
        if sample_time is not None:
            settings = {"sample_time": sample_time, "delay_samples": delay_samples} | settings
        sample_time, delay_samples = settings.get("sample_time"), settings.get("delay_samples", 1)
    made: Rule = RULES.make(rule, settings)
    refuse_form(rule, form, made.forms)
    gains = made.gains(process, form)
    if rule == "sampled" and sample_time is not None:
        return _sampled(process, form, gains, sample_time, delay_samples)
    return verified(process, rule, form, gains, made.prefilter, sample_time, delay_samples)


def verified(
    process: Process, rule: str, form: str, gains: Gains, prefilter: bool = False, sample_time: float | None = None,
    delay_samples: int = 1,
) -> Tuning:  # fmt: skip
    """What gains promise on a process; arguments and errors as `tune_process`."""
    loop = open_loop(process, gains, form)
    figures = loop_figures(loop)
    if not figures.stable:
        raise ModelError(
            f"rule {rule!r} gives an unstable {form} here (Kc {gains.Kc:.4g}, phase margin "
            f"{figures.phase_margin_deg:.1f} deg); take another rule"
        )
    smooth = overshoot_percent(loop, prefilter=gains.Ti, figures=figures) if prefilter else None
    warnings = _weak(figures.phase_margin_deg, figures.Ms)
    if sample_time is not None and form != "I" and not too_short(process, sample_time):
        warnings |= _too_slow(process, gains, figures, sample_time, delay_samples)
    return Tuning(
        process=process,
        rule=rule,
        form=form,
        Kc=float(gains.Kc),
        Ti=float(gains.Ti),
        Td=float(gains.Td),
        crossover=figures.crossover,
        phase_margin_deg=figures.phase_margin_deg,
        gain_margin=figures.gain_margin,
        overshoot_percent=overshoot_percent(loop, figures=figures),
        Ms=figures.Ms,
        overshoot_with_prefilter_percent=smooth,
        warnings=MappingProxyType(warnings),
    )


def _sampled(process: Process, form: str, gains: Gains, dt: float, delay_samples: int) -> Tuning:
    """Figures of the sampled loop; the overshoot is that at the samples."""
    found = sampled_margin(process, gains, dt, delay_samples=delay_samples)
    y = sampled_step(process, gains, dt, SAMPLES, delay_samples=delay_samples)
    return Tuning(
        process=process,
        rule="sampled",
        form=form,
        Kc=float(gains.Kc),
        Ti=float(gains.Ti),
        Td=float(gains.Td),
        crossover=found.crossover,
        phase_margin_deg=found.phase_margin_deg,
        gain_margin=found.gain_margin,
        overshoot_percent=max(100.0 * (float(y.max()) / float(y[-1]) - 1.0), 0.0),
        Ms=found.Ms,
        warnings=MappingProxyType(_weak(found.phase_margin_deg, found.Ms)),
    )


def _weak(phase_margin_deg: float, Ms: float) -> dict[str, str]:
    found = {}
    if phase_margin_deg < LEAST_DEG:
        found["phase_margin"] = (
            f"{phase_margin_deg:.1f} deg of phase are kept; {LEAST_DEG:g} at least are usual: a lower gain"
        )
    if Ms > MOST_MS:
        found["sensitivity"] = f"Ms is {Ms:.2f}; up to {MOST_MS:g} is usual: a lower gain or a longer Ti"
    return found


def _too_slow(process: Process, gains: Gains, figures: LoopFigures, dt: float, delay_samples: int) -> dict[str, str]:
    """What sampling costs, where it costs too much."""
    found: SampledMargin = sampled_margin(process, gains, dt, delay_samples=delay_samples)
    lost = figures.phase_margin_deg - found.phase_margin_deg
    if found.stable and not lost > LOST_DEG:
        return {}
    if found.stable:
        left = f"keeps {found.phase_margin_deg:.1f} deg of {figures.phase_margin_deg:.1f}"
    else:
        left = f"is unstable (a pole at {found.pole:.3f})"
    try:
        advice = f"largest Kc with 60 deg there: {largest_gain(process, gains, dt, delay_samples=delay_samples):.4g}"
    except ModelError:
        advice = "no gain keeps 60 deg there with this Ti"
    return {
        "sample_time": f"sampled every {dt:g} s with {delay_samples} of computing, the loop {left}; {advice}; sample "
        "faster, or take the rule 'sampled'"
    }

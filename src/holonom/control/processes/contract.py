"""What a rule is, and what it gives."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from holonom.control.processes.loop import Gains
from holonom.control.processes.process import Process
from holonom.errors import ModelError

__all__ = ["FORMS", "Rule", "Tuning", "refuse_form"]

FORMS = ("I", "P", "PI", "PD", "PID")


@dataclass(frozen=True, slots=True)
class Rule:
    """A rule with its settings.

    Attributes
    ----------
    forms
        Of regulators that it knows.
    gains
        `gains(process, form)`; a `ModelError` says why it does not fit a process.
    prefilter
        Whether a lag of Ti before the reference belongs to it.
    """

    forms: tuple[str, ...]
    gains: Callable[[Process, str], Gains]
    prefilter: bool = False


@dataclass(frozen=True, slots=True)
class Tuning:
    """Gains of a regulator, and what they promise, verified on the process itself.

    Attributes
    ----------
    process, rule, form
        What was tuned, how, and what (`I`, `P`, `PI`, `PD`, `PID`).
    Kc, Ti, Td
        `u/e = K_c (1 + 1/(s T_i) + s T_d)`; s. Ti is infinite without an integral. Form I: `K_c/(s T_i)`.
    crossover, phase_margin_deg, gain_margin
        rad/s, deg, factor; NaN and infinite where the loop has no crossover.
    overshoot_percent
        Of a step of the reference, without and with the prefilter 1/(1 + s Ti), where one belongs to the rule.
    Ms
        Largest sensitivity.
    warnings
        What does not hold, by name: sentences with numbers.
    """

    process: Process
    rule: str
    form: str
    Kc: float
    Ti: float
    Td: float
    crossover: float
    phase_margin_deg: float
    gain_margin: float
    overshoot_percent: float
    Ms: float
    overshoot_with_prefilter_percent: float | None = None
    warnings: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))

    @property
    def gains(self) -> Gains:
        """Kc, Ti, Td."""
        return Gains(self.Kc, self.Ti, self.Td)

    def data(self) -> dict[str, Any]:
        """Return it as JSON values: what is infinite or does not exist is None."""
        names = ["Kc", "Ti", "Td", "crossover", "phase_margin_deg", "gain_margin", "overshoot_percent", "Ms"]
        if self.overshoot_with_prefilter_percent is not None:
            names.append("overshoot_with_prefilter_percent")
        numbers = {name: getattr(self, name) for name in names}
        plain = {name: value if math.isfinite(value) else None for name, value in numbers.items()}
        said = [{"name": name, "text": text} for name, text in self.warnings.items()]
        return {"process": dict(self.process.given), "rule": self.rule, "form": self.form, **plain, "warnings": said}


def refuse_form(rule: str, form: str, forms: tuple[str, ...]) -> None:
    """Refuse a form that a rule does not know.

    Raises
    ------
    ModelError
    """
    if form not in forms:
        raise ModelError(f"rule {rule!r} has no {form}; it has {', '.join(forms)}")

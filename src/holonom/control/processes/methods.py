"""Table of rules of tuning."""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["RULES"]

_HERE = "holonom.control.processes.rules"

RULES = Table(
    "rules",
    "rule",
    "a `Rule`: gains for a process and a form, or why it does not fit",
    {
        "lag_compensation": f"{_HERE}.lag_compensation:LAG_COMPENSATION",
        "phase_margin_60": f"{_HERE}.two_lags:PHASE_MARGIN_60",
        "phase_margin_50": f"{_HERE}.two_lags:PHASE_MARGIN_50",
        "aperiodic": f"{_HERE}.two_lags:APERIODIC",
        "symmetrical_bode": f"{_HERE}.symmetrical_bode:SYMMETRICAL_BODE",
        "modulus_optimum": f"{_HERE}.modulus_optimum:MODULUS_OPTIMUM",
        "symmetrical_optimum": f"{_HERE}.symmetrical_optimum:SYMMETRICAL_OPTIMUM",
        "simc": f"{_HERE}.simc:SIMC",
        "lambda": f"{_HERE}.internal_model:LAMBDA",
        "ziegler_nichols": f"{_HERE}.ziegler_nichols:ZIEGLER_NICHOLS",
        "ziegler_nichols_ultimate": f"{_HERE}.ziegler_nichols:ZIEGLER_NICHOLS_ULTIMATE",
        "oppelt": f"{_HERE}.oppelt:OPPELT",
        "chr_disturbance_0": f"{_HERE}.chien_hrones_reswick:CHR_DISTURBANCE_0",
        "chr_disturbance_20": f"{_HERE}.chien_hrones_reswick:CHR_DISTURBANCE_20",
        "chr_setpoint_0": f"{_HERE}.chien_hrones_reswick:CHR_SETPOINT_0",
        "chr_setpoint_20": f"{_HERE}.chien_hrones_reswick:CHR_SETPOINT_20",
        "cohen_coon": f"{_HERE}.cohen_coon:COHEN_COON",
        "sampled": f"{_HERE}.sampled:SAMPLED",
    },
)

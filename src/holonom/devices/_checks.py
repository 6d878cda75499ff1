"""The one check of the data sheets."""

from __future__ import annotations

import math

from holonom.errors import ModelError


def require(
    owner: str,
    field: str,
    value: float,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    most: float = math.inf,
) -> None:
    """Raise ModelError unless `value` is finite, greater than `above` and within [least, most]."""
    if math.isfinite(value) and value > above and least <= value <= most:
        return
    low = f"greater than {above:g}" if above > -math.inf else f"at least {least:g}" if least > -math.inf else ""
    high = f"at most {most:g}" if most < math.inf else ""
    allowed = " and ".join(part for part in ("finite", low, high) if part)
    raise ModelError(f"{owner}: {field} is {value!r}; it must be {allowed}")

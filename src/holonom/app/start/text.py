"""Values and comments as a cell file has them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable

__all__ = ["angle", "head", "length", "listed", "quoted", "round_down", "rows"]

MARGIN = 34
"""Columns before the comments of a table."""


def quoted(text: str) -> str:
    """Return a TOML string."""
    return json.dumps(text, ensure_ascii=False)


def length(metres: float) -> str:
    """Return a length as a cell has it, "250mm"."""
    return f"{1e3 * metres:.6g}mm"


def angle(radians: float) -> str:
    """Return an angle as a cell has it, "30deg"."""
    return f"{math.degrees(radians):.6g}deg"


def listed(values: Iterable[str]) -> str:
    """Return a TOML list of strings."""
    return f"[{', '.join(map(quoted, values))}]"


def rows(table: Iterable[tuple[str, str]], mark: str = "#") -> str:
    """Return lines, each with its comment behind it, or above it where it is long; without one, as it is."""
    return "".join(_row(line, f"{mark} {said}" if said else "") for line, said in table)


def _row(line: str, comment: str) -> str:
    if len(line) < MARGIN or not comment:
        return f"{line:{MARGIN}}{comment}".rstrip() + "\n"
    indent = " " * (len(line) - len(line.lstrip()))
    return f"{indent}{comment}\n{line}\n"


def head(name: str, about: str) -> str:
    """Return what every cell begins with."""
    own = [
        ("[cell]", ""),
        (f"name = {quoted(name)}", "what summary and report call it"),
        ('time_limit = "60s"', "of simulated time; a run that takes longer is given up"),
        ("seed = 1", "of noise; the same seed gives the same run"),
    ]
    return (
        f"# {about}\n"
        '# Quantities carry their unit, "250mm/s" or "30deg". Files are looked for beside this one.\n'
        "# 'holonom check cell.toml' says what is wrong with it; 'holonom run cell.toml' runs it.\n\n"
        f"{rows(own)}\n"
    )


def round_down(value: float) -> float:
    """Return the greatest 1, 2 or 5 times a power of ten that is at most a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(factor * power for factor in (1.0, 2.0, 5.0) if factor * power <= value * (1.0 + 1e-12))

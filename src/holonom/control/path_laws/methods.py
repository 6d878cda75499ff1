"""Table of the laws that keep a base on its path."""

from __future__ import annotations

from holonom.registry import Table

__all__ = ["PATH_LAWS"]

_HERE = "holonom.control.path_laws"

PATH_LAWS = Table(
    "path_laws",
    "law of a path",
    "a `PathLaw`: its compiled step and its settings",
    {
        "kanayama": f"{_HERE}.kanayama:KANAYAMA",
        "ltv": f"{_HERE}.ltv:LTV",
        "ramsete": f"{_HERE}.ramsete:RAMSETE",
        "stanley": f"{_HERE}.stanley:STANLEY",
        "pure_pursuit": f"{_HERE}.pure_pursuit:PURE_PURSUIT",
    },
)

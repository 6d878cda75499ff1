"""A figure without pyplot: made here, written here."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from holonom.errors import MissingExtra, OutputError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["COLORS", "new_figure", "saved"]

COLORS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#8B6F47")
"""Okabe and Ito's colours, told apart by everybody; then a brown."""


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches.

    Raises
    ------
    MissingExtra
        Matplotlib is not installed.
    """
    try:
        from matplotlib.figure import Figure
    except ImportError:
        raise MissingExtra("a figure", "Matplotlib", "plots") from None
    return Figure(figsize=(width, height), layout="constrained")


def saved(figure: Any, save: str | Path | None) -> None:
    """Write a figure, its kind by the file's ending (png, pdf, svg, ...).

    Raises
    ------
    OutputError
        The file cannot be written, or its kind is not known.
    """
    from matplotlib.text import Text

    for text in figure.findobj(Text):  # a dollar in somebody's name is no formula
        if "$" in text.get_text() and "mathdefault" not in text.get_text():
            text.set_parse_math(False)
    if save is None:
        return
    try:
        figure.savefig(save, dpi=160)
    except (OSError, ValueError) as problem:
        raise OutputError(f"figure {str(save)!r} cannot be written: {problem}") from problem

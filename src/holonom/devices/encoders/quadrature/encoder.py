"""Data sheet of a quadrature encoder with an index, and what can be wrong with its lines (spec 03.3)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from holonom.devices._checks import require
from holonom.devices.encoders.incremental import Encoder
from holonom.devices.encoders.quadrature.kernels import LineFaults, QuadratureParams, QuadratureState, line_levels
from holonom.errors import ModelError
from holonom.registry import check_fields, parameter

__all__ = ["LEVELS", "QuadratureEncoder", "line_faults"]

DECODINGS = (1, 2, 4)
LEVELS = {"low": 0, "high": 1}


@dataclass(frozen=True, slots=True)
class QuadratureEncoder:
    """An encoder with two channels a quarter of a line apart, an index once a turn, and the decoder behind it.

    Raises
    ------
    ModelError
        Fewer than one line per turn; a decoding that is neither 1, 2 nor 4.
    """

    lines: int = parameter(meaning="lines per turn: periods of a channel", least=1, most=2**28, example=1000)
    decoding: int = parameter(4, meaning="counts per line: 1, 2 or 4", least=1, most=4)

    def __post_init__(self) -> None:
        check_fields(self, ModelError)
        if self.decoding not in DECODINGS:
            raise ModelError(f"QuadratureEncoder: decoding is {self.decoding}; it must be 1, 2 or 4 counts per line")

    @property
    def counts_per_rev(self) -> int:
        """Counts per turn after decoding."""
        return self.lines * self.decoding

    def counted(self) -> Encoder:
        """Its data sheet for whoever asks for counts only."""
        return Encoder(self.counts_per_rev)

    def params(self) -> QuadratureParams:
        """Params of `quadrature_step`."""
        quarters = 4 * self.lines
        return QuadratureParams(quarters / (2.0 * math.pi), quarters, (2, 1, 0)[DECODINGS.index(self.decoding)])

    def start(self, angle: float = 0.0) -> QuadratureState:
        """State at power-on: the counter is at zero wherever the shaft stands (rad); no index was seen."""
        require("QuadratureEncoder.start", "angle", angle, least=-1e9, most=1e9)
        quarter = math.floor(angle * self.params().quarters_per_rad)
        place = quarter % (4 * self.lines)
        return QuadratureState(quarter, place, line_levels(quarter, place), 0, 0, 0, 0, 0, 0, 0.0, 0.0)


def line_faults(
    *,
    a: str | None = None,
    b: str | None = None,
    index: str | None = None,
    dead: bool = False,
    swapped: bool = False,
    lost: float = 0.0,
    glitches: float = 0.0,
) -> LineFaults:
    """Faults of a quadrature encoder's lines, for `quadrature_step`.

    An encoder with other counts per turn than its sheet says is one of other `params()`.

    Parameters
    ----------
    a, b, index : "low" or "high": where this line is stuck.
    dead : all lines low: no supply, cable pulled.
    swapped : A and B exchanged: it counts the other way.
    lost : share of the edges, 0 to 1, evenly spread, that the counter does not take.
    glitches : share of the edges, 0 to 1, evenly spread, that meet a pulse on the other channel: an illegal transition.

    Raises
    ------
    ModelError
        Another level; a share outside 0 to 1.
    """
    given = {"a": a, "b": b, "index": index}
    for name, level in given.items():
        if level is not None and level not in LEVELS:
            raise ModelError(f'line_faults: {name} is {level!r}; it must be None, "low" or "high"')
    for name, share in (("lost", lost), ("glitches", glitches)):
        require("line_faults", name, share, least=0.0, most=1.0)
    if dead:
        return LineFaults(0, 0, 0, int(swapped), float(lost), float(glitches))
    levels = [-1 if level is None else LEVELS[level] for level in given.values()]
    return LineFaults(levels[0], levels[1], levels[2], int(swapped), float(lost), float(glitches))

"""Shortest curves of a base that turns no tighter than a radius: `dubins` forwards, `reeds_shepp` with reversing.

`Curves` holds one for each row; `poses(spacing)` samples one.
"""

from holonom.mobile.curves.curve import Curves
from holonom.mobile.curves.dubins import DUBINS_WORDS, dubins
from holonom.mobile.curves.reeds_shepp import REEDS_SHEPP_WORDS, reeds_shepp

__all__ = ["DUBINS_WORDS", "REEDS_SHEPP_WORDS", "Curves", "dubins", "reeds_shepp"]

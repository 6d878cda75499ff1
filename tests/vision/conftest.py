"""The photograph of the demo and its labels."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from coin_views import PHOTOGRAPH

from holonom.vision import load_photograph


class Labels(NamedTuple):
    centres: np.ndarray  # (24, 2) pixels
    classes: list[str]


@pytest.fixture(scope="session")
def photograph():
    return load_photograph(PHOTOGRAPH)


@pytest.fixture(scope="session")
def labels():
    """Read off the photograph by eye, six times enlarged, before any detector ran."""
    with (Path(__file__).parent / "coins_labelled.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    return Labels(np.array([[float(r["u"]), float(r["v"])] for r in rows]), [r["class"] for r in rows])

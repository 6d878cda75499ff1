"""Calibrations on OptiOdom's logs: errors before as published, on sets not seen, and published errors kept on demand.

How well a calibration fits the runs that it was made from says nothing of how good it is: no published column is to be
beaten there.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from functools import cache
from itertools import permutations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from holonom.app.calibrate.odometry import calibrate_odometry
from holonom.app.odometry_log import read_log
from holonom.errors import CalibrationError
from holonom.mobile.calibration import calibrate, dead_reckoning, drive_parameters, path_errors

HEADINGS = {  # OptiOdom, published_results: headings on the way and at the end before calibration, deg
    "tricyc/circular/140120211440": (107.129424, 101.338803),
    "tricyc/square/140120211446": (83.95621, 60.507896),
    "omni3/circular/221220201730": (7.112191, 6.478107),
    "omni4/circular/231220200510": (8.868256, 7.851371),
    "omni4/square/080920201205": (24.057278, None),  # at the end by a run that is not here
    "diff/square/230620202042": (4.66003, 3.302042),
    "diff/square/231220200045": (7.230344, 5.457208),
    "diff/ivanjko/231220200104": (7.091882, 2.601035),
}

# Every published method of every set that is here: distance (m) and heading (deg) on the way, and the same at the end.
PUBLISHED = [
    ("tricyc/circular/140120211440", "Kallasi", (0.145148, 6.247064, 0.053022, 3.675631)),
    ("tricyc/circular/140120211440", "Sousa", (0.129887, 7.378095, 0.037197, 7.091199)),
    ("tricyc/square/140120211446", "Kallasi", (0.212335, 24.208987, 0.082691, 0.558982)),
    ("tricyc/square/140120211446", "Sousa", (0.162686, 20.382705, 0.119447, 5.563135)),
    ("omni3/circular/221220201730", "Lin", (0.117556, 2.718219, 0.108121, 1.627792)),
    ("omni3/circular/221220201730", "Sousa", (0.071998, 9.901522, 0.059051, 9.80752)),
    ("omni4/circular/231220200510", "Lin", (0.037305, 6.480174, 0.02917, 0.971383)),
    ("omni4/circular/231220200510", "Sousa", (0.037665, 6.007475, 0.03031, 1.093602)),
    ("omni4/square/080920201205", "Lin", (0.058858, 8.196471, 0.046421, 0.606588)),
    ("omni4/square/080920201205", "Sousa", (0.052558, 8.353055, 0.028682, 2.42252)),
    ("diff/square/230620202042", "UMBmark", (0.022345, 1.760155, 0.007157, 0.874296)),
    ("diff/square/230620202042", "Jung", (0.026533, 3.745866, 0.024596, 2.355391)),
    ("diff/square/230620202042", "Sousa", (0.019036, 1.878044, 0.00716, 0.422518)),
    ("diff/square/231220200045", "UMBmark", (0.049823, 3.556827, 0.020285, 1.443283)),
    ("diff/square/231220200045", "Jung", (0.047447, 2.432634, 0.014547, 0.167984)),
    ("diff/square/231220200045", "Sousa", (0.043824, 2.651888, 0.023774, 0.498523)),
    (
        "diff/ivanjko/231220200104",
        "Ivanjko",
        (0.011552, 7.179304, 0.002426, 0.152058),
    ),
    (
        "diff/ivanjko/231220200104",
        "Sousa",
        (0.011532, 7.093278, 0.002799, 2.564843),
    ),
]
ROWS = [f"{p[0]} {p[1]}" for p in PUBLISHED]


_read = cache(lambda paths: read_log(paths))
_fits: dict[Any, Any] = {}


def _fit(runs, drive, nominal, **options):
    """Same runs, same options, same answer or refusal: fitted once for all tests of this file."""
    key = (id(runs), *((name, str(value)) for name, value in sorted(options.items())))
    if key not in _fits:
        try:
            _fits[key] = runs, calibrate(runs, drive, nominal, **options)
        except CalibrationError as error:
            _fits[key] = runs, error
    found = _fits[key][1]
    if isinstance(found, CalibrationError):
        raise found
    return found


@pytest.fixture(autouse=True)
def once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command reads and fits what it has not yet read and fitted."""
    monkeypatch.setattr("holonom.app.calibrate.odometry.read_log", lambda paths, **_: _read(tuple(paths)))
    monkeypatch.setattr("holonom.app.calibrate.odometry.calibrate", _fit)


@cache
def _as_asked_for_nothing(folder: Path) -> dict[str, Any]:
    """What the command answers without options, once for all tests."""
    return calibrate_odometry([folder]).data


@pytest.mark.parametrize("folder", HEADINGS)
def test_headings_before_calibration_are_the_published_ones(data_folder: Path, folder: str) -> None:
    data = _as_asked_for_nothing(data_folder / "odometry" / "optiodom" / folder)
    assert set(data["limits"].values()) == {None}  # plain least squares, unless limits are asked for
    assert data["growth"] == 0.0
    for our, their in zip(
        (data["errors_before"][key] for key in ("max_heading_deg", "max_final_heading_deg")),
        HEADINGS[folder],
        strict=True,
    ):
        assert their is None or our == pytest.approx(their, abs=1e-3)


ACROSS = [  # sets of one robot: calibrated by one, driven by the other
    ("diff/square/230620202042", "diff/square/231220200045"),
    ("diff/square/231220200045", "diff/square/230620202042"),
    ("tricyc/circular/140120211440", "tricyc/square/140120211446"),
    ("tricyc/square/140120211446", "tricyc/circular/140120211440"),
]


@pytest.mark.parametrize(("fitted", "other"), ACROSS, ids=[f"{a} on {b}" for a, b in ACROSS])
def test_a_calibration_holds_on_a_set_that_it_has_not_seen(data_folder: Path, fitted: str, other: str) -> None:
    """Distances of the other set, by the same robot on another day or path, become less than without calibration."""
    own, unseen = (_read((data_folder / "odometry" / "optiodom" / name,)) for name in (fitted, other))
    found = _fit(own.runs, own.drive, own.nominal, set_name="physical", rule="midpoint", limits=None, data_sheet=True)
    before, after = (
        path_errors(unseen.runs, [dead_reckoning(run, M) for run in unseen.runs])
        for M in (drive_parameters(own.drive, own.nominal).matrix(found.nominal), found.matrix)
    )
    assert after.distance < before.distance
    assert after.final_distance < before.final_distance


@pytest.mark.parametrize(("folder", "method", "published"), PUBLISHED, ids=ROWS)
def test_published_errors_are_kept_as_limits(data_folder: Path, folder: str, method: str, published) -> None:
    """All four columns of any published method at once, where they are asked for."""
    data = calibrate_odometry([data_folder / "odometry" / "optiodom" / folder], limits=published).data
    assert [data["errors_after"][key] <= limit for key, limit in zip(data["limits"], published, strict=True)] == [
        True
    ] * 4
    assert 0.0 <= data["growth"] < 0.51


@pytest.mark.parametrize(
    ("folder", "way", "end", "least"),
    [
        ("tricyc/square/140120211446", 20.382705, 0.558982, 1.129),
        ("diff/ivanjko/231220200104", 7.093278, 0.152058, 1.012),
    ],
)
def test_two_published_methods_no_odometry_beats_both(
    data_folder: Path, folder: str, way: float, end: float, least: float
) -> None:
    """Headings are linear in the motion matrix: a linear program finds the best of all, as multiple of the limits.

    Sousa's heading on the way and the other method's at the end; one of the two is worse for every matrix there is.
    """
    log = _read((data_folder / "odometry" / "optiodom" / folder,))
    sums = [np.cumsum(run.features, axis=0) for run in log.runs]
    A = np.concatenate([np.vstack([F / way, F[-1:] / end]) for F in sums])
    turned = [np.degrees(run.heading - run.heading[0]) for run in log.runs]
    b = np.concatenate([np.append(h / way, h[-1] / end) for h in turned])
    up = -np.ones((len(b), 1))
    best = linprog([0.0, 0.0, 1.0], np.block([[A, up], [-A, up]]), np.append(b, -b), bounds=(None, None))
    assert best.status == 0
    assert best.fun == pytest.approx(least, abs=1e-3)
    limits = [np.inf, np.radians(way), np.inf, np.radians(end)]
    with pytest.raises(CalibrationError, match=r"no extended parameters near the least squares keep|does not tell"):
        calibrate(log.runs, log.drive, log.nominal, set_name="extended", limits=limits)


COLUMNS = {  # of published_results: heading -> our name
    "differential": {"L (m)": "wheelbase", "D(1): Dr (m)": "diameter_right", "D(2): Dl (m)": "diameter_left"},
    "tricycle": {"L (m)": "wheelbase", "D (m)": "diameter", "θoff (º)": "steering_offset"},
    "mecanum": {
        "L1 + L2 (m)": "wheelbase_plus_track", "D1 (m)": "diameter_front_left", "D2 (m)": "diameter_front_right",
        "D3 (m)": "diameter_rear_left", "D4 (m)": "diameter_rear_right",
    },
}  # fmt: skip


def published(folder: Path, name: str, drive: str) -> Iterator[tuple[str, dict[str, float]]]:
    """Method and parameters that were published for a set, those in numbers."""
    for file in sorted((folder / "published_results").glob(f"{name.split('/')[0]}-*.csv")):
        rows = list(csv.reader(file.read_text(encoding="utf-8").splitlines()))
        first = rows[0].index("Robot Final Parameters")
        last = rows[0].index("Evaluation Measures", first)
        for row in rows[2:]:
            if row and row[0].startswith(name) and all(row[first:last]):
                cells = zip(rows[1][first:last], row[first:last], strict=True)
                found = {COLUMNS[drive][head]: float(cell) for head, cell in cells if head in COLUMNS[drive]}
                if "steering_offset" in found:
                    found["steering_offset"] = float(np.radians(found["steering_offset"]))
                yield file.stem, found


DIFF = "diff/square/230620202042", "diff/square/231220200045", "diff/ivanjko/231220200104"
TRICYCLE = "tricyc/circular/140120211440", "tricyc/square/140120211446"
MECANUM = "omni4/circular/231220200510", "omni4/square/080920201205"
UNSEEN = [pair for group in (DIFF, TRICYCLE, MECANUM) for pair in permutations(group, 2)]


@pytest.mark.parametrize(("fitted", "other"), UNSEEN, ids=[f"{a} on {b}" for a, b in UNSEEN])
def test_mean_end_errors_on_the_other_set_beside_published_parameters(
    data_folder: Path, fitted: str, other: str
) -> None:
    """Calibrated as the command does unless asked otherwise; published parameters of the training set, by us.

    The best of them on the other set is what is compared with, whichever method it is, as nobody could have known.
    """
    folder = data_folder / "odometry" / "optiodom"
    own, unseen = (_read((folder / name,)) for name in (fitted, other))
    data = _as_asked_for_nothing(folder / fitted)
    found = drive_parameters(own.drive, own.nominal, data["set"])
    calibrated = found.matrix(np.array([data["calibrated"][name] for name in found.names]))

    def mean_end(runs, matrix: np.ndarray) -> float:
        return float(path_errors(runs, [dead_reckoning(run, matrix) for run in runs]).final_distances.mean())

    matrices = []
    for _, values in published(folder, fitted, own.drive):
        p = drive_parameters(own.drive, values)
        matrices.append(p.matrix(p.nominal))
    best = min(mean_end(unseen.runs, M) for M in matrices)
    assert mean_end(unseen.runs, calibrated) <= 1.1 * best

"""UMBmark: squares of a base whose errors are known, published results, and what is refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from calibration_runs import NOMINAL, square, values, wandering

from holonom.app.odometry_log import read_log
from holonom.errors import CalibrationError, OutOfLimits, UnknownName
from holonom.mobile.calibration import Run, umbmark

NAMES = NOMINAL["differential"]


@pytest.mark.parametrize("form", ["x", "y", "mean"])
def test_known_errors_come_out(form: str) -> None:
    """Wheelbase 0.4 % and diameters 0.1 % off: found to the second order in them."""
    truth = np.array([0.2008, 0.08404, 0.08396])
    runs = [square(2.0, sense, truth) for sense in (-1, 1)]
    found = umbmark(runs, NAMES, 2.0, form=form)
    assert np.allclose(values(found.calibrated), truth, rtol=3e-4)
    assert found.E_b == pytest.approx(truth[0] / 0.2, abs=3e-4)
    assert found.E_d == pytest.approx(truth[2] / truth[1], abs=3e-5)
    assert found.E_max[1] < 0.1 * found.E_max[0]
    assert found.after.final_distance < 0.1 * found.before.final_distance


def test_a_base_without_errors_stays_as_it_is() -> None:
    found = umbmark([square(2.0, s, values(NAMES)) for s in (-1, 1)], NAMES, 2.0)
    assert np.allclose(values(found.calibrated), values(NAMES), rtol=1e-12)
    assert (found.E_b, found.E_d) == pytest.approx((1.0, 1.0), abs=1e-12)


def test_where_the_square_lies_does_not_matter() -> None:
    truth = np.array([0.2008, 0.08404, 0.08396])
    runs = [square(2.0, sense, truth) for sense in (-1, 1)]
    c, s = np.cos(0.7), np.sin(0.7)
    turned = [
        Run(
            r.name,
            r.time,
            r.turns,
            r.truth @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + [3.0, -2.0, 0.7],
            r.steering,
        )
        for r in runs
    ]
    assert np.allclose(values(umbmark(turned, NAMES, 2.0).calibrated), values(umbmark(runs, NAMES, 2.0).calibrated))


PUBLISHED = [  # OptiOdom, published_results/diff-UMBmark.csv: L, D left, D right; the four errors before and after
    ("230620202042", 0.201458, 0.084046, 0.083954, (0.035057, 4.66003, 0.033256, 3.302042),
     (0.022345, 1.760155, 0.007157, 0.874296)),
    ("231220200045", 0.201638, 0.084024, 0.083976, (0.101571, 7.230344, 0.10144, 5.457208),
     (0.049823, 3.556827, 0.020285, 1.443283)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "b", "left", "right", "before", "after"), PUBLISHED, ids=[p[0] for p in PUBLISHED])
def test_published_results(data_folder: Path, name, b, left, right, before, after) -> None:
    log = read_log([data_folder / "odometry" / "optiodom" / "diff" / "square" / name])
    assert log.side is not None
    found = umbmark(log.runs, log.nominal, log.side)
    assert np.allclose(values(found.calibrated), [b, left, right], atol=1e-6)
    assert found.E_b == pytest.approx(b / 0.2, abs=1e-5)
    assert found.E_d == pytest.approx(right / left, abs=1e-5)
    for errors, published in ((found.before, before), (found.after, after)):
        ours = errors.distance, np.degrees(errors.heading), errors.final_distance, np.degrees(errors.final_heading)
        assert np.allclose(ours, published, atol=1e-6)


def test_deviations_come_from_the_spread_of_the_runs(data_folder: Path) -> None:
    """Leaving out runs moves the result by about as much as the deviations say."""
    log = read_log([data_folder / "odometry" / "optiodom" / "diff" / "square" / "230620202042"])
    full = umbmark(log.runs, log.nominal, 0.75)
    fewer = [umbmark([r for r in log.runs if r is not out], log.nominal, 0.75) for out in log.runs]
    moved = np.std([f.E_b for f in fewer]) * np.sqrt(5)  # jackknife
    assert 0.3 < full.deviations["E_b"] / moved < 3.0
    assert "3 clockwise, 3 counter-clockwise; 5 each way are usual" in full.notes[0]
    one_each = umbmark([log.runs[0], log.runs[-1]], log.nominal, 0.75)
    assert np.isnan(one_each.deviations["E_b"])


def test_what_is_no_umbmark_is_refused() -> None:
    cw, ccw = (square(2.0, sense, values(NAMES)) for sense in (-1, 1))
    straight = Run("line", cw.time[:400], cw.turns[:400], cw.truth[:400], cw.steering[:400])
    blind = Run("blind", cw.time, cw.turns, np.empty((0, 3)), cw.steering)
    unequal = {**NAMES, "diameter_left": 0.085}
    for runs, nominal, side, form, problem, match in (
        ([cw, cw], NAMES, 2.0, "x", CalibrationError, "2 run.* all clockwise: .* drive some counter-clockwise, 5 are"),
        ([ccw], NAMES, 2.0, "x", CalibrationError, "all counter-clockwise"),
        ([], NAMES, 2.0, "x", CalibrationError, "no run came; UMBmark needs squares both ways"),
        ([cw, ccw, straight], NAMES, 2.0, "x", CalibrationError, "run line turned by 0 degrees .* closed squares"),
        ([cw, blind], NAMES, 2.0, "x", CalibrationError, "blind has no ground truth"),
        ([cw, ccw], unequal, 2.0, "x", CalibrationError, "equal diameters"),
        ([cw, ccw], {"wheelbase": 0.2}, 2.0, "x", CalibrationError, "a differential has wheelbase, diameter_left"),
        ([cw, ccw], NAMES, 0.0, "x", OutOfLimits, "above zero"),
        ([cw, ccw], NAMES, 2.0, "z", UnknownName, "form of UMBmark 'z'"),
    ):
        with pytest.raises(problem, match=match):
            umbmark(runs, nominal, side, form=form)


def test_a_wandering_run_is_no_square() -> None:
    run = wandering("differential", values(NAMES), "physical", seed=1)
    with pytest.raises(CalibrationError, match="UMBmark needs closed squares"):
        umbmark([run], NAMES, 2.0)

"""How errors of wheels grow: propagation against simulated runs, and against closed forms of the textbook."""

from __future__ import annotations

import numpy as np
import pytest
from base_runs import BASES

from holonom.errors import OutOfLimits, UnknownName
from holonom.mobile.calibration import CAUSES, Run, error_growth, standard_run


@pytest.mark.parametrize("kind", BASES)
def test_propagation_agrees_with_simulated_runs(kind: str) -> None:
    """10 m straight, a square of 2 m, a spin, as far as the base can drive them.

    Where a cause has no effect of first order, what is left is of second order, two causes of a degree each.
    """
    base, drove = BASES[kind], []
    for name in ("straight", "square", "spin"):
        run = standard_run(base, name)
        if run is None:
            continue
        drove.append(name)
        way = np.hypot(*np.diff(run.truth[:, :2], axis=0).T).sum()
        for cause in CAUSES:
            told, seen = error_growth(base, run, cause, runs=400)
            ours, theirs = (np.array([np.hypot(*v[:2]), v[2]]) for v in (told, seen))
            second = cause == "mounting"
            floors = ((5e-3 if second else 1e-4) * way + 1e-3, 0.035 if second else 1e-4)
            for a, b, least in zip(ours, theirs, floors, strict=True):
                assert a == pytest.approx(b, rel=0.15, abs=0.0 if a > least else least), (name, cause)
    assert "straight" in drove


def test_a_differential_drive_on_a_straight_line_by_the_textbook() -> None:
    """Radii that differ by r: heading `sqrt(2) r way / track`, sideways half of that times the way; slip as a walk."""
    base = BASES["differential"]
    run = standard_run(base, "straight")
    assert run is not None
    along, across, turn = error_growth(base, run, "radius", 1e-4, runs=2).propagated
    assert along == pytest.approx(10.0 * 1e-4 / np.sqrt(2.0), rel=1e-6)
    assert turn == pytest.approx(np.sqrt(2.0) * 1e-4 * 10.0 / 0.3, rel=1e-6)
    assert across == pytest.approx(0.5 * 10.0 * turn, rel=1e-2)
    along, across, turn = error_growth(base, run, "slip", 1e-2, runs=2).propagated
    assert along == pytest.approx(1e-2 * np.sqrt(10.0 / 2.0), rel=1e-6)
    assert turn == pytest.approx(1e-2 * np.sqrt(2.0 * 10.0) / 0.3, rel=1e-6)
    assert across == pytest.approx(10.0 * turn / np.sqrt(3.0), rel=1e-2)


def test_a_base_that_stands_and_wrong_words() -> None:
    base = BASES["omni"]
    still = Run("still", np.arange(3.0), np.zeros((3, 5)), np.empty((0, 3)), np.empty((3, 0)))
    told, seen = error_growth(base, still, "slip")
    assert told == pytest.approx(np.zeros(3), abs=1e-9)
    assert seen == pytest.approx(np.zeros(3), abs=1e-9)
    with pytest.raises(UnknownName, match="there is mounting, radius, slip"):
        error_growth(base, still, "wind")
    with pytest.raises(OutOfLimits, match=r"a size of 0\.0"):
        error_growth(base, still, "radius", 0.0)

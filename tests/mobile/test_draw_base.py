"""Drawings of bases show what is so."""

import numpy as np
import pytest
from bases import presets

from holonom.errors import OutOfLimits, OutputError, ShapeError

pytest.importorskip("matplotlib", reason="Matplotlib is not installed; pip install -e '.[plots]'")

from holonom.plots.base import draw_base

BASES = presets()


def labels(figure):
    return {t.get_text() for t in figure.legends[0].get_texts()}


@pytest.mark.parametrize("name", sorted(BASES))
def test_every_base_is_drawn(name, tmp_path):
    base = BASES[name]
    v = base.feasible([0.4, 0.1, 0.6])
    figure = draw_base(base, v, save=tmp_path / "base.png")
    assert (tmp_path / "base.png").stat().st_size > 10_000
    written = {t.get_text() for t in figure.axes[0].texts}
    assert {w.name for w in base.wheels} <= written
    assert ("axles: no sliding along them" in labels(figure)) == any(
        w.name in base.sliding_names and w.kind not in ("skid", "ball") for w in base.wheels
    )
    assert ("support polygon" in labels(figure)) == (name not in ("sphere", "segway", "bicycle"))
    draw_base(base, names=False)


def test_names_do_not_lie_on_each_other():
    for name in ("soccer", "mecanum", "swerve", "ackermann", "differential"):
        figure = draw_base(BASES[name], BASES[name].feasible([0.4, 0.1, 0.6]))
        figure.canvas.draw()
        boxes = [t.get_window_extent() for t in figure.axes[0].texts if t.get_text()]
        for i, a in enumerate(boxes):
            for b in boxes[i + 1 :]:
                assert not a.overlaps(b), name


def test_the_axles_meet_where_the_centre_is_marked():
    figure = draw_base(BASES["ackermann"], [1.0, 0.0, 0.25])
    lines = {line.get_label(): line for line in figure.axes[0].lines}
    centre = np.ravel(lines["centre of rotation"].get_xydata())
    np.testing.assert_allclose(centre, [-4.0, 0.0], atol=1e-9)  # 4 m to the left
    dashed = [line.get_xydata() for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    assert len(dashed) == 4
    for a, b in dashed:
        t = (b - a) / np.linalg.norm(b - a)
        assert abs(t[0] * (centre - a)[1] - t[1] * (centre - a)[0]) < 1e-9
    assert "centre of rotation" not in labels(draw_base(BASES["ackermann"], [1.0, 0.0, 0.0]))


def test_what_cannot_be_drawn_is_refused(tmp_path):
    with pytest.raises(OutOfLimits, match="sideways"):
        draw_base(BASES["differential"], [0.0, 1.0, 0.0])
    with pytest.raises(ShapeError, match="one twist"):
        draw_base(BASES["mecanum"], np.zeros((2, 3)))
    with pytest.raises(ShapeError, match="one set of angles"):
        draw_base(BASES["swerve"], steering=np.zeros((2, 4)))
    with pytest.raises(OutputError):
        draw_base(BASES["mecanum"], save=tmp_path / "no" / "base.png")

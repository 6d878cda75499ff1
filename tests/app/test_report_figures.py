"""Maps and polar plots of the report: their points are the numbers', to scale."""

from __future__ import annotations

import re

import numpy as np
import pytest

from holonom.app.report import Figures, MapLine, MapMark, MapPatch, Polar, PolarLine, Table, TopView
from holonom.app.report.drawing.figures import figures_html
from holonom.app.report.drawing.polar import polar_svg
from holonom.app.report.drawing.topview import topview_svg


def points(svg: str, tag: str) -> list[np.ndarray]:
    found = re.findall(rf'<{tag}[^>]*points="([^"]*)"', svg)
    return [np.array([p.split(",") for p in text.split()], dtype=float) for text in found]


@pytest.mark.parametrize("scale", [0.03, 1.0, 3.17, 480.0])
def test_polar_plot_is_to_scale_with_x_forwards_and_y_to_the_left(scale: float) -> None:
    angles = np.radians([0.0, 90.0, 180.0, 270.0])
    values = scale * np.array([1.0, 0.5, 0.25, 0.75])
    svg = polar_svg(Polar("reach", "m/s", [PolarLine("all", angles, values, "#000")]))
    (line,) = points(svg, "polygon")
    away = line - 160.0
    assert away[0, 1] < 0.0  # forwards is up
    assert away[1, 0] < 0.0  # left is left
    rings = [float(r) for r in re.findall(r'<circle class="grid"[^>]*r="([\d.]+)"', svg)]
    shown = [float(v.split()[0]) for v in re.findall(r'<text class="value"[^>]*>([^<]*)<', svg)]
    assert 1 <= len(rings) <= 4
    assert np.allclose(np.hypot(*away.T) / rings[-1] * shown[-1], values, rtol=0.01, atol=0.002 * scale)
    assert shown[-1] >= 0.99 * scale


def test_map_is_to_scale_and_upright() -> None:
    square = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
    patch = MapPatch("ice <1>", square[:3], "#bfe3f5")
    view = TopView(
        "map", [MapLine("driven", square, "#000", dashed=True)], [patch], [MapMark("here", (2.0, 1.0), "#f00")]
    )
    svg = topview_svg(view)
    (line,) = points(svg, "polyline")
    right, up = line[1] - line[0], line[2] - line[1]
    assert right[0] == pytest.approx(2.0 * -up[1], rel=1e-3)
    assert right[1] == up[0] == 0.0
    assert up[1] < 0.0
    assert "ice &lt;1&gt;" in svg
    assert "-0" not in re.findall(r'<text class="value"[^>]*>([^<]*)<', svg)
    (mark,) = re.findall(r'<circle cx="([\d.]+)" cy="([\d.]+)"', svg)
    assert np.allclose(np.array(mark, dtype=float), line[2], atol=0.1)


def test_a_section_shows_its_tables_and_escapes_them() -> None:
    page = figures_html(Figures("faults", "Faults", [Table(("what", "when"), [("<slip>", "1 s")])], "a note"))
    assert '<section id="faults"' in page
    assert "<td>&lt;slip&gt;</td><td>1 s</td>" in page
    assert "a note" in page


@pytest.mark.parametrize("end", [(0.0, 0.0), (0.0, 3.0), (3.0, 0.0), (1e-4, 2e-4), (1.0, 0.4)])
def test_a_map_of_any_path_has_a_size_for_the_page(end: tuple[float, float]) -> None:
    """Also of a base that stands, or drives sideways only; a metre is as long either way."""
    path = np.linspace((0.0, 0.0), end, 20)
    svg = topview_svg(TopView("map", [MapLine("driven", path, "#000")]))
    width, height = (float(number) for number in re.search(r'viewBox="0 0 (\S+) (\S+)"', svg).groups())
    assert height <= width
    (line,) = points(svg, "polyline")
    assert (line >= 0.0).all()
    assert (line <= [width, height]).all()
    if max(end) > 0.5:
        assert np.ptp(line, axis=0).max() > 0.5 * width or end[0] == 1.0
        assert np.ptp(line[:, 0]) * end[1] == pytest.approx(np.ptp(line[:, 1]) * end[0], rel=1e-2)

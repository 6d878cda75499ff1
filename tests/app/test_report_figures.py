"""Maps and polar plots of the report: their points are the numbers', to scale."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from report_jobs import arm_job, base_job, job_of

from holonom.app.recording import FrameTrack, Recording
from holonom.app.recording.tracks import Track
from holonom.app.report import Figures, MapLine, MapMark, MapPatch, Polar, PolarLine, Table, TopView
from holonom.app.report.attachments import cell_facts
from holonom.app.report.drawing.figures import figures_html
from holonom.app.report.drawing.labels import AWAY, Box, Room
from holonom.app.report.drawing.polar import polar_svg
from holonom.app.report.drawing.robot_map import MapRobot, robot_corners
from holonom.app.report.drawing.topview import legend_of, topview_svg
from holonom.app.report.findings.base_outline import castors_along, margin_of, outline_of, stations
from holonom.app.report.findings.castor_frames import castor_frames
from holonom.mobile import WheelBase, ackermann, differential, omni


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


# ---------------------------------------------------------------- robots on a map


def tricycle() -> WheelBase:
    """Two driven wheels in front of a castor."""
    return differential(track=0.4, wheel_radius=0.08, castor=(-0.3, 0.0), castor_offset=0.05, mass=20.0)


def circle(base_radius: float = 1.0, rate: float = 0.5, count: int = 400) -> tuple[Recording, np.ndarray, np.ndarray]:
    """A base that drives around (0, 1) to the left: recording, times and poses."""
    time = np.linspace(0.0, 4.0, count)
    turn = rate * time
    pose = np.stack([base_radius * np.sin(turn), base_radius * (1.0 - np.cos(turn)), turn], axis=1)
    twist = np.tile([rate * base_radius, 0.0, rate], (count, 1))
    return Recording(tracks={"/truth/odom": Track(time, {"pose": pose, "twist": twist})}), time, pose


def test_an_outline_has_the_wheels_where_they_are() -> None:
    base = tricycle()
    outline = outline_of(base)
    assert np.allclose(sorted(w.place for w in outline.wheels), [(-0.35, 0.0), (0.0, -0.2), (0.0, 0.2)])
    castor = next(wheel for wheel in outline.wheels if wheel.pivot is not None)
    assert castor.pivot == pytest.approx((-0.3, 0.0))
    assert len(outline.support) == 3
    assert margin_of(base) == pytest.approx(0.0, abs=1e-9)
    corners = robot_corners(MapRobot(outline, np.array([1.0, 2.0, np.pi / 2])))
    assert corners[:, 1].max() > 2.0 + 0.08  # it looks along y
    assert np.ptp(corners[:, 0]) == pytest.approx(np.ptp(outline.skin[:, 1]), rel=1e-9)


def test_castors_trail_behind_their_pivots() -> None:
    base = tricycle()
    _, _, pose = circle()
    turned = castors_along(base, pose)
    straight = np.zeros((200, 3))
    straight[:, 0] = np.linspace(0.0, 2.0, 200)
    assert np.allclose(castors_along(base, straight), 0.0)
    # on a circle the wheel's axle points to the middle in the end: offset and distance of the pivot make the angle
    pivot = np.hypot(0.3, 1.0)
    track = np.sqrt(pivot**2 - 0.05**2)
    outline = outline_of(base, turned[-1])
    place = next(np.array(w.place) for w in outline.wheels if w.pivot)
    assert np.hypot(place[0], place[1] - 1.0) == pytest.approx(track, abs=2e-3)


def test_castors_of_the_replay_turn_with_those_on_the_map() -> None:
    base, (_, time, pose) = tricycle(), circle()
    half = 0.5 * pose[:, 2]
    places = np.column_stack([pose[:, :2], 0.0 * time])
    frame = FrameTrack(time, places, np.stack([0.0 * half, 0.0 * half, np.sin(half), np.cos(half)], axis=1))
    job = dataclasses.replace(base_job("agv"), base=base)
    facts = cell_facts(job_of(job, arm_job("puma"))).robots
    found = castor_frames({"agv/base_link": frame, "puma/link1": frame}, facts)
    assert set(found) == {"agv/castor_1"}
    T = found["agv/castor_1"].poses()
    offset = next(wheel.castor_offset for wheel in base.wheels if wheel.kind == "castor")
    wheels = (T @ [offset, 0.0, 0.0, 1.0])[:, :2]
    turned = castors_along(base, pose)
    for k in (0, 100, 399):
        castor = next(w for w in outline_of(base, turned[k]).wheels if w.pivot)
        c, s = np.cos(pose[k, 2]), np.sin(pose[k, 2])
        assert np.allclose(wheels[k], pose[k, :2] + np.array([[c, -s], [s, c]]) @ castor.place, atol=1e-9)
    assert castor_frames({}, facts) == {}


def test_a_base_stands_on_its_map_with_its_centre_of_rotation() -> None:
    recording, time, pose = circle()
    found = stations(tricycle(), recording, time, pose)
    assert (found[0].name, found[-1].name) == ("start", "end, 4.0 s")
    assert 3 <= len(found) <= 6
    assert np.allclose([robot.centre for robot in found], [(0.0, 1.0)] * len(found), atol=1e-6)
    away = np.diff([robot.pose[2] for robot in found])
    assert np.allclose(away, away[0], atol=0.02)  # as far apart along the path
    view = TopView("map", [MapLine("driven", pose[:, :2], "#000")], robots=found)
    svg = topview_svg(view)
    assert svg.count('class="robot"') == svg.count('class="skin"') == len(found)
    assert svg.count('class="wheel"') == 3 * len(found)
    assert svg.count('class="support"') == len(found)
    assert {"driven wheel", "support polygon", "centre of mass", "centre of rotation"} < set(dict(legend_of(view)))
    straight = Recording(tracks={"/truth/odom": Track(time, {"pose": pose, "twist": np.tile([1.0, 0, 0], (400, 1))})})
    assert {robot.centre for robot in stations(tricycle(), straight, time, pose)} == {None}
    (still,) = stations(tricycle(), straight, time, 0.0 * pose)
    assert still.name == "4.0 s"


def test_steered_wheels_stand_across_the_way_to_the_centre() -> None:
    base = ackermann(wheelbase=0.5, track=0.3, wheel_radius=0.05, mass=10.0)
    recording, time, pose = circle()
    front = [w for w in stations(base, recording, time, pose)[-1].outline.wheels if w.place[0] > 0.1]
    assert front
    for wheel in front:
        across = np.array([0.0, 1.0]) - wheel.place
        assert across @ [np.cos(wheel.heading), np.sin(wheel.heading)] == pytest.approx(0.0, abs=1e-6)


def test_what_has_to_balance_has_no_support_polygon() -> None:
    base = WheelBase(differential(track=0.4, wheel_radius=0.08).wheels[:2])
    assert outline_of(base).support is None
    assert margin_of(base) is None


def test_names_stand_clear_of_lines_and_each_other() -> None:
    room = Room(400.0, 400.0)
    line = np.array([[0.0, 200.0], [400.0, 200.0]])
    room.cross(line)
    places = [room.place((200.0, 200.0), (60.0, 14.0)) for _ in range(6)]
    boxes = [Box(p.x - 30, p.y - 7, p.x + 30, p.y + 7) for p in places]
    for i, box in enumerate(boxes):
        assert box.y2 <= 200.0 or box.y1 >= 200.0
        assert box.x1 >= 0
        assert box.x2 <= 400
        assert all(box.overlap(other) == 0.0 for other in boxes[i + 1 :])
    assert abs(places[0].y - 200.0) < AWAY[1] + 8
    assert not places[0].far
    assert places[-1].far


def test_a_name_at_the_edge_stays_in_the_drawing() -> None:
    place = Room(200.0, 100.0).place((199.0, 1.0), (80.0, 14.0))
    assert 40.0 <= place.x <= 160.0
    assert 7.0 <= place.y <= 93.0


def test_every_tick_of_a_map_has_its_unit() -> None:
    svg = topview_svg(TopView("map", [MapLine("driven", np.array([[0.0, 0.0], [2.0, 1.0]]), "#000")]))
    texts = re.findall(r'<text class="value[^"]*"[^>]*>([^<]*)<', svg)
    assert len(texts) > 6
    assert all(text.endswith(" m") for text in texts)


def test_values_of_rings_stand_clear_of_the_lines() -> None:
    angles = np.linspace(0.0, 2.0 * np.pi, 181)
    spike = np.where(np.abs(angles - np.radians(337.5)) < 0.2, 1.0, 0.4)  # where they stood before
    svg = polar_svg(Polar("reach", "m/s", [PolarLine("all", angles, spike, "#000")]))
    at = re.findall(r'<text class="value" x="([\d.]+)"', svg)
    assert all(float(x) <= 160.0 or float(x) > 175.0 for x in at)


def test_a_base_with_omni_wheels_is_drawn() -> None:
    outline = outline_of(omni(np.radians([60.0, 180.0, 300.0]), radius=0.2, wheel_radius=0.05))
    assert outline.com is None  # nothing is known of its mass
    assert len(outline.wheels) == 3

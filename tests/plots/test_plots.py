"""Figures hold what they say: lengths, ellipsoids, places; no global state; errors by name."""

from __future__ import annotations

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from holonom.errors import InputError, OutOfLimits, OutputError, ShapeError, UnknownName
from holonom.mechanics import Arm, load_arm
from holonom.mechanics.analysis import manipulability, velocity_ellipsoid
from holonom.mechanics.motion import plan_joint
from holonom.plots import arm_page, draw_arm, draw_ellipsoids, draw_manipulability, draw_profiles, draw_workspace
from holonom.plots.ellipsoids import _surface
from holonom.plots.skeleton import sticks

pytest.importorskip("matplotlib", reason="Matplotlib is not installed; pip install -e '.[plots]'")
pytest.importorskip("plotly", reason="Plotly is not installed; pip install -e '.[plots]'")
Q = np.array([0.4, 0.9, -2.8, 0.3, 0.7, 0.1])


@pytest.fixture(scope="module")
def puma() -> Arm:
    return load_arm("puma560")


@pytest.fixture(scope="module")
def planar() -> Arm:
    return load_arm("planar2r")


def test_sticks_are_rigid_and_go_from_base_to_tool(puma: Arm) -> None:
    rng = np.random.default_rng(0)
    lengths = []
    for q in rng.uniform(-1, 1, (5, 6)):
        frames = puma.frames(q)
        (line,) = sticks(puma, frames)
        np.testing.assert_allclose(line[[0, -1]], frames[[0, -1], :3, 3])
        lengths.append(np.linalg.norm(np.diff(line, axis=0), axis=1))
    np.testing.assert_allclose(lengths, np.broadcast_to(lengths[0], np.shape(lengths)), atol=1e-12)


def test_branches_are_drawn_once_each_from_where_they_leave(puma: Arm) -> None:
    joints = tuple(
        dataclasses.replace(j, parent=p) for j, p in zip(puma.model.joints, (-1, 0, 1, 1, 3, 3), strict=True)
    )
    tree = Arm(dataclasses.replace(puma.model, name="branched", joints=joints, tip=2))
    frames = tree.frames(Q)
    lines = sticks(tree, frames)
    assert len(lines) == 3
    np.testing.assert_allclose(lines[0][-1], frames[-1, :3, 3])
    np.testing.assert_allclose([lines[1][0], lines[2][0]], [frames[2, :3, 3], frames[4, :3, 3]])


def test_the_ellipsoid_is_what_unit_joint_rates_reach(puma: Arm) -> None:
    ellipsoid, J = velocity_ellipsoid(puma, Q), puma.jacobian(Q)[:3]
    surface = _surface(ellipsoid, ellipsoid.radii).reshape(-1, 3)
    np.testing.assert_allclose(np.einsum("ki,ij,kj->k", surface, np.linalg.inv(J @ J.T), surface), 1.0, rtol=1e-9)
    figure = draw_ellipsoids(puma, Q)
    assert [axes.get_title().split(":")[0] for axes in figure.axes] == ["velocity", "force"]
    assert f"{ellipsoid.radii[0]:.3g}" in figure.axes[0].get_title()


def test_an_arm_is_drawn_where_it_is(puma: Arm, tmp_path: Path) -> None:
    figure = draw_arm(puma, np.stack([Q + 0.3, Q]), save=tmp_path / "arm.png")
    (axes,) = figure.axes
    assert axes.get_title() == "puma560"
    assert {text.get_text() for text in axes.texts} == {"base", "tool"}
    assert len(axes.lines) == 2 * 2 + 2 * 3
    for low, high, p in zip(
        *np.transpose([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()]), puma.fk(Q)[:3, 3], strict=True
    ):
        assert low < p < high
    assert (tmp_path / "arm.png").stat().st_size > 10_000


def test_a_planar_arm_reaches_a_disc(planar: Arm) -> None:
    """Two links of equal length reach every place within their sum, and no more."""
    figure = draw_workspace(planar, plane="xz", samples=60_000, cells=40)
    axes = figure.axes[0]
    (picture,) = axes.images
    west, east, south, north = picture.get_extent()
    found = np.ma.filled(picture.get_array(), np.nan)
    rows, columns = found.shape
    z, x = np.meshgrid(
        south + (north - south) * (np.arange(rows) + 0.5) / rows,
        west + (east - west) * (np.arange(columns) + 0.5) / columns,
        indexing="ij",
    )
    long = sum(np.linalg.norm(np.array(joint.after)[:3, 3]) for joint in planar.model.joints)
    tool = np.linalg.norm(np.array(planar.model.tool)[:3, 3])
    side = (east - west) / columns
    r = np.hypot(x, z)
    assert np.isfinite(found[r < long + tool - 2 * side]).mean() > 0.99
    assert not np.isfinite(found[r > long + tool + 2 * side]).any()


def test_the_map_of_manipulability(puma: Arm) -> None:
    figure = draw_manipulability(puma, Q, joints=(1, 2), samples=41)
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("shoulder (rad)", "elbow (rad)")
    np.testing.assert_allclose(axes.lines[0].get_xydata(), [[0.9, -2.8]])
    assert axes.get_xlim() == (puma.limits.lower[1], puma.limits.upper[1])
    top = figure.axes[1].get_ylim()[1]
    grid = np.broadcast_to(Q, (41, 41, 6)).copy()
    grid[..., 1], grid[..., 2] = np.meshgrid(
        *(np.linspace(puma.limits.lower[k], puma.limits.upper[k], 41) for k in (1, 2))
    )
    assert top == pytest.approx(manipulability(puma, grid).max(), rel=0.1)


def test_profiles_beside_their_limits(puma: Arm) -> None:
    motion = plan_joint(Q, Q + 0.3, puma.limits)
    figure = draw_profiles(motion, puma.limits, names=puma.limits.names)
    q, qd, qdd = figure.axes
    np.testing.assert_array_equal(q.lines[2].get_ydata(), motion.q[:, 2])
    np.testing.assert_array_equal(qd.lines[1].get_ydata(), motion.qd[:, 1] / puma.limits.speed[1])
    np.testing.assert_array_equal(qdd.lines[5].get_xdata(), motion.dt * np.arange(len(motion.q)))
    assert [line.get_ydata()[0] for line in qdd.lines[6:]] == [-1.0, 1.0]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(puma.limits.names)
    assert [len(axes.lines) for axes in draw_profiles(motion).axes] == [6, 6, 6]


def test_a_page_holds_all_it_needs(puma: Arm, tmp_path: Path) -> None:
    motion = plan_joint(Q, Q + 0.3, puma.limits)
    figure = arm_page(puma, motion, steps=20, save=tmp_path / "arm.html")
    assert len(figure.frames) == len(figure.layout.sliders[0].steps) == 20
    assert figure.layout.sliders[0].steps[-1].label == f"{motion.duration:.2f} s"
    np.testing.assert_allclose([figure.data[1].x[-1], figure.data[1].z[-1]], puma.fk(Q + 0.3)[[0, 2], 3])
    text = (tmp_path / "arm.html").read_text("utf-8")
    assert "<script src=" not in text
    assert "plotly.js v" in text
    assert not arm_page(puma, Q).frames[1:]


def test_nothing_touches_pyplot() -> None:
    code = (
        "import sys, holonom as hm; arm = hm.load_arm('puma560');"
        "assert 'matplotlib' not in sys.modules; hm.plots.draw_arm(arm, [0.0] * 6);"
        "assert 'matplotlib' in sys.modules; assert 'matplotlib.pyplot' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_bad_input(puma: Arm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ShapeError, match=r"q has shape \(5,\); give one finite configuration \(6,\)"):
        draw_arm(puma, Q[:5])
    with pytest.raises(OutputError, match=r"absent.*cannot be written"):
        draw_arm(puma, Q, save=tmp_path / "absent" / "arm.png")
    with pytest.raises(OutputError, match=r"arm\.xyz.*cannot be written"):
        draw_arm(puma, Q, save=tmp_path / "arm.xyz")
    with pytest.raises(OutputError, match=r"page .*absent.*cannot be written"):
        arm_page(puma, Q, save=tmp_path / "absent" / "arm.html")
    with pytest.raises(UnknownName, match="no plane 'ab'; there is xy, xz, yz"):
        draw_workspace(puma, plane="ab")  # type: ignore[arg-type]
    with pytest.raises(OutOfLimits, match="no configuration brings the tool to y = 9 m"):
        draw_workspace(puma, at=9.0, samples=1000)
    with pytest.raises(OutOfLimits, match="two different numbers from 0 to 5"):
        draw_manipulability(puma, Q, joints=(1, 6))
    with pytest.raises(ShapeError, match="2 names for 6 joints"):
        draw_profiles(plan_joint(Q, Q, puma.limits), names=["a", "b"])
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(InputError, match=r"a figure needs Matplotlib, .*pip install -e '.\[plots\]'"):
        draw_arm(puma, Q)
    monkeypatch.setitem(sys.modules, "plotly.graph_objects", None)
    with pytest.raises(InputError, match=r"a page needs Plotly"):
        arm_page(puma, Q)


def test_a_name_with_dollars_is_no_formula(tmp_path: Path) -> None:
    """Matplotlib would refuse $\\frac$: it is unfinished."""
    arm = load_arm("planar2r")
    named = Arm(dataclasses.replace(arm.model, name="price $\\frac$ 5"))
    figure = draw_arm(named, [0.1, 0.2], save=tmp_path / "arm.png")
    assert (tmp_path / "arm.png").stat().st_size > 1000
    assert "$" in figure.axes[0].get_title()

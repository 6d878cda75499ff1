"""An arm to turn and play in a browser (Plotly)."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array
from holonom.errors import MissingExtra, OutputError
from holonom.mechanics import Arm
from holonom.mechanics.motion import Trajectory
from holonom.plots.figure import COLORS
from holonom.plots.skeleton import configurations, reach, sticks

__all__ = ["arm_page"]


def arm_page(arm: Arm, q: ArrayLike | Trajectory, *, steps: int = 60, save: str | Path | None = None) -> Any:
    """Show an arm, or its motion with a slider and the path of the tool point, as a Plotly figure.

    Parameters
    ----------
    q
        (n,), several (k, n), or a `Trajectory`.
    steps
        Largest number of steps of the slider.
    save
        HTML file to write too; it holds all that it needs and opens without a network.

    Raises
    ------
    ShapeError, MissingExtra, OutputError
    """
    try:
        import plotly.graph_objects as go
    except ImportError:
        raise MissingExtra("a page", "Plotly", "plots") from None
    rows = configurations(arm, q.q if isinstance(q, Trajectory) else q)
    kept = np.unique(np.linspace(0, len(rows) - 1, min(steps, len(rows))).astype(int))
    T = arm.frames(rows[kept])
    lines = [sticks(arm, frames) for frames in T]
    center, half = reach([line for branches in lines for line in branches])
    figure = go.Figure([_arm(go, lines[0]), _tool(go, T[:, -1, :3, 3])])
    figure.frames = [go.Frame(data=[_arm(go, branches)], name=str(k), traces=[0]) for k, branches in enumerate(lines)]
    times = rows.shape[0] > 1 and isinstance(q, Trajectory)
    labels = [f"{q.dt * k:.2f} s" if times and isinstance(q, Trajectory) else str(k) for k in kept]
    figure.update_layout(
        title=escape(arm.model.name),  # Plotly takes some mark-up in titles, links too
        showlegend=False,
        scene=_scene(center, half),
        margin={"l": 0, "r": 0, "t": 40, "b": 20},
        **(_controls(labels) if len(kept) > 1 else {}),
    )
    _write(figure, save)
    return figure


def _arm(go: Any, branches: list[Array]) -> Any:
    """All branches in one trace, gaps between them."""
    gap = np.full((1, 3), np.nan)
    x, y, z = np.concatenate([part for line in branches for part in (line, gap)]).T
    line, marker = {"width": 10, "color": "#34495E"}, {"size": 5, "color": COLORS[4]}
    return go.Scatter3d(x=x, y=y, z=z, mode="lines+markers", line=line, marker=marker, name="arm")


def _tool(go: Any, path: Array) -> Any:
    x, y, z = path.T
    return go.Scatter3d(x=x, y=y, z=z, mode="lines", line={"width": 4, "color": COLORS[1]}, name="tool point")


def _scene(center: Array, half: float) -> dict[str, Any]:
    axes = {
        f"{name}axis": {"range": [middle - half, middle + half], "title": f"{name} (m)"}
        for name, middle in zip("xyz", center, strict=True)
    }
    camera = {"eye": {"x": 1.4, "y": -1.4, "z": 0.8}, "center": {"x": 0.0, "y": 0.0, "z": -0.15}}
    return {"aspectmode": "cube", "camera": camera, **axes}


def _controls(labels: list[str]) -> dict[str, Any]:
    at_once = {"mode": "immediate", "frame": {"duration": 0, "redraw": True}, "transition": {"duration": 0}}
    steps = [{"method": "animate", "label": label, "args": [[str(k)], at_once]} for k, label in enumerate(labels)]
    play = {"frame": {"duration": 40, "redraw": True}, "transition": {"duration": 0}, "fromcurrent": True}
    button = {
        "type": "buttons",
        "x": 0.1,
        "xanchor": "right",
        "y": 0.0,
        "yanchor": "top",
        "pad": {"t": 40},
        "buttons": [{"label": "play", "method": "animate", "args": [None, play]}],
    }
    return {"sliders": [{"steps": steps, "x": 0.15, "len": 0.8, "pad": {"t": 20, "b": 20}}], "updatemenus": [button]}


def _write(figure: Any, save: str | Path | None) -> None:
    if save is None:
        return
    try:
        figure.write_html(save, include_plotlyjs=True, auto_play=False)
    except OSError as problem:
        raise OutputError(f"page {str(save)!r} cannot be written: {problem}") from problem

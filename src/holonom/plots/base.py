"""A mobile base from above: wheels, the axles that constrain it, centre of rotation, support polygon."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from holonom.arrays import Array, vectors
from holonom.errors import ModelError, ShapeError
from holonom.mobile.base.centre import centre_of_twist
from holonom.mobile.base.wheel import Wheel
from holonom.mobile.base.wheel_base import WheelBase
from holonom.mobile.footprint import footprint
from holonom.mobile.stability import contact_points, support_polygon
from holonom.plots.figure import COLORS, new_figure, saved

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_base", "draw_base_on"]

_DRIVEN, _PASSIVE, _BODY = "#34495E", "#AEB6BF", "#F4F6F7"
_AXLE, _CENTRE, _TWIST, _SUPPORT = COLORS[0], COLORS[1], COLORS[2], COLORS[3]
_FAR = 3.0
"""A centre of rotation beyond this many sizes of the base is not drawn; the axles point to it."""


def draw_base(
    base: WheelBase, twist: ArrayLike | None = None, steering: ArrayLike | None = None, *,
    names: bool = True, save: str | Path | None = None,
) -> Figure:  # fmt: skip
    """Draw a base from above, x upwards and y to the left, as one stands behind it.

    Wheels are dark where driven; rollers lie as they touch the floor, seen through the wheel. Broken lines are the
    axles of the wheels that must not slide; they meet in the centre of rotation.

    Parameters
    ----------
    twist
        (3,) m/s, rad/s; drawn with its centre of rotation. None: neither.
    steering
        (k,) rad; None: the angles for the twist, or at rest.
    names
        Whether wheels are named.
    save
        File to write too.

    Raises
    ------
    InputError
        Matplotlib is not installed.
    OutOfLimits
        The twist would drag a wheel or steer it too far.
    ShapeError, OutputError
    """
    figure = new_figure(6.0, 6.4)
    draw_base_on(figure.add_subplot(), base, twist, steering, names=names)
    figure.legend(loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    saved(figure, save)
    return figure


def draw_base_on(
    axes: Axes, base: WheelBase, twist: ArrayLike | None = None, steering: ArrayLike | None = None, *,
    names: bool = True,
) -> None:  # fmt: skip
    """Draw a base on given axes; see `draw_base`. The legend is the caller's."""
    xi = None if twist is None else vectors("twist", twist, 3)
    if xi is not None and xi.shape != (3,):
        raise ShapeError(f"twist has shape {xi.shape}; one twist (3,) is drawn")
    angles = _angles(base, xi, steering)
    headings = [w.heading for w in base.wheels]
    for members, angle in zip(base.layout.groups, angles, strict=True):
        for i in members:
            headings[i] += float(angle)
    size = _size(base)
    _support(axes, base)
    _body(axes, base, size)
    reach = [p + e * w.radius for w, p in zip(base.wheels, contact_points(base), strict=True) for e in (-1.0, 1.0)]
    reach.append(np.zeros(2))
    centre = None
    if xi is not None and np.any(xi):
        found = centre_of_twist(xi)
        if not found.at_infinity and np.linalg.norm(found.point) < _FAR * size:
            centre = found.point
            reach.append(centre)
        reach.append(_arrow_tip(xi, size))
    box = _frame(axes, reach, size)
    _axles(axes, base, headings, box)
    for wheel, heading in zip(base.wheels, headings, strict=True):
        _wheel(axes, wheel, heading)
    if names:
        _names(axes, base, size)
    _marks(axes, base, xi, centre, size)
    axes.set_title(_title(base, xi), fontsize=10)


def _angles(base: WheelBase, xi: Array | None, steering: ArrayLike | None) -> Array:
    if steering is not None:
        angles = vectors("steering", steering, len(base.steered))
        if angles.ndim != 1:
            raise ShapeError(f"steering has shape {angles.shape}; one set of angles ({len(base.steered)},) is drawn")
    elif xi is not None:
        angles = base.steering(xi)
    else:
        return np.zeros(len(base.steered))
    if xi is not None:
        base.wheel_speeds(xi, angles)  # refuses, by name, a twist that the wheels do not allow
    return angles


def _size(base: WheelBase) -> float:
    """Half the width of the base, wheels included."""
    return max(w.l + w.radius + abs(w.castor_offset) for w in base.wheels)


def _xy(points: ArrayLike) -> tuple[Array, Array]:
    """Of points in base_link, the figure's right (-y) and up (x)."""
    p = np.asarray(points, dtype=float)
    return -p[..., 1], p[..., 0]


def _frame(axes: Any, reach: list[Array], size: float) -> tuple[Array, Array]:
    """Set limits around what is drawn; return its corners in base_link."""
    points = np.array(reach)
    low, high = points.min(axis=0) - 0.22 * size, points.max(axis=0) + 0.22 * size
    axes.set_aspect("equal")
    axes.set_xlim(-high[1], -low[1])
    axes.set_ylim(low[0], high[0])
    axes.set_xlabel("-y (m)")
    axes.set_ylabel("x (m)")
    axes.grid(color="0.92", linewidth=0.6)
    axes.set_axisbelow(True)
    return low, high


def _support(axes: Any, base: WheelBase) -> None:
    try:
        corners = support_polygon(base)
    except ModelError:
        return  # it has to balance
    closed = np.concatenate([corners, corners[:1]])
    axes.plot(*_xy(closed), ":", color=_SUPPORT, linewidth=1.4, label="support polygon", zorder=2.5)


def _body(axes: Any, base: WheelBase, size: float) -> None:
    """A skin around circles at the wheels."""
    skin = footprint(base, pad=0.04 * size)
    axes.fill(*_xy(skin), facecolor=_BODY, edgecolor="0.75", linewidth=1.0, zorder=0.5)


def _axles(axes: Any, base: WheelBase, headings: list[float], box: tuple[Array, Array]) -> None:
    length = 2.0 * float(np.linalg.norm(box[1] - box[0]))
    label = "axles: no sliding along them"
    for wheel, psi in zip(base.wheels, headings, strict=True):
        if wheel.name in base.sliding_names and wheel.kind not in ("skid", "ball"):
            along = np.array([-math.sin(psi), math.cos(psi)])
            ends = np.array([wheel.x, wheel.y]) + np.outer([-length, length], along)
            axes.plot(*_xy(ends), "--", color=_AXLE, linewidth=0.8, label=label, zorder=1.0, scalex=False, scaley=False)
            label = "_"


def _wheel(axes: Any, wheel: Wheel, psi: float) -> None:
    from matplotlib.patches import Circle

    color = _DRIVEN if wheel.driven else _PASSIVE
    place = np.array([wheel.x, wheel.y])
    ahead, left = np.array([math.cos(psi), math.sin(psi)]), np.array([-math.sin(psi), math.cos(psi)])
    if wheel.kind in ("spherical", "ball"):
        axes.add_patch(
            Circle((-wheel.y, wheel.x), wheel.radius, facecolor=color, edgecolor="black", alpha=0.7, zorder=3)
        )
        return
    if wheel.kind == "castor":
        touch = place + wheel.castor_offset * ahead
        axes.plot(*_xy([place, touch]), color="black", linewidth=1.5, zorder=4)
        axes.plot(*_xy(place), "o", color="white", markeredgecolor="black", markersize=5, zorder=4)
        place = touch
    half = 0.3 * wheel.radius
    corners = [place + a * wheel.radius * ahead + b * half * left for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    light = wheel.kind == "swedish"
    axes.fill(*_xy(corners), facecolor="white" if light else color, edgecolor=color, linewidth=1.6, zorder=3)
    if light:
        _rollers(axes, wheel, place, ahead, left, color)


def _rollers(axes: Any, wheel: Wheel, place: Array, ahead: Array, left: Array, color: str) -> None:
    """Axles of the rollers that touch the floor, along psi + gamma: what does not roll away under the wheel."""
    c, s = math.cos(wheel.roller_angle), math.sin(wheel.roller_angle)
    half = min(0.28 * wheel.radius / max(abs(s), 1e-9), 0.12 * wheel.radius / max(abs(c), 1e-9) * (1.0 + 2.0 * abs(s)))
    for k in np.linspace(-0.75, 0.75, 5):
        middle = place + wheel.radius * k * ahead
        ends = [middle + e * half * (c * ahead + s * left) for e in (-1.0, 1.0)]
        axes.plot(*_xy(ends), color=color, linewidth=2.0, solid_capstyle="butt", zorder=3.5)


def _names(axes: Any, base: WheelBase, size: float) -> None:
    box = {"facecolor": "white", "alpha": 0.8, "edgecolor": "none", "pad": 0.8}
    for wheel, point in zip(base.wheels, contact_points(base), strict=True):
        right, up = _xy(point)
        shift = wheel.radius + 0.05 * size
        below = point[0] < -1e-9
        axes.text(
            right, up - shift if below else up + shift, wheel.name, fontsize=8, ha="center",
            va="top" if below else "bottom", bbox=box, zorder=6,
        )  # fmt: skip


def _marks(axes: Any, base: WheelBase, xi: Array | None, centre: Array | None, size: float) -> None:
    axes.plot(*_xy(base.com), "o", color="black", markersize=4, label="centre of mass", zorder=5)
    if xi is None:
        return
    if np.any(xi[:2]):
        arrow = {"arrowstyle": "-|>", "color": _TWIST, "linewidth": 2.2, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", xy=_xy(_arrow_tip(xi, size)), xytext=(0.0, 0.0), arrowprops=arrow, zorder=5)
        axes.plot([], [], color=_TWIST, linewidth=2.2, label="velocity of base_link")
    if centre is not None:
        axes.plot(*_xy(centre), "P", color=_CENTRE, markersize=10, label="centre of rotation", zorder=6, ls="none")


def _arrow_tip(xi: Array, size: float) -> Array:
    """End of the arrow along the velocity of base_link, however fast."""
    speed = float(np.hypot(xi[0], xi[1]))
    return 0.55 * size * xi[:2] / speed if speed > 0.0 else np.zeros(2)


def _title(base: WheelBase, xi: Array | None) -> str:
    if xi is None:
        return base.name
    return f"{base.name}: vx {xi[0]:.3g} m/s, vy {xi[1]:.3g} m/s, w {xi[2]:.3g} rad/s"

"""What the replay draws: shapes, each fixed in a frame of the recording. Data only.

Lengths are metres. A frame is a name in `Recording.frames`, or "world". Colours are CSS colours.
"""

from __future__ import annotations

from dataclasses import dataclass

from holonom.arrays import Array

__all__ = ["Box", "Disc", "Label", "Scene", "Shape", "Tube", "View"]

Point = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Tube:
    """A round bar from `start` to `end` in `frame`; `end_radius` where it tapers, flat or `rounded` ends."""

    frame: str
    start: Point
    end: Point
    radius: float
    colour: str
    end_radius: float | None = None
    rounded: bool = False


@dataclass(frozen=True, slots=True)
class Box:
    """A box of `size` with its centre at `pose` (4, 4), T of the box in `frame`."""

    frame: str
    pose: Array
    size: Point
    colour: str


@dataclass(frozen=True, slots=True)
class Disc:
    """A flat round part: the origin of `frame` is its centre, z of `frame` its axis.

    With a photograph in the report, `pixel` (2,) is where the centre lies on it and `pixel_axes` (2, 2) the
    pixels per metre, `d(u, v) / d(x, y)` in `frame`: then the disc wears its own picture.
    """

    frame: str
    radius: float
    thickness: float
    colour: str
    pixel: Array | None = None
    pixel_axes: Array | None = None


@dataclass(frozen=True, slots=True)
class Label:
    """Flat writing of the given letter height, centred at `pose` (4, 4) in `frame`, read along its x axis."""

    frame: str
    pose: Array
    text: str
    height: float
    colour: str = "#475569"


Shape = Tube | Box | Disc | Label


@dataclass(frozen=True, slots=True)
class View:
    """A camera of the replay at `eye` that looks at `target`, both in world.

    With `follow`, the name of a frame, both are given from that frame's origin and go along with it, without turning.
    """

    name: str
    eye: Point
    target: Point
    follow: str | None = None


@dataclass(frozen=True, slots=True)
class Scene:
    """All that the replay draws.

    Attributes
    ----------
    shapes
        What is drawn, in any order.
    views
        Cameras to choose from; the first is the one the report opens with.
    tool
        The frame whose path is drawn.
    trail
        How many seconds of its path stay visible.
    extent
        Half the width of the lit room about the world's origin, m.
    """

    shapes: tuple[Shape, ...]
    views: tuple[View, ...] = (View("Overview", (1.45, -0.95, 1.1), (0.27, 0.0, 0.43)),)
    tool: str = "tool"
    trail: float = 2.0
    extent: float = 1.1

    def frames(self) -> tuple[str, ...]:
        """Names of the frames that the replay needs from the recording, each once."""
        followed = [view.follow for view in self.views if view.follow is not None]
        names = dict.fromkeys([*(shape.frame for shape in self.shapes), self.tool, *followed])
        return tuple(name for name in names if name != "world")

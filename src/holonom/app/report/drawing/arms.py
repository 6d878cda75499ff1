"""Shapes of arms and grippers for the replay. They are for the eye: no mass, no collision."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from holonom.app.report.drawing.scene import Box, Shape, Tube
from holonom.errors import UnknownName

__all__ = ["arm_shapes", "drawn_arms", "gripper_shapes"]

_BODY, _JOINT, _METAL, _FINGER = "#eef1f5", "#33415c", "#aab4c3", "#4b5871"


def arm_shapes(preset: str) -> tuple[Shape, ...]:
    """Shapes of a preset arm, fixed in its link frames "link1" to "link6".

    Raises
    ------
    UnknownName
        No shapes are known for this preset.
    """
    if preset not in _ARMS:
        raise UnknownName("arm drawing", preset, _ARMS)
    return _ARMS[preset]()


def drawn_arms() -> tuple[str, ...]:
    """Return the presets that `arm_shapes` knows."""
    return tuple(_ARMS)


def gripper_shapes(
    *, length: float = 0.12, width: float = 0.1, finger: tuple[float, float, float] = (0.016, 0.008, 0.045)
) -> tuple[Shape, ...]:
    """A parallel gripper on frames "tool", "finger_left" and "finger_right".

    The tool frame lies between the finger tips, z away from the arm, y from the right to the left finger. The
    origin of a finger frame is the middle of the lower edge of its inner face, its axes are the tool's.

    Parameters
    ----------
    length
        From wrist centre to finger tips, m.
    width
        Of the palm along y, m.
    finger
        Size of a finger along x, y (its thickness), z, m.
    """
    x, y, z = finger
    palm = 0.022
    root = -z - palm
    return (
        Tube("tool", (0, 0, -length + 0.035), (0, 0, root), 0.026, _METAL),
        Box("tool", _at(0, 0, -z - palm / 2), (1.6 * x, width, palm), _JOINT),
        Box("finger_left", _at(0, y / 2, -z / 2), finger, _FINGER),
        Box("finger_right", _at(0, -y / 2, -z / 2), finger, _FINGER),
    )


def _puma560() -> tuple[Shape, ...]:
    """The Unimate Puma 560 in standard Denavit-Hartenberg frames; sizes for the eye.

    Upper arm and forearm lie side by side: the upper arm outside (0.20 to 0.29 m along the shoulder axis), the
    forearm inside, in the plane of the wrist (0.15 m).
    """
    a2, a3, d3, d4 = 0.4318, 0.0203, 0.15005, 0.4318
    inner, outer, middle = 0.205, 0.285, 0.245
    return (
        Tube("world", (0, 0, 0), (0, 0, 0.03), 0.17, _JOINT),
        Tube("world", (0, 0, 0.03), (0, 0, 0.5), 0.088, _BODY),
        Tube("world", (0, 0, 0.5), (0, 0, 0.52), 0.094, _JOINT),
        Tube("link1", (0, -0.155, 0), (0, 0.1, 0), 0.092, _BODY),
        Tube("link1", (0, 0, -0.1), (0, 0, inner), 0.082, _BODY),
        Tube("link1", (0, 0, -0.112), (0, 0, -0.1), 0.07, _JOINT),
        Tube("link2", (-a2, 0, inner - 0.012), (-a2, 0, inner), 0.09, _JOINT),
        Tube("link2", (-a2, 0, inner), (-a2, 0, outer), 0.098, _BODY),
        Box("link2", _at(-a2 / 2, 0, middle), (a2, 0.13, outer - inner), _BODY),
        Tube("link2", (0, 0, inner), (0, 0, outer), 0.066, _BODY),
        Box("link2", _at(-a2 - 0.11, 0, middle), (0.15, 0.12, outer - inner), _BODY),
        Tube("link2", (0, 0, outer), (0, 0, outer + 0.008), 0.045, _JOINT),
        Tube("link3", (-a3, d3 - inner, 0), (-a3, d3 - inner + 0.012, 0), 0.06, _JOINT),
        Tube("link3", (-a3, d3 - inner + 0.012, 0), (-a3, 0.05, 0), 0.064, _BODY),
        Box("link3", _at(-a3, 0, -0.06), (0.1, 0.085, 0.12), _BODY),
        Tube("link3", (-a3 / 2, 0, 0), (0, 0, d4 - 0.1), 0.056, _BODY, end_radius=0.042),
        Tube("link4", (0, -0.1, 0), (0, -0.088, 0), 0.044, _JOINT),
        Tube("link4", (0, -0.088, 0), (0, -0.03, 0), 0.042, _BODY, end_radius=0.036),
        Tube("link4", (0, 0, -0.042), (0, 0, 0.042), 0.037, _BODY),
        Tube("link5", (0, 0, 0), (0, 0, 0.045), 0.03, _JOINT),
        Tube("link6", (0, 0, 0.045), (0, 0, 0.055), 0.034, _METAL),
    )


def _at(x: float, y: float, z: float) -> NDArray[np.float64]:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


_ARMS: dict[str, Callable[[], tuple[Shape, ...]]] = {"puma560": _puma560}

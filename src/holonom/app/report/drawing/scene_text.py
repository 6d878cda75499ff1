"""A scene as JSON, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from holonom.app.report.drawing.scene import Box, Disc, Label, Scene, Shape, Tube, View
from holonom.arrays import Array
from holonom.errors import InputError

__all__ = ["scene_json", "scene_of", "scene_text"]

SHAPES: Mapping[str, type[Any]] = {kind.__name__.lower(): kind for kind in (Tube, Box, Disc, Label)}
SHAPE_OF = {"pose": (4, 4), "pixel": (2,), "pixel_axes": (2, 2)}
"""Fields of shapes that are arrays; then points, texts and flags; all others are numbers."""
POINTS, TEXTS, FLAGS = ("start", "end", "size"), ("frame", "colour", "text"), ("rounded",)


def scene_json(scene: Scene) -> dict[str, Any]:
    """The scene as the page's script reads it."""
    return {
        "shapes": [_shape_json(shape) for shape in scene.shapes],
        "views": [asdict(view) for view in scene.views],
        "tool": scene.tool,
        "trail": scene.trail,
        "extent": scene.extent,
    }


def scene_text(scene: Scene) -> bytes:
    """The scene as a file."""
    return json.dumps(scene_json(scene), allow_nan=False, separators=(",", ":")).encode()


def scene_of(text: bytes) -> Scene:
    """The scene in a file that `scene_text` gave.

    Raises
    ------
    InputError
        It is none.
    """
    try:
        stated = json.loads(text)
        views = tuple(
            View(_text(v["name"]), _point(v["eye"]), _point(v["target"]), v["follow"] and _text(v["follow"]))
            for v in stated["views"]
        )
        shapes = tuple(_shape(shape) for shape in stated["shapes"])
        return Scene(shapes, views, _text(stated["tool"]), float(stated["trail"]), float(stated["extent"]))
    except (KeyError, TypeError, ValueError, OverflowError, RecursionError) as error:
        raise InputError(f"the recording's scene.json cannot be read ({error!r}); record it again") from None


def _shape_json(shape: Shape) -> dict[str, Any]:
    fields = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(shape).items()}
    return {"kind": type(shape).__name__.lower(), **fields}


def _shape(stated: Mapping[str, Any]) -> Shape:
    fields = {name: _value(name, value) for name, value in stated.items() if name != "kind"}
    made: Shape = SHAPES[stated["kind"]](**fields)
    return made


def _value(name: str, value: Any) -> Any:
    if value is None:
        return None
    if name in SHAPE_OF:
        return _finite(np.array(value, dtype=np.float64).reshape(SHAPE_OF[name]))
    if name in POINTS:
        return _point(value)
    if name in TEXTS:
        return _text(value)
    return bool(value) if name in FLAGS else float(_finite(np.array(value, dtype=np.float64).reshape(())))


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise TypeError(f"{type(value).__name__} came; text is expected")
    return value


def _finite(values: Array) -> Array:
    if not np.isfinite(values).all():
        raise ValueError("a number that is not finite")
    return values


def _point(value: Any) -> tuple[float, float, float]:
    x, y, z = _finite(np.array(value, dtype=np.float64).reshape(3)).tolist()
    return x, y, z

"""Numbers for the page: arrays as 32-bit floats, column by column, compressed, in base 64."""

from __future__ import annotations

import base64
import gzip
from collections.abc import Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from holonom.app.recording import FrameTrack, Recording
from holonom.app.report.curves import Curve
from holonom.app.report.scene import Scene, Shape
from holonom.errors import UnknownName

__all__ = ["Blob", "add_curves", "add_frames", "scene_json"]

Array = NDArray[np.float64]

REPLAY_RATE = 50.0
"""Poses per second in the page; the browser interpolates between them."""
CURVE_SAMPLES = 12_000
"""Longer curves are thinned to at most so many samples."""


class Blob:
    """Named arrays in one stretch of bytes; columns stay together, so that what stands still costs nothing."""

    __slots__ = ("_parts", "_size", "index")

    def __init__(self) -> None:
        self.index: dict[str, list[int]] = {}
        self._parts: list[bytes] = []
        self._size = 0

    def add(self, name: str, values: Array) -> None:
        """Add `values` (rows,) or (rows, columns)."""
        rows = len(values)
        table = values.reshape(rows, -1) if rows else np.empty((0, 0))
        part = np.ascontiguousarray(table.T, dtype="<f4").tobytes()
        self.index[name] = [self._size // 4, rows, table.shape[1]]
        self._parts.append(part)
        self._size += len(part)

    def text(self) -> str:
        """All of it as gzip in base 64; the same arrays always give the same text."""
        return base64.b64encode(gzip.compress(b"".join(self._parts), compresslevel=9, mtime=0)).decode()


def add_frames(blob: Blob, recording: Recording, scene: Scene) -> int:
    """Add the poses (x y z, quaternion x y z w) of every frame of the scene; one row for one at rest.

    Returns
    -------
    int
        Number of frames missing because the run ended before the first of them was recorded: all or none.

    Raises
    ------
    UnknownName
        The scene uses a frame that the recording does not have.
    """
    if not recording.frames:
        return len(scene.frames())
    for name in scene.frames():
        if name not in recording.frames:
            raise UnknownName("frame in the recording", name, recording.frames)
        blob.add(f"frame:{name}", _resampled(recording.frames[name], recording.end()))
    return 0


def add_curves(blob: Blob, curves: Sequence[Curve]) -> list[dict[str, object]]:
    """Add curves, thinned, with their times, each stretch of times once; return what the page's script is told."""
    times: dict[bytes, str] = {}
    told: list[dict[str, object]] = []
    for curve in curves:
        keep = slice(None, None, _stride(len(curve.time)))
        name = times.setdefault(curve.time[keep].tobytes(), f"time:{len(times)}")
        if name not in blob.index:
            blob.add(name, curve.time[keep])
        blob.add(f"curve:{curve.key}", curve.values[keep])
        told.append({"key": curve.key, "title": curve.title, "unit": curve.unit, "names": curve.names, "time": name})
    return told


def scene_json(scene: Scene) -> dict[str, object]:
    """The scene as the page's script reads it."""
    return {
        "shapes": [_shape_json(shape) for shape in scene.shapes],
        "views": [asdict(view) for view in scene.views],
        "tool": scene.tool,
        "trail": scene.trail,
        "extent": scene.extent,
        "rate": REPLAY_RATE,
    }


def _shape_json(shape: Shape) -> dict[str, object]:
    fields = {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in asdict(shape).items()}
    return {"kind": type(shape).__name__.lower(), **fields}


def _resampled(track: FrameTrack, end: float) -> Array:
    """Rows (m, 7) at the replay rate, the last sample known at each time; one row for a frame at rest."""
    rows = np.hstack([track.position, track.quaternion])
    if np.all(rows == rows[0]):
        return rows[:1]
    times = np.arange(0.0, end + 1 / REPLAY_RATE, 1 / REPLAY_RATE)
    at = np.searchsorted(track.time, times + 1e-9, side="right") - 1
    return np.asarray(rows[np.maximum(at, 0)])


def _stride(samples: int) -> int:
    return max(1, -(-samples // CURVE_SAMPLES))

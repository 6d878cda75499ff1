"""What stands in a recording beside its messages, read: cell, scene, programs, photograph, how the run ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from pydantic import TypeAdapter, ValidationError

from holonom.app.recording import Recording
from holonom.app.report.drawing.scene import Scene
from holonom.app.report.drawing.scene_text import scene_of
from holonom.app.report.findings.facts import CellFacts, Ending
from holonom.app.report.sections import Detection, PhotoOverlay
from holonom.errors import InputError

__all__ = [
    "CELL",
    "OUTCOME",
    "PHOTOGRAPH",
    "PHOTOGRAPH_WORDS",
    "SCENE",
    "cell_of",
    "ending_of",
    "ending_words",
    "photograph_of",
    "photograph_text",
    "program_of",
    "recorded_scene",
    "text_of",
]

T = TypeVar("T")
CELL, SCENE, PHOTOGRAPH, PHOTOGRAPH_WORDS = "cell.json", "scene.json", "photograph.png", "photograph.json"
"""Names of attachments."""
OUTCOME = "outcome"
"""Name of the words at the end."""


@dataclass(frozen=True, slots=True)
class _Photograph:
    """A photograph without its picture."""

    width: int
    height: int
    detections: tuple[Detection, ...]
    groups: Mapping[str, str]
    caption: str = ""


@dataclass(frozen=True, slots=True)
class _Statistics:
    """What was counted, see `Ending`."""

    joints: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)
    numbers: Mapping[str, Mapping[str, float]] = field(default_factory=dict)


def text_of(kind: type[T], value: T) -> bytes:
    """A record of facts as JSON."""
    return TypeAdapter(kind).dump_json(value)


def cell_of(recording: Recording) -> CellFacts | None:
    """The cell; None where the recording says nothing of it.

    Raises
    ------
    InputError
        What it says cannot be read; so do the others.
    """
    return _read(CellFacts, CELL, recording.attachments.get(CELL))


def recorded_scene(recording: Recording) -> Scene | None:
    """What the replay shows."""
    text = recording.attachments.get(SCENE)
    return None if text is None else scene_of(text)


def photograph_of(recording: Recording) -> PhotoOverlay | None:
    """The photograph with what was found in it."""
    words = _read(_Photograph, PHOTOGRAPH_WORDS, recording.attachments.get(PHOTOGRAPH_WORDS))
    png = recording.attachments.get(PHOTOGRAPH)
    if words is None or png is None:
        return None
    return PhotoOverlay(png, words.width, words.height, words.detections, words.groups, words.caption)


def program_of(recording: Recording, name: str) -> str:
    """Text of a robot's program, "" where there is none."""
    return recording.attachments.get(name, b"").decode("utf-8", errors="replace")


def photograph_text(photo: PhotoOverlay) -> bytes:
    """What was found in a photograph, as a file."""
    return text_of(_Photograph, _Photograph(photo.width, photo.height, photo.detections, photo.groups, photo.caption))


def ending_of(recording: Recording) -> Ending | None:
    """What the words at the end say; None where there are none, as in what a killed run left."""
    words = recording.metadata.get(OUTCOME)
    if words is None:
        return None
    counted = _read(_Statistics, f"{OUTCOME}.statistics", words.get("statistics", "{}").encode()) or _Statistics()
    try:
        time = float(words.get("simulated_time_s", recording.end()))
    except ValueError as error:
        raise InputError(f"the recording's {OUTCOME} cannot be read ({error}); record it again") from None
    return Ending(words.get("status", "unknown"), words.get("reason", ""), time, counted.joints, counted.numbers)


def ending_words(ending: Ending) -> dict[str, str]:
    """The words for a recording's end, as `Recorder.metadata(OUTCOME, ...)` takes them."""
    return {
        "status": ending.status,
        "reason": ending.reason,
        "simulated_time_s": repr(ending.simulated_time),
        "statistics": text_of(_Statistics, _Statistics(ending.joints, ending.numbers)).decode(),
    }


def _read(kind: type[T], name: str, text: bytes | None) -> T | None:
    if text is None:
        return None
    try:
        return TypeAdapter(kind).validate_json(text)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"])) or "its beginning"
        raise InputError(
            f"the recording's {name} cannot be read (at {where}: {first['msg']}); record it again"
        ) from None

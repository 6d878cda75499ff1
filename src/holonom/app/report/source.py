"""What a report is made of: a recording, read, with all that is known of its cell and of runs beside it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from holonom.app.recording import CUT_OFF, FrameTrack, Recording, read_robots
from holonom.app.report.attached import cell_of, ending_of, photograph_of, recorded_scene
from holonom.app.report.drawing.inferred_scene import inferred_scene
from holonom.app.report.drawing.scene import Scene
from holonom.app.report.findings.castor_frames import castor_frames
from holonom.app.report.findings.facts import CellFacts, Ending, RobotFacts
from holonom.app.report.findings.rebased import rebased
from holonom.app.report.sections import PhotoOverlay
from holonom.errors import InputError
from holonom.signals import TOPICS, Event

__all__ = ["BARE", "RobotSource", "Source", "source_of"]

T = TypeVar("T")

BARE = "without_handling"
"""The run of a base without slip detection and watch over its motors."""
UNUSED = ("/tf", "/truth/tool_pose", "/measured/encoder_counts", "/imu")
"""Topics that no section shows; an hour of them is not read."""
COMPARED = (
    "/joint_states", "/truth/joint_states", "/commanded/joint_states", "/odom", "/commanded/odom", "/truth/odom",
    "/rosout", "/signals/{number}",
)  # fmt: skip
"""Topics that are compared between runs."""
FATAL = ("simulation", "drive", "program", "operator")
"""Sources of events that end a run."""


@dataclass(frozen=True, slots=True)
class RobotSource:
    """One robot: its part of the recording, what is known of it, and the same robot in runs beside it, by their names.

    `statistics` are those of its joints, `numbers` its own, see `Ending`.
    """

    name: str
    recording: Recording
    facts: RobotFacts
    statistics: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    beside: Mapping[str, RobotSource] = field(default_factory=dict)

    def called(self, title: str) -> str:
        """A section's title, with the robot's name where there are several."""
        return f"{title} of {self.name}" if self.name else title

    def key(self, name: str) -> str:
        """A section's place in the page."""
        return f"{name}-{self.name}" if self.name else name


@dataclass(frozen=True, slots=True)
class Source:
    """A recording to report on; `cell` is what little can be told where `told` is false."""

    whole: Recording
    cell: CellFacts
    told: bool
    ending: Ending
    scene: Scene
    robots: tuple[RobotSource, ...]
    photograph: PhotoOverlay | None = None
    unread: tuple[str, ...] = ()
    """what it says of itself that cannot be read, and why"""

    @property
    def lost(self) -> tuple[str, ...]:
        """What could not be read of it, a sentence each."""
        return (*(missing.text() for missing in self.whole.missing), *self.unread)

    @property
    def events(self) -> tuple[Event, ...]:
        """Events for the reader; what only the simulation knows of gripping wheels is in other sections."""
        return tuple(e for e in self.whole.events if (e.source.rpartition(".")[2], e.level) != ("truth", "debug"))

    @property
    def alone(self) -> bool:
        """Whether it is of one robot."""
        return len(self.robots) == 1


def source_of(path: str | Path, *, beside: bool = True) -> Source:
    """Read a recording, and those in its folder that are of the same cell and seed (`recording_<name>.mcap`).

    Without `beside` it is one of those itself: only what is compared is read.

    Raises
    ------
    InputError
        It is not there, no MCAP recording, or so damaged that nothing of it can be read.
    """
    path = Path(path)
    wanted = [topic for topic in TOPICS if (topic.name not in UNUSED if beside else topic.name in COMPARED)]
    recordings = {name: rebased(recording) for name, recording in read_robots(path, topics=wanted).items()}
    whole = _with_base_frames(recordings[""])
    unread: list[str] = []
    cell = _told(cell_of, whole, unread)
    ending = _told(ending_of, whole, unread) or _guessed(whole)
    known = cell or _inferred(path, recordings)
    whole = replace(whole, frames={**whole.frames, **castor_frames(whole.frames, known.robots)})
    others = _others(path, cell) if beside and cell is not None else {}
    robots = tuple(
        RobotSource(
            robot.name,
            recordings.get(robot.name, whole),
            robot,
            ending.joints.get(robot.name, {}),
            ending.numbers.get(robot.name, {}),
            {name: found for name, other in others.items() for found in other.robots if found.name == robot.name},
        )
        for robot in known.robots
    )
    scene = _drawable(_told(recorded_scene, whole, unread), whole) or inferred_scene(whole.frames)
    photograph = _told(photograph_of, whole, unread)
    return Source(whole, known, cell is not None, ending, scene, robots, photograph, tuple(unread))


def _told(read: Callable[[Recording], T | None], recording: Recording, unread: list[str]) -> T | None:
    """What a recording says of itself; None, and a sentence, where that cannot be read."""
    try:
        return read(recording)
    except InputError as error:
        unread.append(str(error))
        return None


def _others(path: Path, cell: CellFacts) -> dict[str, Source]:
    """Recordings beside one, by what their names add to its."""
    found = {}
    for other in sorted(path.parent.glob("recording_*.mcap")):
        if other != path and path.name == "recording.mcap":
            try:
                source = source_of(other, beside=False)
            except InputError:
                continue  # somebody else's, or damaged: nothing to compare with
            if source.told and (source.cell.title, source.cell.seed) == (cell.title, cell.seed):
                found[other.stem.removeprefix("recording_")] = source
    return found


def _inferred(path: Path, recordings: Mapping[str, Recording]) -> CellFacts:
    """What can be told of a recording that says nothing of its cell."""
    names = [name for name in recordings if name] or [""]
    robots = tuple(_inferred_robot(name, recordings[name]) for name in names)
    return CellFacts(path.resolve().parent.name.replace("_", " "), f"recorded in {path.name}", robots=robots)


def _inferred_robot(name: str, recording: Recording) -> RobotFacts:
    moving = (recording.base, recording.base_reference, recording.true_base)
    kind = "base" if any(len(track.time) for track in moving) else "arm"
    joints = recording.joint_names
    return RobotFacts(name, kind, "", "", "", joints, ("revolute",) * len(joints))


def _guessed(recording: Recording) -> Ending:
    """How a run ended that does not say it."""
    end = recording.end()
    if recording.ended == CUT_OFF:
        return Ending("cut off", f"cut off at {end:g} s: the run was killed, or is still going", end)
    fatal = [e for e in recording.events if e.level == "error" and e.source.rpartition(".")[2] in FATAL]
    if fatal:
        return Ending("failed", fatal[-1].text.splitlines()[0], end)
    return Ending("unknown", f"recorded to {end:g} s", end)


def _drawable(scene: Scene | None, recording: Recording) -> Scene | None:
    """The scene without what stands in frames that were not recorded (yet)."""
    if scene is None:
        return None
    known = {*recording.frames, "world"}
    shapes = tuple(shape for shape in scene.shapes if shape.frame in known)
    views = tuple(replace(view, follow=view.follow if view.follow in known else None) for view in scene.views)
    return replace(scene, shapes=shapes, views=views, tool=scene.tool if scene.tool in known else "world")


def _with_base_frames(recording: Recording) -> Recording:
    """A recording without frames, but of a base, as other tools make them: with the frame of the base."""
    base = next((t for t in (recording.true_base, recording.base) if len(t.time)), None)
    if recording.frames or base is None:
        return recording
    half, flat = 0.5 * base.pose[:, 2], np.zeros(len(base.time))
    places = np.stack([base.pose[:, 0], base.pose[:, 1], flat], axis=1)
    turned = np.stack([flat, flat, np.sin(half), np.cos(half)], axis=1)
    return replace(recording, frames={"base_link": FrameTrack(base.time, places, turned)})

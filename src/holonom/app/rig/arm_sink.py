"""What an arm records on its way into the recording: what its program types is shown, too, and /tf is made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from holonom.app.job import ArmJob
from holonom.arrays import Array
from holonom.signals import Event, FrameTree, JointState, Sink

__all__ = ["ArmSink"]


class ArmSink:
    """A sink that shows what programs type, names the file of their lines, and places the links as the encoders say.

    Parameters
    ----------
    sink
        Where all goes.
    say
        Takes what programs type.
    job
        The arm.
    stands
        T (4, 4) of its base in the frame that is its links' parent.
    parent
        That frame: the world, or the arm's own base where a robot carries it.
    """

    def __init__(self, sink: Sink, say: Callable[[str], None], job: ArmJob, parent: str, stands: Array) -> None:
        self._sink, self._say, self._arm, self._stands = sink, say, job.arm, stands
        self._file = "" if job.program is None else Path(job.program.file).name
        names = [*(f"link{k + 1}" for k in range(len(job.arm.model.joints))), "tool"]
        self._names, self._parents = tuple(names), (parent,) * len(names)

    def put(self, record: Any) -> None:
        """Take a record; see `Sink`."""
        if isinstance(record, Event):
            if record.level == "info" and record.source == "program":
                self._say(record.text)
            if record.line and not record.file:
                record = replace(record, file=self._file)
        self._sink.put(record)
        if isinstance(record, JointState):
            frames = self._stands @ self._arm.frames(record.position)[1:]
            self._sink.put(FrameTree(record.time, self._parents, self._names, frames))

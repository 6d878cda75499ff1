"""Jobs run in this process, recorded as `holonom run` records them."""

from __future__ import annotations

from pathlib import Path

from holonom.app.job import Job
from holonom.app.recording import Recorder
from holonom.app.recording.robot import base_words
from holonom.app.report.attached import OUTCOME, ending_words
from holonom.app.report.attachments import attachments_of
from holonom.app.report.source import Source, source_of
from holonom.app.rig import Rig, Simulated, simulated


def record(job: Job, path: Path, loops: Simulated | None = None) -> Source:
    """Run a job of bases; its recording, read as a report reads it."""
    loops = loops or simulated(job, [])
    words: dict[str, dict[str, str]] = {}
    for base in job.bases:
        words |= base_words(base.base, base.drive.encoder.counts_per_rev, base.drive.gear.ratio, robot=base.name)
    with Recorder(path, attachments=attachments_of(job), metadata=words) as recorder:
        rig = Rig(job, loops, recorder, say=lambda text: None)
        ended = rig.run()
        recorder.metadata(OUTCOME, ending_words(rig.ending(ended)))
    return source_of(path, beside=False)

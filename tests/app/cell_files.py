"""Cells written into a folder, for the tests of the one cell model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from holonom.app.cell import load_cell
from holonom.app.cell.build.job import build_job
from holonom.app.job import Job
from holonom.app.recording.scope import Scope
from holonom.app.rig.wheel_frames import wheel_frames

CELLS = Path(__file__).parent / "cells"
ABOUT = '[cell]\nname = "a cell"\ntime_limit = "60s"\n'
ALL_KEYS = (CELLS / "all_keys.toml").read_text("utf-8")


def write(folder: Path, text: str) -> Path:
    """A cell file; its program lies beside it."""
    (folder / "wave.arps").write_text((CELLS / "wave.arps").read_text("utf-8"), "utf-8")
    path = folder / "cell.toml"
    path.write_text(text, "utf-8")
    return path


def built(path: Path) -> Job:
    """The job of a cell file."""
    return build_job(load_cell(path), path)


def drawn(job: Job) -> None:
    """Each shape lies in a frame that a recording has, and all the robots' shapes lie within what a view looks at."""
    known = {"world", *(part.name for part in job.parts)}
    for arm in job.arms:
        names = ["tool", "finger_left", "finger_right", *(f"link{i + 1}" for i in range(arm.arm.n))]
        known |= {Scope(arm.name, ()).frame(name) for name in names}
    for base in job.bases:
        known |= {Scope(base.name, ()).frame(name) for name in ("base_link", *wheel_frames(base.base))}
        known |= {Scope(base.name, ()).frame("body")} if base.base.balances else set()
        castors = [wheel for wheel in base.base.wheels if wheel.kind == "castor" and not wheel.driven]
        known |= {Scope(base.name, ()).frame(f"castor_{k + 1}") for k in range(len(castors))}  # the report makes them
    assert set(job.scene.frames()) <= known
    assert {view.follow for view in job.scene.views} <= {*known, None}
    assert all(np.isfinite(np.array(view.eye + view.target)).all() for view in job.scene.views)

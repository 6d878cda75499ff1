"""Whether a base was where its task wanted it, by its true pose; the controller's own belief counts for nothing."""

from __future__ import annotations

import numpy as np

from holonom.app.job import BaseJob
from holonom.arrays import Array
from holonom.closed_loop.base_kernels import LogBuffer
from holonom.mobile.drive.failed_motor import motors_hold_all
from holonom.mobile.odometry import integrate
from holonom.sim.base.log import columns

__all__ = ["PathJudge"]

MS = 1e-3


class PathJudge:
    """Compares true poses with where they should be, millisecond by millisecond. Mutable state: the worst, the way.

    A path is its reference; velocities are the twist that was commanded, within the limits of the cell, as a path from
    where the base stood; a base that holds should be where it was.

    Parameters
    ----------
    job
        A base with a tolerance.
    """

    def __init__(self, job: BaseJob) -> None:
        assert job.task.tolerance is not None
        self._tolerance, self._keep, self._base, self._task = (
            job.task.tolerance,
            job.settings.keep,
            job.base,
            job.task,
        )
        path = np.zeros((1, 2)) if job.task.path is None else job.task.path.pose[:, :2]
        self._length = float(np.hypot(*np.diff(path, axis=0).T).sum())
        self.given_up = ""
        """What was not asked any more after motors were lost: "heading", "path", or nothing."""
        self._on = 0.0  # m of the path on which it was within its tolerance
        self._last: Array | None = None  # (1, 3) where it should have been last
        self._worst = [(0.0, 0.0), (0.0, 0.0)]  # error and time, of place (m) and heading (rad)

    @property
    def kept(self) -> float:
        """Part of the path's length on which it was within both of its tolerances, 0 to 1."""
        return min(self._on / self._length, 1.0) if self._length > 0.0 else 1.0

    def see(self, first: int, log: LogBuffer) -> None:
        """Look at a buffer whose first millisecond is given."""
        true = columns(log.body, "x", "y", "theta")
        wanted = self._wanted(log, true)
        place, heading = _sizes(true - wanted)
        within = (place <= self._tolerance.position) & (heading <= self._tolerance.heading)
        for k, error in enumerate(self._asked(place, heading, log.controlled["dead"].astype(np.int64))):
            at = int(np.argmax(error))
            if error[at] > self._worst[k][0]:
                self._worst[k] = float(error[at]), MS * (first + at)
        path = wanted if self._last is None else np.vstack([self._last, wanted])
        steps = np.hypot(*np.diff(path[:, :2], axis=0).T)
        self._on += float(steps[within[len(within) - len(steps) :]].sum())
        self._last = wanted[-1:].copy()

    def _wanted(self, log: LogBuffer, true: Array) -> Array:
        """Poses (N, 3) where it should have been."""
        if self._task.path is not None:
            return columns(log.controlled, "ref_x", "ref_y", "ref_theta")
        start = true[0] if self._last is None else self._last[0]
        if self._task.velocities is None:
            return np.broadcast_to(start, true.shape)
        steps = MS * columns(log.controlled, "ref_vx", "ref_vy", "ref_w")
        return integrate(steps, start=start)

    def verdict(self) -> str:
        """What was missed, in words; "" where the path was kept."""
        (place, at), (turn, then) = self._worst
        missed = []
        if place > self._tolerance.position:
            missed.append(f"{place:.3g} m off at {at:.2f} s, {self._tolerance.position:.3g} m are allowed")
        if turn > self._tolerance.heading:
            allowed = np.degrees(self._tolerance.heading)
            missed.append(f"{np.degrees(turn):.3g} deg off at {then:.2f} s, {allowed:.3g} deg are allowed")
        if not missed:
            return ""
        if self._task.path is None:
            what = "its place was not kept" if self._task.velocities is None else "the velocities were not driven"
            return f"{what}: {'; '.join(missed)}"
        share = f"{100.0 * self.kept:.0f} % of the path was driven within its tolerance"
        return f"the path was not kept: {'; '.join(missed)}; {share}"

    def _asked(self, place: Array, heading: Array, dead: Array) -> tuple[Array, Array]:
        """Errors (N,) of place, m, and heading, rad, that decide: only the chosen one, once motors are lost."""
        if self._keep == "both" or not dead.any():
            return place, heading
        lame = np.isin(dead, [d for d in np.unique(dead) if not motors_hold_all(self._base, int(d))])
        if lame.any():
            self.given_up = "heading" if self._keep == "path" else "path"
        if self._keep == "path":
            return place, np.where(lame, 0.0, heading)
        return np.where(lame, 0.0, place), heading


def _sizes(error: Array) -> tuple[Array, Array]:
    """Errors (N,) of place, m, and heading, rad, of differences of poses (N, 3)."""
    turn: Array = np.abs((error[:, 2] + np.pi) % (2.0 * np.pi) - np.pi)
    return np.hypot(error[:, 0], error[:, 1]), turn

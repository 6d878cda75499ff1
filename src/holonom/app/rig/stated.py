"""What a run says once, at its beginning, for tools of ROS: robots, fixed frames, the photograph, parts to look at."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from holonom.app.job import ArmJob, Job, Obstacle
from holonom.app.recording import Recorder
from holonom.app.recording.scope import Scope
from holonom.app.recording.urdf import BASE, urdf_of
from holonom.arrays import Array
from holonom.geometry import Box
from holonom.signals import FixedFrames, Marker, Markers, Photograph, RobotDescription

__all__ = ["put_stated"]

BRASS, GREY = (0.69, 0.55, 0.34, 1.0), (0.4, 0.45, 0.5, 0.6)
"""Colours of parts and of obstacles."""


def put_stated(job: Job, recorder: Recorder) -> None:
    """Record what a job states, at time 0."""
    for arm in job.arms:
        scope = Scope(arm.name, arm.arm.limits.names)
        text = urdf_of(arm.arm.model, frame=scope.frame, joint=scope.dotted)
        recorder.scoped(arm.name, arm.arm.limits.names).put(RobotDescription(0.0, text))
    fixed = list(_fixed(job))
    if fixed:
        parents, names, poses = zip(*fixed, strict=True)
        recorder.put(FixedFrames(0.0, parents, names, np.stack(poses)))
    if job.photograph is not None:
        recorder.put(Photograph(0.0, job.photograph.png, "png"))
    markers = (*(_part(part.name, part.radius, part.thickness) for part in job.parts), *map(_obstacle, job.obstacles))
    if markers:
        recorder.put(Markers(0.0, markers))


def _fixed(job: Job) -> Iterator[tuple[str, str, Array]]:
    """Parent, name and pose of what stands."""
    for arm in job.arms:
        yield _base(job, arm)
    taken = {"world", "map", *(part.name for part in job.parts)}
    for surface in job.surfaces:
        if surface.name not in taken:
            yield "world", surface.name, surface.pose


def _base(job: Job, arm: ArmJob) -> tuple[str, str, Array]:
    """Where an arm stands: in the world, or on the base that carries it."""
    name, T, mount = Scope(arm.name, ()).frame(BASE), np.array(arm.arm.model.base), arm.mount
    if mount is None or mount.robot is None:
        return "world", name, T if mount is None else mount.T @ T
    carrier = next(base for base in job.bases if base.name == mount.robot)
    return Scope(carrier.name, ()).frame("base_link"), name, carrier.frames[mount.frame] @ mount.T @ T


def _part(name: str, radius: float, thickness: float) -> Marker:
    return Marker(name, "cylinder", np.eye(4), (2.0 * radius, 2.0 * radius, thickness), BRASS)


def _obstacle(one: Obstacle) -> Marker:
    """An obstacle, which stands in the world."""
    if isinstance(one.shape, Box):
        x, y, z = (float(v) for v in one.shape.size)
        return Marker("world", "cube", one.T, (x, y, z), GREY)
    wide = 2.0 * one.shape.radius
    return Marker("world", "cylinder", one.T, (wide, wide, one.shape.height), GREY)

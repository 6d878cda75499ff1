"""What a run puts at the beginning of its recording, so that the report can be made from that alone."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from holonom.app.report.attached import CELL, PHOTOGRAPH, PHOTOGRAPH_WORDS, SCENE, photograph_text, text_of
from holonom.app.report.drawing.scene_text import scene_text
from holonom.app.report.findings.facts import (
    ArmFacts,
    BaseFacts,
    CellFacts,
    FaultFacts,
    FieldFacts,
    JointFacts,
    PartFacts,
    PatchFacts,
    RobotFacts,
    Rows,
)
from holonom.arrays import Array
from holonom.geometry import Box, Cylinder, hull, outline
from holonom.mechanics import Arm
from holonom.sim import Floor, RectangularPatch, RoundPatch, Step

if TYPE_CHECKING:
    from holonom.app.job import ArmJob, BaseJob, Job, Obstacle

__all__ = [
    "attachments_of", "cell_facts", "edge_of", "obstacle_corners", "patch_corners", "step_corners", "step_name",
]  # fmt: skip

PROGRAM = "program.arps"
EDGE = 0.03  # m, of the floor beyond an edge, that is drawn


def attachments_of(
    job: Job, controller: int = -1, *, rated: Sequence[Arm] = (), patches: Sequence[str] = ()
) -> dict[str, bytes]:
    """Return the files for `Recorder(attachments=...)`: cell, scene, programs, photograph.

    Parameters
    ----------
    job
        What is run.
    controller
        Which of an arm's settings this run is under.
    rated
        The arms, in their order, with the speeds that their models state, where a cell keeps below those.
    patches
        Names of the floor's patches.
    """
    files = {
        CELL: text_of(CellFacts, cell_facts(job, controller, rated=rated, patches=patches)),
        SCENE: scene_text(job.scene),
    }
    for arm in job.arms:
        if arm.program is not None:
            files[_program_name(arm)] = "\n".join(arm.program.lines).encode()
    if job.photograph is not None:
        files |= {PHOTOGRAPH: job.photograph.png, PHOTOGRAPH_WORDS: photograph_text(job.photograph)}
    return files


def cell_facts(job: Job, controller: int = -1, *, rated: Sequence[Arm] = (), patches: Sequence[str] = ()) -> CellFacts:
    """Return what a recording says of a job; parameters as of `attachments_of`."""
    stated = rated or [arm.arm for arm in job.arms]
    arms = [_arm_robot(arm, controller, own) for arm, own in zip(job.arms, stated, strict=True)]
    fields = [FieldFacts(place.name, _rows(place.T), place.size, place.height) for place in job.fields]
    names = [*patches, *(f"patch {k + 1}" for k in range(len(patches), len(job.floor.patches)))]
    floor = [PatchFacts(name, _rows(patch_corners(p))) for name, p in zip(names, job.floor.patches, strict=False)]
    return CellFacts(
        title=job.name,
        description=job.description,
        seed=job.seed,
        notes=job.notes,
        robots=(*arms, *(_base_robot(base, job.floor) for base in job.bases)),
        patches=tuple(floor),
        fields=tuple(fields),
        parts=tuple(PartFacts(part.name, part.thickness) for part in job.parts),
        obstacles=tuple(PatchFacts(one.name, _rows(obstacle_corners(one))) for one in job.obstacles),
        steps=tuple(PatchFacts(step_name(s), _rows(step_corners(s, edge_of(job.bases)))) for s in job.floor.steps),
    )


def patch_corners(patch: RectangularPatch | RoundPatch) -> Array:
    """Corners (N, 2) of a patch in the world; of a round one, of a polygon."""
    if isinstance(patch, RoundPatch):
        return np.array(patch.centre) + outline(Cylinder(patch.radius, 0.0))
    half = outline(Box((patch.length, patch.width, 0.0)))
    c, s = math.cos(patch.angle), math.sin(patch.angle)
    return np.array(patch.centre) + half @ np.array([[c, s], [-s, c]])


def step_corners(step: Step, length: float) -> Array:
    """Corners (4, 2) in the world of the floor just beyond an edge, as long as is drawn of it, m."""
    c, s = math.cos(step.rise), math.sin(step.rise)
    half = np.array([[0.0, -0.5], [1.0, -0.5], [1.0, 0.5], [0.0, 0.5]]) * [EDGE, length]
    return np.array(step.position) + half @ np.array([[c, s], [-s, c]])


def step_name(step: Step) -> str:
    """What an edge is called in figures."""
    return f"step, {1e3 * step.height:.3g} mm"


def edge_of(bases: Sequence[BaseJob]) -> float:
    """How long an edge is drawn, m: wider than the bases."""
    return 4.0 * max((base.base.radius for base in bases), default=0.25)


def obstacle_corners(obstacle: Obstacle) -> Array:
    """Corners (N, 2) in the world of what an obstacle covers, seen from above."""
    shape, T = obstacle.shape, obstacle.T
    corners = outline(shape)
    if isinstance(shape, Cylinder):
        return T[:2, 3] + corners
    both = np.array([[*corner, sign * 0.5 * shape.height] for corner in corners for sign in (-1.0, 1.0)])
    return hull((both @ T[:3, :3].T + T[:3, 3])[:, :2])


def _program_name(arm: ArmJob) -> str:
    return f"{arm.name}/{PROGRAM}" if arm.name else PROGRAM


def _arm_robot(job: ArmJob, controller: int, stated: Arm) -> RobotFacts:
    model = job.arm.model
    moving = [model.joints[i] for i in model.independent]
    motors = [joint.motor for joint in moving]
    kinematics = ArmFacts(
        base=_rows(model.base),
        joints=tuple(
            JointFacts(
                joint.name, joint.kind, _rows(joint.before), _rows(joint.after), model.parent(i),
                None if joint.mimic is None else (joint.mimic.joint, joint.mimic.multiplier, joint.mimic.offset),
            )
            for i, joint in enumerate(model.joints)
        ),
        tip=model.tool_joint,
        tool=_rows(model.tool),
        fixed=job.mount is None or job.mount.robot is None,
    )  # fmt: skip
    return RobotFacts(
        name=job.name,
        kind="arm",
        model=model.name,
        controller=job.settings[controller].controller,
        drives=job.drives,
        joints=tuple(joint.name for joint in moving),
        kinds=tuple(joint.kind for joint in moving),
        limits={
            "speed": _limit(stated.limits.speed),
            "torque": _limit(job.arm.limits.torque),
            "current": _limit(None if motor is None else motor.max_current for motor in motors),
            "voltage": _limit(None if motor is None else motor.max_voltage for motor in motors),
        },
        program=_program_name(job) if job.program is not None else "",
        arm=kinematics,
    )


def _base_robot(job: BaseJob, floor: Floor) -> RobotFacts:
    base, motor, gear = job.base, job.drive.motor, job.drive.gear
    names, count = base.driven, len(base.driven)
    parts: dict[str, object] = {"slip detection": job.settings.slip, "traction control": job.settings.traction}
    parts["motor watch"] = job.settings.watch
    faults = [(f.time, f.wheel if isinstance(f.wheel, str) else names[f.wheel], f.kind) for f in job.faults]
    facts = BaseFacts(
        wheels=tuple(base.wheels),
        radius=base.radius,
        alpha=base.alpha,
        mass=base.mass,
        com=tuple(map(float, base.com)),
        com_height=base.com_height,
        motor=motor,
        gear=gear,
        friction=floor.material.peak,
        slip_at_peak=floor.material.slip_at_peak,
        faults=tuple(FaultFacts(*fault) for fault in faults),
        position_tolerance=None if job.task.tolerance is None else job.task.tolerance.position,
        heading_tolerance=None if job.task.tolerance is None else job.task.tolerance.heading,
    )
    return RobotFacts(
        name=job.name,
        kind="base",
        model=base.name,
        controller=", ".join(name for name, part in parts.items() if part is not None),
        drives=job.drives,
        joints=names,
        kinds=("revolute",) * count,
        limits={
            "speed": _limit([motor.no_load_speed / abs(gear.ratio)] * count),
            "current": _limit([motor.max_current] * count),
            "voltage": _limit([motor.max_voltage] * count),
        },
        base=facts,
    )


def _limit(values: Iterable[float | None]) -> tuple[float | None, ...]:
    return tuple(float(value) if value is not None and 0.0 < value < math.inf else None for value in values)


def _rows(values: Sequence[Sequence[float]] | Array) -> Rows:
    return tuple(tuple(map(float, row)) for row in values)

"""`holonom calibrate dynamics`: masses, moments and friction of an arm from a recorded motion."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from holonom.app.console.answer import Answer
from holonom.app.console.output import prepare_output
from holonom.app.recording import read_recording
from holonom.errors import InputError
from holonom.mechanics import Arm
from holonom.mechanics.identification import Identification, identify
from holonom.model.load import found_model

__all__ = ["calibrate_dynamics"]

FILE = "dynamics.json"


def calibrate_dynamics(
    recording: Path, arm_name: str, *, cutoff: float, friction: bool = True, output: Path | None = None
) -> Answer:
    """Identify an arm from the measured positions and torques of a recording.

    Parameters
    ----------
    recording : MCAP file with /joint_states.
    arm_name : preset or URDF file: kinematics, gear ratios, and what the motion cannot tell.
    cutoff : of the zero-phase filter, Hz.
    friction : whether friction is identified too.
    output : folder for `dynamics.json`.

    Raises
    ------
    InputError
        No such recording or arm, another number of joints, or a motion that tells too little.
    """
    arm = Arm(found_model(arm_name))
    read = read_recording(recording)
    track = read.joints
    if track.position.shape[1] != arm.n or track.effort.shape[1] != arm.n:
        raise InputError(
            f"{recording} holds positions of {track.position.shape[1]} joints and torques of {track.effort.shape[1]}; "
            f"arm {arm_name!r} has {arm.n}: name the arm that was recorded with --arm"
        )
    recorded, named = read.joint_names, arm.limits.names
    if tuple(recorded) != tuple(named):
        raise InputError(
            f"{recording} was recorded of joints {', '.join(recorded)}; arm {arm_name!r} has {', '.join(named)}: "
            "name the arm that was recorded with --arm"
        )
    folder = None if output is None else prepare_output(output)
    found = identify(arm, track.time, track.position, track.effort, cutoff=cutoff, friction=friction)
    data = {"recording": str(recording), "arm": arm_name, **_data(found), "notes": list(arm.model.notes)}
    if folder is not None:
        (folder / FILE).write_text(json.dumps(data, indent=2, allow_nan=False) + "\n", encoding="utf-8")
    return Answer(_text(arm, found), data)


def _data(found: Identification) -> dict[str, Any]:
    names = found.base.names
    columns = zip(found.base.columns, found.base.formulas(), found.values, found.deviations, strict=True)
    bodies, joints = found.model.bodies, found.model.joints
    assert bodies is not None
    return {
        "base_parameters": [
            {"name": names[k], "formula": formula, "value": float(value), "deviation": float(deviation)}
            for k, formula, value, deviation in columns
        ],
        "condition": found.condition,
        "weak": list(found.weak),
        "without_effect": list(found.without_effect),
        "torque_noise": found.noise.tolist(),
        "torque_misfit": found.misfit.tolist(),
        "torque_misfit_explained": found.explained.tolist(),
        "doubts": list(found.doubts),
        "bodies": [
            {"joint": joint.name, "mass": body.mass, "com": list(body.com), "inertia": list(body.inertia)}
            for joint, body in zip(joints, bodies, strict=True)
        ],
        "drives": [
            {
                "joint": joint.name,
                "rotor_inertia": None if joint.motor is None else joint.motor.rotor_inertia,
                "viscous": None if joint.friction is None else joint.friction.viscous,
                "coulomb_positive": None if joint.friction is None else joint.friction.coulomb_positive,
                "coulomb_negative": None if joint.friction is None else joint.friction.coulomb_negative,
            }
            for joint in joints
        ],
    }


def _text(arm: Arm, found: Identification) -> str:
    width = max(len(found.base.names[k]) for k in found.base.columns)
    weak = set(found.weak)
    lines = [f"{found.base.number} base parameters of {arm.model.name}, condition {found.condition:.3g}:"]
    for k, value, deviation in zip(found.base.columns, found.values, found.deviations, strict=True):
        name = found.base.names[k]
        mark = "  weak" if name in weak else ""
        lines.append(f"  {name:{width}}  {value:12.5g} +- {deviation:.2g}{mark}")
    lines.append("each stands for a sum of parameters: --json or -o shows it")
    if found.without_effect:
        lines.append(f"without effect on any torque: {', '.join(found.without_effect)}")
    misfit = ", ".join(f"{x:.3g}" for x in np.asarray(found.misfit))
    lines.append(f"torques of the identified arm miss the measured ones by {misfit} N m (rms, filtered)")
    lines += [f"warning: {doubt}" for doubt in found.doubts]
    lines += [f"note: {note}" for note in arm.model.notes]
    return "\n".join(lines)

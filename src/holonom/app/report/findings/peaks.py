"""The largest values of a robot's run: those that it counted itself, else those in its recording."""

from __future__ import annotations

import numpy as np

from holonom.app.recording import Recording
from holonom.app.report.sections import LimitUse
from holonom.app.report.source import RobotSource
from holonom.arrays import Array
from holonom.model.joint_kinds import kind_of

__all__ = ["limit_uses", "peaks_of"]

QUANTITIES = {
    "speed": ("rad/s", "m/s"),
    "torque": ("N m", "N"),
    "current": ("A", "A"),
    "voltage": ("V", "V"),
    "grip": ("", ""),
}
"""Their units, of joints that turn and of those that slide."""
OF_MOTORS = ("torque", "current", "voltage", "grip")
"""What ideal drives do not have."""
TITLES = {"arm": "Joint {}", "base": "Wheel {}"}
GRIP = "Share of the friction limit"


def peaks_of(robot: RobotSource) -> dict[str, Array]:
    """Largest absolute values (n,) of "speed", "torque", "current", "voltage", "error", "grip"; rms of "rms_error".

    NaN for what is not known, as forces and currents are of ideal drives.
    """
    found = _sampled(robot.recording, len(robot.facts.joints))
    for name in (*QUANTITIES, "error"):
        found[name] = _counted(robot, f"peak_{name}", found.get(name))
    found["rms_error"] = _counted(robot, "rms_error", found.get("rms_error"))
    for name in OF_MOTORS if robot.facts.ideal else ():
        found[name] = np.full(len(robot.facts.joints), np.nan)
    return found


def limit_uses(robot: RobotSource) -> list[LimitUse]:
    """Peaks against the limits that are known."""
    peaks, limits, count = peaks_of(robot), robot.facts.limits, len(robot.facts.joints)
    uses = []
    for name, units in QUANTITIES.items():
        given = limits.get(name, (1.0,) * count if name == "grip" else ())
        limit = np.array([np.nan if value is None else value for value in given], dtype=float)
        if len(limit) == count and np.isfinite(limit).any() and np.isfinite(peaks[name]).any():
            uses.append(LimitUse(_title(robot, name), _unit(robot, units), peaks[name], limit))
    return uses


def _title(robot: RobotSource, name: str) -> str:
    if name == "grip":
        return GRIP
    return f"Motor {name}" if name in ("current", "voltage") else TITLES[robot.facts.kind].format(name)


def _unit(robot: RobotSource, units: tuple[str, str]) -> str:
    kinds = {not kind_of(kind).turns for kind in robot.facts.kinds}
    return " or ".join(dict.fromkeys(units[slides] for slides in sorted(kinds)))


def _counted(robot: RobotSource, key: str, sampled: Array | None) -> Array:
    values = sampled if sampled is not None else np.full(len(robot.facts.joints), np.nan)
    told = [robot.statistics.get(joint, {}).get(key) for joint in robot.facts.joints]
    return np.array([value if given is None else given for given, value in zip(told, values, strict=True)], dtype=float)


def _sampled(recording: Recording, count: int) -> dict[str, Array]:
    """What the samples of a recording say."""
    joints = recording.true_joints if len(recording.true_joints.time) else recording.joints
    drives = recording.drives
    tracks = {"speed": joints.velocity, "torque": joints.effort, "current": drives.current, "voltage": drives.voltage}
    reference = recording.reference
    if len(reference.time) and joints.position.shape[1] == count:
        wanted = [np.interp(joints.time, reference.time, column) for column in reference.position.T]
        tracks["error"] = np.stack(wanted, axis=1) - joints.position
    held = {name: values for name, values in tracks.items() if values.shape[1:] == (count,) and len(values)}
    found = {name: np.abs(values).max(axis=0) for name, values in held.items()}
    if "error" in found:
        found["rms_error"] = np.sqrt(np.mean(tracks["error"] ** 2, axis=0))
    return found

"""Arms by name, by file, by table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from holonom.errors import UnknownName
from holonom.mechanics.arm.arm import Arm
from holonom.model import Body, DHRow, JointLimits, arm_model_from_dh
from holonom.model.load import CheckInertia, CheckMode, found_model, warn_of

__all__ = ["arm_from_dh", "load_arm"]


def load_arm(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: CheckMode = "warn",
    check_inertia: CheckInertia = True,
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Arm:
    """Return a preset arm, or one from a URDF or xacro file.

    Parameters
    ----------
    source : a preset's name ("puma560", ...), or a file that ends in .urdf, .xml or .xacro. Meshes are never opened.
    root, tip : links that are the base and the tool; by default the root of the tree and the link that is called like
        a tool, else a guess that a warning tells (see `holonom.model.read_urdf`).
    check : "warn": what a file may leave out or say too much is taken as a warning says; "strict": it is an error.
    check_inertia : whether a moving link with an inertia that no rigid body has takes the dynamics away (True), is
        taken with a warning ("warn") or without (False).
    packages : for xacro, the folder of each package that `$(find name)` may name. A xacro file is read in a process of
        its own that may read its own folder and these, and no environment.
    arguments : for xacro, the values of `$(arg name)`.

    Raises
    ------
    UnknownName
        No such preset or link; the message lists them.
    ModelError
        The file cannot be read or describes no arm; the message names file, line, element and what to do.

    Warns
    -----
    ModelWarning
        What of the file was passed over or guessed, with its line; `arm.model.notes` keeps it.
    """
    model = found_model(
        source, root=root, tip=tip, check=check, check_inertia=check_inertia, packages=packages, arguments=arguments
    )
    warn_of(model)
    return Arm(model)


def arm_from_dh(
    rows: Sequence[DHRow],
    *,
    convention: str,
    name: str = "arm",
    limits: Sequence[JointLimits] | None = None,
    bodies: Sequence[Body] | None = None,
) -> Arm:
    """Return an arm from a Denavit-Hartenberg table.

    Parameters
    ----------
    rows : one `DHRow` per joint.
    convention : "standard" or "modified"; never guessed.
    limits, bodies : one each per joint, if known.
    """
    if convention not in ("standard", "modified"):
        raise UnknownName("DH convention", str(convention), ("standard", "modified"))
    return Arm(arm_model_from_dh(rows, convention=convention, name=name, limits=limits, bodies=bodies))  # type: ignore[arg-type]

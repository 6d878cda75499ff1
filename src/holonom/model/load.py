"""One door to every arm: a preset's name, a URDF file, a xacro file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from holonom.errors import InputError, UnknownName
from holonom.model.arm import ArmModel
from holonom.model.presets import preset, preset_names
from holonom.model.urdf.check import CHECKS, Check, CheckMode
from holonom.model.urdf.inertia import CheckInertia
from holonom.model.urdf.reader import arm_model_from_urdf, urdf_model, warn_of

__all__ = ["CHECKS", "CheckInertia", "CheckMode", "found_model", "load_model", "warn_of"]

SUFFIXES = (".urdf", ".xml", ".xacro")


def load_model(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: CheckMode = "warn",
    check_inertia: CheckInertia = True,
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> ArmModel:
    """Return a preset, or the arm of a URDF or xacro file: see `holonom.load_arm` for the arguments.

    Raises
    ------
    UnknownName
        No such preset, link or package.
    ModelError
        The file is missing, or is no arm; with file and line.
    InputError
        An option that this source does not have.

    Warns
    -----
    ModelWarning
        What of a file was passed over or guessed.
    """
    model = found_model(
        source, root=root, tip=tip, check=check, check_inertia=check_inertia, packages=packages, arguments=arguments
    )
    warn_of(model)
    return model


def found_model(
    source: str | Path,
    *,
    root: str | None = None,
    tip: str | None = None,
    check: CheckMode = "warn",
    check_inertia: CheckInertia = True,
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> ArmModel:
    """Return what `load_model` does, and give no warnings: they are the model's notes."""
    suffix = Path(source).suffix.lower()
    if suffix == ".xacro":
        from holonom.model.urdf.xacro_file import expand_xacro

        robot = expand_xacro(Path(source), packages=packages or {}, arguments=arguments or {})
        return arm_model_from_urdf(robot, root=root, tip=tip, check=Check(check), check_inertia=check_inertia)
    if packages is not None or arguments is not None:
        raise InputError(f"packages= and arguments= are for xacro files; {str(source)!r} does not end in .xacro")
    if suffix in SUFFIXES:
        return urdf_model(Path(source), root=root, tip=tip, check=check, check_inertia=check_inertia)
    if root is not None or tip is not None or check_inertia is not True or check != "warn":
        raise InputError(
            f"root=, tip=, check= and check_inertia= are for files ({', '.join(SUFFIXES)}); {str(source)!r} is none"
        )
    if str(source) not in preset_names():
        raise UnknownName(f"arm preset (nor a file ending in {', '.join(SUFFIXES)})", str(source), preset_names())
    return preset(str(source))

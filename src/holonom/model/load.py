"""One door to every arm: a preset's name, a URDF file, a xacro file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from holonom.errors import InputError, UnknownName
from holonom.model.arm import ArmModel
from holonom.model.presets import preset, preset_names
from holonom.model.urdf.check import CHECKS, Check, CheckMode
from holonom.model.urdf.elements import Element
from holonom.model.urdf.inertia import CheckInertia
from holonom.model.urdf.reader import arm_model_from_urdf, urdf_document, warn_of

__all__ = ["CHECKS", "CheckInertia", "CheckMode", "found_model", "load_model", "robot_document", "warn_of"]

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
    if Path(source).suffix.lower() in SUFFIXES:
        found = Check(check)
        robot = robot_document(Path(source), found, packages=packages, arguments=arguments)
        return arm_model_from_urdf(robot, root=root, tip=tip, check=found, check_inertia=check_inertia)
    if packages is not None or arguments is not None:
        raise InputError(f"packages= and arguments= are for xacro files; {str(source)!r} does not end in .xacro")
    if root is not None or tip is not None or check_inertia is not True or check != "warn":
        raise InputError(
            f"root=, tip=, check= and check_inertia= are for files ({', '.join(SUFFIXES)}); {str(source)!r} is none"
        )
    if str(source) not in preset_names():
        raise UnknownName(f"arm preset (nor a file ending in {', '.join(SUFFIXES)})", str(source), preset_names())
    return preset(str(source))


def robot_document(
    source: str | Path,
    check: Check,
    *,
    packages: Mapping[str, str | Path] | None = None,
    arguments: Mapping[str, str] | None = None,
) -> Element:
    """Return the <robot> of a URDF file, of the text of one (any string with a "<"), or of a xacro file.

    Raises
    ------
    ModelError
        No such file; not XML; xacro that cannot be expanded.
    InputError
        `packages` or `arguments` of a file that is no xacro.
    """
    if not (isinstance(source, str) and "<" in source) and Path(source).suffix.lower() == ".xacro":
        from holonom.model.urdf.xacro_file import expand_xacro

        return expand_xacro(Path(source), packages=packages or {}, arguments=arguments or {})
    if packages is not None or arguments is not None:
        raise InputError(f"packages= and arguments= are for xacro files; {str(source)!r} does not end in .xacro")
    return urdf_document(source, check)

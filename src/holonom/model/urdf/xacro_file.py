"""xacro files, expanded by the `xacro` library in a process of its own that reads only what it may."""

from __future__ import annotations

import importlib.util
import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from holonom.errors import MissingExtra, ModelError
from holonom.model.urdf.elements import Element, parse_xml

__all__ = ["expand_xacro"]

TIME_LIMIT = 60.0
"""Seconds; a file whose macros call each other without end is stopped."""


def expand_xacro(
    file: Path, *, packages: Mapping[str, str | Path] | None = None, arguments: Mapping[str, str] | None = None
) -> Element:
    """Return the <robot> that a xacro file expands to; its elements know the file and line they were written in.

    Parameters
    ----------
    file : the xacro file. It may read files in its own folder (and below) and in those of `packages`, no others.
    packages : folder of each package that `$(find name)` may name.
    arguments : values of `$(arg name)`.

    Raises
    ------
    ModelError
        Missing file, bad xacro, a read outside those folders, an environment variable; with file and line.
    MissingExtra
        The library is not installed.
    """
    if importlib.util.find_spec("xacro") is None:
        raise MissingExtra("a xacro file", "the xacro library", "xacro")
    if not file.is_file():
        raise ModelError(f"{file}: no such file; give a xacro file")
    folders = {name: _folder(name, Path(folder)) for name, folder in (packages or {}).items()}
    request = {"file": str(file.resolve()), "packages": folders, "arguments": dict(arguments or {})}
    answer = _child(file, json.dumps(request))
    if "error" in answer:
        raise ModelError(f"{answer['file']}, line {answer['line']}: {answer['error']}")
    return parse_xml(answer["urdf"], f"{file} (expanded)", [(name, line) for name, line in answer["origins"]])


def _folder(name: str, folder: Path) -> str:
    if not folder.is_dir():
        raise ModelError(f"package {name!r}: {folder} is no folder; name the one that `$(find {name})` stands for")
    return str(folder.resolve())


def _child(file: Path, request: str) -> dict[str, Any]:
    """Run the expansion with an empty environment, in the file's folder."""
    command = [sys.executable, "-I", str(Path(__file__).with_name("xacro_child.py"))]
    try:
        done = subprocess.run(
            command,
            input=request.encode(),
            capture_output=True,
            env={},
            cwd=file.resolve().parent,
            timeout=TIME_LIMIT,
            check=False,
        )
        answer: dict[str, Any] = json.loads(done.stdout)
    except subprocess.TimeoutExpired:
        raise ModelError(f"{file}: not expanded within {TIME_LIMIT:.0f} s; do its macros call each other?") from None
    except ValueError:
        if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            raise ModelError(f"{file}: not expanded within its time; do its macros call each other?") from None
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise ModelError(f"{file}: the expansion broke off ({' '.join(last) or done.returncode})") from None
    return answer

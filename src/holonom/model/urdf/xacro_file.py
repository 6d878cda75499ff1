"""xacro files, expanded by the `xacro` library in a process of its own that reads only what it may."""

from __future__ import annotations

import importlib.util
import json
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from holonom.errors import MissingExtra, ModelError
from holonom.model.urdf.elements import Element, parse_xml

__all__ = ["expand_xacro"]

TIME_LIMIT = 60.0
"""Seconds; a file whose macros call each other without end is stopped."""
LONG = "do its macros call each other, or does it loop too often?"
NOTE = 4096
"""`xacro_child.NOTE`: bytes at the head of the error stream that name the expression being evaluated."""
LARGEST_NOTE = 2**16


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
    with tempfile.TemporaryFile() as errors:
        try:
            done = subprocess.run(
                command,
                input=request.encode(),
                stdout=subprocess.PIPE,
                stderr=errors,
                env={},
                cwd=file.resolve().parent,
                timeout=TIME_LIMIT,
                check=False,
            )
            answer: dict[str, Any] = json.loads(done.stdout)
        except subprocess.TimeoutExpired:
            raise ModelError(f"{file}: not expanded within {TIME_LIMIT:.0f} s; {LONG}") from None
        except ValueError:
            errors.seek(0)
            raise ModelError(_broken(file, done.returncode, errors.read(LARGEST_NOTE))) from None
    return answer


def _broken(file: Path, code: int, told: bytes) -> str:
    """What to say of an expansion that ended without an answer: `told` is the note of an expression, then errors."""
    if code == -getattr(signal, "SIGPROF", 0):
        note = json.loads(told[:NOTE])
        return (
            f"{note['file'] or file}, line {note['line']}: ${{{note['expression']}}} is not evaluated within a second; "
            "write the number that it stands for"
        )
    if code in (-getattr(signal, "SIGXCPU", 0), -getattr(signal, "SIGKILL", 0)):
        return f"{file}: not expanded within its time; {LONG}"
    last = told[NOTE:].decode(errors="replace").strip().splitlines()[-1:]
    return f"{file}: the expansion broke off ({' '.join(last) or code})"

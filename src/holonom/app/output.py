"""The folder that a command writes to, checked before anything else happens."""

from __future__ import annotations

import tempfile
from pathlib import Path

from holonom.errors import OutputError

__all__ = ["prepare_output"]


def prepare_output(folder: str | Path) -> Path:
    """Make a folder and see that files can be written to it; nothing is left in it.

    Raises
    ------
    OutputError
        It cannot be made or written to.
    """
    path = Path(folder)
    try:
        path.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=path):
            return path
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"cannot write to the output folder {path}: {reason}; give another one with -o") from None

"""The exception tree. Every message says what came, what is allowed and what to do.

HolonomError
├── InputError                bad input, found before anything runs (exit status 2)
│   ├── UsageError            a command line: unknown command or option, a value that does not fit
│   ├── CellError             a cell file: file, line, key
│   ├── ProgramError          an ARPS program: file, line, column, caret, hint
│   ├── ModelError            a robot description
│   │   └── MissingInertia    dynamics asked of a robot that states no inertia
│   ├── UnknownName           no such preset, joint, frame, unit, ...; lists what there is
│   ├── ShapeError            an array of the wrong shape, type or with NaN
│   ├── NotAPose              a matrix that is no rigid transform
│   ├── OutOfLimits           a joint, speed or setting outside its limits
│   ├── CalibrationError      measurements that do not determine what is calibrated
│   ├── LogError              a log: file, line, column
│   ├── ImageError            a photograph that is missing or not an image
│   ├── MissingExtra          a library that is not installed, and which extra of the package brings it
│   └── OutputError           a folder or file that cannot be written
└── RunError                  something that failed after the start (exit status 1)
    ├── MotionError           a motion that cannot be made: out of reach, limits, singular
    ├── ProgramFault          a run-time error of an ARPS program, with its line
    │   └── RunawayProgram    a loop that neither moves nor waits
    ├── ContactFault          something was pressed harder than the cell allows
    ├── DriveFault            a following error, an encoder or a drive fault
    ├── LevelFault            a level of a controller that is late, silent or sends what cannot be followed
    └── OutputFault           a disk that is full, or gone, while a run writes

Beside them `ModelWarning`: a robot description that can be read, with something that it leaves to be guessed.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = [
    "CalibrationError",
    "CellError",
    "ContactFault",
    "DriveFault",
    "HolonomError",
    "ImageError",
    "InputError",
    "LevelFault",
    "LogError",
    "MissingExtra",
    "MissingInertia",
    "ModelError",
    "ModelWarning",
    "MotionError",
    "NotAPose",
    "OutOfLimits",
    "OutputError",
    "OutputFault",
    "ProgramError",
    "ProgramFault",
    "RunError",
    "RunawayProgram",
    "ShapeError",
    "UnknownName",
    "UsageError",
]


class HolonomError(Exception):
    """Root of every error that Holonom raises on purpose."""


class InputError(HolonomError, ValueError):
    """Bad input, found before anything runs. The command line ends with status 2."""


class UsageError(InputError):
    """A command line that cannot be used: an unknown command or option, a value that does not fit."""


class CellError(InputError):
    """A cell file that cannot be used; the message names file, line and key."""


class ProgramError(InputError):
    """An ARPS program that does not compile; the message names file, line and column."""


class ModelError(InputError):
    """A robot description that is not one."""


class ModelWarning(UserWarning):
    """A robot description that was read, and what of it was passed over or guessed; with file and line."""


class MissingInertia(ModelError):
    """Dynamics asked of a robot that states no masses and inertias."""


class UnknownName(InputError):
    """A name that is not in the table it was looked up in."""

    def __init__(self, kind: str, name: str, known: Iterable[str]) -> None:
        names = sorted(known)
        close = difflib.get_close_matches(name, names, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        super().__init__(f"no {kind} {name!r}; there is {', '.join(names) or 'none'}{hint}")


class ShapeError(InputError):
    """An array of the wrong shape or type."""


class NotFinite(ShapeError):
    """An array that holds NaN or infinity where numbers are needed; the message names the first and its place."""


class NotAPose(InputError):
    """A matrix that is no rigid transform."""


class OutOfLimits(InputError):
    """A value outside its limits; the message names it, the value and the limits."""


class CalibrationError(InputError):
    """Measurements that do not determine what is to be calibrated."""


class LogError(InputError):
    """A log of measurements that cannot be used; the message names file, line and column."""


class ImageError(InputError):
    """A photograph that is missing or not an image."""


class MissingExtra(InputError):
    """A library that is not installed; an extra of the package brings it. Holonom itself is on no index."""

    def __init__(self, what: str, library: str, extra: str) -> None:
        super().__init__(
            f"{what} needs {library}, which is not installed; in the clone of Holonom: pip install -e '.[{extra}]', or "
            f"install its wheel with [{extra}] (docs/start/install.md)"
        )


class OutputError(InputError):
    """A folder or file that cannot be written."""


class RunError(HolonomError):
    """Something that failed after the start. The command line ends with status 1."""


class MotionError(RunError):
    """A motion that cannot be made."""


class ProgramFault(RunError):
    """A run-time error of an ARPS program; the message names file, line and cause."""


class RunawayProgram(ProgramFault):
    """A program that loops without a motion or a wait."""


class ContactFault(RunError):
    """A robot that pressed on something harder than its cell allows."""


class DriveFault(RunError):
    """A servo axis that had to stop: following error, encoder or drive fault."""


class LevelFault(RunError):
    """A level of a controller that is late, silent or sends what cannot be followed; the one below has stopped."""


class OutputFault(RunError):
    """A disk that is full, or gone, while a run writes; what was written until then is kept."""

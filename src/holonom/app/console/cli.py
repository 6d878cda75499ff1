"""The command line, `holonom COMMAND ...`: finds the command in its table, runs it, prints its `Answer`.

What a command raises decides the exit status: 2 for an `InputError`, usage errors too (nothing has been written), 1
for a `RunError` (the records are kept), 130 for Ctrl-C and SIGTERM, 141 where nobody reads what it prints (`| head`).
Any other exception is a defect and shows its traceback.
"""

from __future__ import annotations

import errno
import json
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from holonom.app.console.answer import Answer
from holonom.app.console.interrupts import INTERRUPTED, Interrupted
from holonom.app.console.pipes import BROKEN, drop_unread
from holonom.app.console.printable import say
from holonom.app.console.usage import find_command, show_help
from holonom.errors import HolonomError, InputError, RunError, UsageError

__all__ = ["main"]

BAD_INPUT, FAILED = 2, 1
NO_PATH = (errno.ENAMETOOLONG, errno.ELOOP, errno.ENOTDIR)
"""What the system says of a path that none can be, wherever it is first looked at."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : the arguments behind the program's name; those of the process unless given.

    Returns
    -------
    The exit status: 0, 2 (bad input), 1 (failed after the start), 130 (interrupted) or 141 (nobody reads).
    """
    words = list(sys.argv[1:] if argv is None else argv)
    try:
        try:
            return _status(words)
        finally:  # after --help too, which leaves by SystemExit
            if sys.stdout is not None:
                sys.stdout.flush()
    except BrokenPipeError:
        if not drop_unread():
            raise  # another pipe than those
        return BROKEN


def _status(words: Sequence[str]) -> int:
    """Run a command, print what came of it, and return the exit status."""
    as_json = "--json" in words
    try:
        if show_help(words):
            return 0
        command, options = find_command(words)
        answer: Answer = command.build(options)
    except InputError as error:
        return _fail(error, BAD_INPUT, as_json=as_json)
    except RunError as error:
        return _fail(error, FAILED, as_json=as_json)
    except OSError as error:
        if error.errno not in NO_PATH:
            raise
        return _fail(UsageError(f"{error.filename}: {error.strerror}; give another path"), BAD_INPUT, as_json=as_json)
    except KeyboardInterrupt as stop:
        say(str(stop if isinstance(stop, Interrupted) else Interrupted()), error=True)
        return INTERRUPTED
    if as_json:
        say(_json(answer.data))
    elif answer.text:
        say(answer.text)
    return answer.status


def _json(data: Mapping[str, Any]) -> str:
    """JSON in ASCII; the one control character that JSON leaves as it is, is written as the others are."""
    return json.dumps(data, indent=2, allow_nan=False).replace("\x7f", "\\u007f")


def _fail(error: HolonomError, status: int, *, as_json: bool) -> int:
    if as_json:
        details = {"type": type(error).__name__, "message": str(error), "status": status}
        say(_json({"error": details}))
    else:
        say(f"holonom: error: {error}", error=True)
    return status

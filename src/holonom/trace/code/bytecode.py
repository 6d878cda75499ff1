"""Python's own bytecode on disk, which goes by time and size: an edit that keeps both is not seen.

Bytecode may also say that it is to be compared with its source by content (PEP 552), and Python keeps to that. So it
shall be for all that compiled code is made of.
"""

from __future__ import annotations

import contextlib
import importlib.util
import marshal
import os
import py_compile
import sys
from pathlib import Path

__all__ = ["runs"]


def runs(file: str, text: bytes) -> bool:
    """Whether Python's bytecode of a file is that of its text; from the next process on, Python compares the two."""
    kept = importlib.util.cache_from_source(file)
    try:
        code, status = Path(kept).read_bytes(), os.stat(file)
    except OSError:
        return True
    times = b"".join(int(value).to_bytes(8, "little")[:4] for value in (status.st_mtime, status.st_size))
    if code[:16] != importlib.util.MAGIC_NUMBER + bytes(4) + times:
        return True
    try:
        same = bool(marshal.loads(code[16:]) == compile(text, file, "exec", dont_inherit=True))
    except (EOFError, SyntaxError, TypeError, ValueError):
        same = False
    if not sys.dont_write_bytecode:
        with contextlib.suppress(OSError, py_compile.PyCompileError):
            py_compile.compile(file, kept, doraise=True, invalidation_mode=py_compile.PycInvalidationMode.CHECKED_HASH)
    return same

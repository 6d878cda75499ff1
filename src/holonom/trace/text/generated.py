"""Generated modules: text in memory, run once in a process; their machine code is kept as any other is."""

from __future__ import annotations

import hashlib
import linecache
import sys
import threading
from types import ModuleType

from holonom.trace.code.sources import stamp_of_text

__all__ = ["load_module"]

LOADING = threading.RLock()
"""Held while a module is made: another thread must not find half of it."""


def load_module(name: str, source: str) -> ModuleType:
    """Return `source` as an imported module; its compiled functions are made at most once per machine."""
    full_name = f"holonom_kernels.{name}_{hashlib.sha256(source.encode()).hexdigest()[:16]}"
    with LOADING:
        if full_name not in sys.modules:
            _run(full_name, source)
        return sys.modules[full_name]


def _run(full_name: str, source: str) -> None:
    file = f"<{full_name}>"
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)  # for tracebacks
    module = ModuleType(full_name)
    module.__dict__["__stamp__"] = stamp_of_text(source)
    sys.modules[full_name] = module
    try:
        exec(compile(source, file, "exec"), module.__dict__)
    except BaseException:
        del sys.modules[full_name]
        raise

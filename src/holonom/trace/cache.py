"""Generated modules on disk: written once, named by the hash of everything they depend on, loaded by later processes.

Numba's own cache beside them does not notice an edited helper in another module; a new name does.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import importlib.util
import os
import sys
import tempfile
import threading
from pathlib import Path
from types import ModuleType

from holonom.errors import OutputError

__all__ = ["cache_folder", "load_module"]

HELPERS = [
    "columns",
    "direct",
    "elementary",
    "emit",
    "functions",
    "graph",
    "lanes",
    "layout",
    "line",
    "lower",
    "pointer",
    "remainder",
    "results",
    "transpose",
]
"""Our modules that a kernel is made by and made of."""
LOADING = threading.RLock()
"""Held while a module is made: another thread must not find half of it."""


def cache_folder() -> Path:
    """Return the folder of generated kernels: `HOLONOM_CACHE`, else the user's cache folder."""
    named = os.environ.get("HOLONOM_CACHE")
    base = os.environ.get("XDG_CACHE_HOME") or (Path.home() / ".cache")
    return Path(named) if named else Path(base) / "holonom"


@functools.lru_cache(maxsize=1)
def _environment() -> str:
    """Return what every kernel depends on beside its own text: Numba, its code generator, Python and our helpers."""
    import llvmlite
    import numba

    helpers = [Path(__file__).with_name(f"{name}.py").read_text() for name in HELPERS]
    return "\n".join([numba.__version__, llvmlite.__version__, sys.version, *helpers])


def load_module(name: str, source: str) -> ModuleType:
    """Return `source` as an imported module, compiled at most once per machine.

    Raises
    ------
    OutputError
        The cache folder cannot be written.
    """
    digest = hashlib.sha256((_environment() + source).encode()).hexdigest()[:16]
    full_name, path = f"holonom_kernels.{name}_{digest}", cache_folder() / f"{name}_{digest}.py"
    with LOADING:
        if full_name not in sys.modules:
            if not path.exists():
                _write(path, source)
            _import(full_name, path)
        return sys.modules[full_name]


def _import(full_name: str, path: Path) -> None:
    spec = importlib.util.spec_from_file_location(full_name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[full_name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[full_name]
        raise


def _write(path: Path, source: str) -> None:
    """Write a file so that another process sees all of it or nothing."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
        with os.fdopen(handle, "w") as file:
            file.write(source)
        os.replace(temporary, path)
    except OSError as problem:
        with contextlib.suppress(OSError, NameError):
            os.unlink(temporary)
        raise OutputError(
            f"kernel cache {path.parent} cannot be written ({problem.strerror}); set HOLONOM_CACHE to a folder that can"
        ) from problem

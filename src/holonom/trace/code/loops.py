"""Compiled functions written by hand, and those of generated modules: Numba's, kept in our cache.

Numba stamps what it keeps with its own file only; an edited helper in another file is not seen. Here the key is the
text of everything that a function can be made of (`trace.sources`), beside Python, Numba, the processor and the types.
"""

from __future__ import annotations

import functools
import inspect
import os
import pickle
import sys
import time
import warnings
from collections.abc import Callable
from hashlib import sha256
from types import CodeType
from typing import Any

import llvmlite
import numba
import numpy as np
from numba import njit
from numba.core import config, sigutils, typeinfer, types
from numba.core.caching import NullCache
from numba.core.ccallback import CFunc
from numba.core.compiler import CompileResult
from numba.core.errors import NumbaWarning
from numba.core.serialize import dumps

from holonom.trace.code.cache import Entry, cache_folder
from holonom.trace.code.sources import stamp

__all__ = ["callback", "loop"]

OPTIONS = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DISABLE_INTEL_SVML")
"""Settings of Numba that change what it makes."""


def loop(*given: Any, **options: Any) -> Any:
    """Compile a function as `numba.njit` does, and keep its machine code in the kernel cache.

    Parameters
    ----------
    given : the function, as in `@loop`; or the one signature that is compiled at once; or nothing.
    options : of `numba.njit`: error_model, fastmath, forceinline, nogil, ...

    Returns
    -------
    Numba's dispatcher, or the decorator. Its `stats` count what was loaded (`cache_hits`) and compiled
    (`cache_misses`); in the file that `HOLONOM_CACHE_LOG` names, each is a line, with the process and its CPU times, s,
    at which compiling began and ended: what it calls is compiled in between.
    """
    if given and inspect.isfunction(given[0]):
        return _loop(given[0], None, options)
    return lambda function: _loop(function, given[0] if given else None, options)


def callback(signature: Any, **options: Any) -> Callable[[Any], Any]:
    """Compile a function for C as `numba.cfunc` does, and keep its machine code; it has an `address`."""
    args, result = sigutils.normalize_signature(signature)

    def decorate(function: Any) -> Any:
        made = CFunc(function, (args, result), locals={}, options=options)
        _keep(made, function)
        made.compile()
        return made

    return decorate


def _loop(function: Any, signature: Any, options: dict[str, Any]) -> Any:
    made = njit(**options)(function)
    if made is function:  # compiling is switched off
        return made
    _keep(made, function)
    if signature is not None:
        with typeinfer.register_dispatcher(made):  # it may call itself
            made.compile(signature)
            made.disable_compile()
    return made


def _keep(made: Any, function: Any) -> None:
    cache = _Kept(function, type(made).__name__)
    made._cache = cache
    made._compiler.compile = cache.watched(made._compiler.compile)


class _Kept(NullCache):
    """What Numba asks before it compiles a function, and tells afterwards."""

    def __init__(self, function: Any, kind: str) -> None:
        self._function, self._kind = function, kind
        self._title = f"{function.__module__}.{function.__qualname__}".replace("<locals>.", "")
        self._locked: dict[Any, Entry] = {}

    @property
    def cache_path(self) -> str:
        return str(cache_folder())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function, or None: then nobody else compiles it until it is saved here, or has failed."""
        target_context.refresh()
        args, _ = sigutils.normalize_signature(sig)
        entry = self._entry(sig, target_context.codegen())
        if entry is None:
            return None
        found = _read(entry, target_context)
        if found is None:
            entry.lock()
            self._locked[args] = entry
            found = _read(entry, target_context)
            if found is None:
                return None
            self._unlock(args)
        _log("loaded", self._title)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        args, _ = sigutils.normalize_signature(sig)
        entry = self._locked.get(args)
        if entry is None:
            return
        try:
            if data.lifted or data.library.has_dynamic_globals:
                warnings.warn(f"{self._title} holds addresses of this process; it is not cached", NumbaWarning, 2)
            else:
                entry.write(dumps(data._reduce()))
        finally:
            self._unlock(args)

    def watched(self, compile: Callable[..., Any]) -> Callable[..., Any]:
        """What compiles, and lets others try where it failed."""

        @functools.wraps(compile)
        def watch(args: Any, return_type: Any) -> Any:
            begin = time.process_time()
            try:
                made = compile(args, return_type)
            except BaseException:
                self._unlock(args)
                raise
            _log("compiled", f"{os.getpid()} {begin:.3f} {time.process_time():.3f} {self._title}")
            return made

        return watch

    def _unlock(self, args: Any) -> None:
        entry = self._locked.pop(args, None)
        if entry is not None:
            entry.unlock()

    def _entry(self, sig: Any, codegen: Any) -> Entry | None:
        """Where the machine code for a signature lies; None if it cannot be said what it is made of."""
        args, result = sigutils.normalize_signature(sig)
        made_of = [self._kind, _identity(self._function), *map(_identity, args), str(result)]
        if None in made_of:
            return None
        text = "\n".join([*_environment(), *map(str, codegen.magic_tuple()), *map(str, made_of)])
        return Entry(self._title, sha256(text.encode()).hexdigest()[:32])


def _read(entry: Entry, target_context: Any) -> Any:
    data = entry.read()
    if data is None:
        return None
    try:
        return CompileResult._rebuild(target_context, *pickle.loads(data))
    except Exception:  # whatever Numba, LLVM and pickle find in what is whole, but not what they wrote
        entry.say_damaged()
        return None


@functools.cache
def _environment() -> tuple[str, ...]:
    """What all machine code depends on, beside its own text and the processor."""
    versions = [sys.version, getattr(sys, "abiflags", ""), numba.__version__, llvmlite.__version__, np.__version__]
    return (*versions, *(f"{name} {getattr(config, name, None)}" for name in OPTIONS))


def _identity(value: Any, within: tuple[Any, ...] = ()) -> str | None:
    """Text that is another one wherever a value would lead to other machine code; None if there is no such text."""
    if isinstance(value, types.Type):
        return _identity_of_type(value)
    function = getattr(value, "py_func", getattr(value, "_defn", value))
    if not inspect.isfunction(function):
        return sha256(dumps(value)).hexdigest()
    if function in within:
        return "itself"
    made_of = _stamp(function.__globals__, function.__code__.co_filename)
    held = [_identity(cell.cell_contents, (*within, function)) for cell in function.__closure__ or ()]
    if made_of is None or None in held:
        return None
    return " ".join([function.__module__, function.__qualname__, made_of, _text(function.__code__), *map(str, held)])


def _identity_of_type(value: Any) -> str | None:
    """Of what an argument is: names and order of fields, and the text that says what its operators do."""
    if isinstance(value, types.Dispatcher):
        return _identity(value.dispatcher)
    parts: list[str | None] = [str(value)]
    if isinstance(value, types.BaseTuple):
        kinds: Any = value
        parts += [_identity_of_type(each) for each in kinds]
    made = getattr(value, "instance_class", None)
    if made is not None:
        parts.append(f"{made.__module__}.{made.__qualname__}{getattr(made, '_fields', '')}")
    if not type(value).__module__.startswith("numba."):
        module = sys.modules[type(value).__module__]
        parts.append(_stamp(vars(module), module.__file__ or ""))
    return None if None in parts else " ".join(map(str, parts))


def _text(code: CodeType) -> str:
    """What a function does, of several on one line or of a text run twice."""
    constants = [
        _text(value)
        if isinstance(value, CodeType)
        else repr(sorted(map(repr, value)))
        if isinstance(value, frozenset)
        else repr(value)
        for value in code.co_consts
    ]
    return repr((code.co_firstlineno, code.co_code, code.co_names, code.co_freevars, constants))


def _stamp(names: dict[str, Any], file: str) -> str | None:
    """Hash of all that a module can be made of; None where it has no file, or not the one that Python runs."""
    if "__stamp__" in names:  # a generated module
        return names["__stamp__"]
    if not os.path.isfile(file):
        return None
    spec = names.get("__spec__")  # of a script that was started with -m: its real name
    return stamp(spec.name if spec else names["__name__"], os.path.abspath(file))


def _log(what: str, about: str) -> None:
    file = os.environ.get("HOLONOM_CACHE_LOG")
    if file:
        with open(file, "a", encoding="utf-8") as lines:
            lines.write(f"{what} {about}\n")

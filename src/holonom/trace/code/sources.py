"""What compiled code is made of: the text of its module and of every module that this imports, directly or not.

The imports are read, not run. A stamp is the hash of all these texts, so that no time stamp is trusted: neither that of
a source, nor that of Python's own bytecode (`trace.bytecode`).
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from holonom.trace.code.bytecode import runs
from holonom.trace.code.cache import BEGAN, say

__all__ = ["imports", "sources", "stamp", "stamp_of_text"]

Module = tuple[str, str]
"""Name and file."""
HOME = str(Path(__file__).parents[3])
"""Where the package lies."""
IMPORT = re.compile(
    r"(?:^|[;:])[ \t]*(?:from[ \t]+([.\w]+)[ \t]+import[ \t]*(\([^)]*\)|[^\n;]*)|import[ \t]+([^\n;]+))", re.MULTILINE
)
TYPES_ONLY = re.compile(r"^if TYPE_CHECKING:[ \t]*\n(?:[ \t]+[^\n]*\n|\n)+", re.MULTILINE)


def stamp(name: str, file: str) -> str | None:
    """Hash of all that a module can be made of; None if the process may run other lines than these.

    Parameters
    ----------
    name, file : of the module; its own package's modules and Holonom's are followed.
    """
    return _stamp(sources(name, file))


def stamp_of_text(text: str) -> str | None:
    """The same, of a module that has no file."""
    found = _stamp(_below(frozenset(_named(text, ""))))
    return found and hashlib.sha256((found + text).encode()).hexdigest()


@functools.cache
def sources(name: str, file: str) -> tuple[Module, ...]:
    """Every module that one is made of, itself first."""
    return _closure([name], _homes(name, file), {name: file})


@functools.cache
def _below(names: frozenset[str]) -> tuple[Module, ...]:
    """Holonom's modules among these, and all that they are made of."""
    return _closure(names, {"holonom": HOME})


def imports(text: str, package: str) -> set[str]:
    """Names that a text imports, of modules or of what is in them; too many rather than too few.

    Parameters
    ----------
    text : a module's source; what it imports for type checkers only is left out.
    package : what relative imports start from.
    """
    return set(_named(text, package))


def _named(text: str, package: str) -> Iterator[str]:
    plain = re.sub(r"#[^\n]*", "", TYPES_ONLY.sub("", text)).replace("\\\n", " ")
    for base, names, modules in IMPORT.findall(plain):
        if base:
            level = len(base) - len(base.lstrip("."))
            start = package.rsplit(".", level - 1)[0] if level else ""
            whole = f"{start}.{base[level:]}".strip(".") if level else base
            yield whole
            yield from (f"{whole}.{words[0]}" for words in _listed(names))
        else:
            yield from (words[0] for words in _listed(modules))


def _listed(text: str) -> Iterator[list[str]]:
    return (words for part in text.strip("() \t\n").split(",") if (words := part.split()))


def _homes(name: str, file: str) -> dict[str, str]:
    """Folder for each first part of a name that is followed; "": for all others (what lies beside a script)."""
    first, *rest = name.split(".")
    if first == "holonom":
        return {"holonom": HOME}
    package = os.path.basename(file) == "__init__.py"
    folder = Path(file).parents[len(rest) + package]
    beside = not rest and not package and folder.name not in ("site-packages", "dist-packages")
    return {"holonom": HOME, "" if beside else first: str(folder)}


def _closure(names: Iterable[str], homes: dict[str, str], known: dict[str, str] | None = None) -> tuple[Module, ...]:
    found: dict[str, str | None] = {}
    todo = list(names)
    while todo:
        name = todo.pop()
        if name in found:
            continue
        found[name] = file = (known or {}).get(name) or _file(name, homes)
        if file is not None:
            package = name if file.endswith("__init__.py") else name.rpartition(".")[0]
            todo += _imports_of(file, package)
    return tuple((name, file) for name, file in found.items() if file is not None)


def _file(name: str, homes: dict[str, str]) -> str | None:
    parts = name.split(".")
    home = homes.get(parts[0], homes.get(""))
    if home is None:
        return None
    path = os.path.join(home, *parts)
    return next(filter(os.path.isfile, (os.path.join(path, "__init__.py"), f"{path}.py")), None)


@functools.cache
def _imports_of(file: str, package: str) -> frozenset[str]:
    return frozenset(_named(_text(file).decode("utf-8", "replace"), package))


@functools.cache
def _text(file: str) -> bytes:
    return Path(file).read_bytes()


@functools.cache
def _stamp(modules: tuple[Module, ...]) -> str | None:
    whole = hashlib.sha256()
    for name, file in sorted(modules):
        digest = _digest(file)
        if digest is None:
            return None
        whole.update(name.encode() + digest)
    return whole.hexdigest()


@functools.cache
def _digest(file: str) -> bytes | None:
    text = _text(file)
    # The time of the last change of any kind, which no tool sets back; a clock of files may lag by a tick.
    if os.stat(file).st_ctime > BEGAN - 0.02 or not runs(file, text):
        say(f"{file} is newer than what Python read of it: what it is part of is not kept; start again")
        return None
    return hashlib.sha256(text).digest()

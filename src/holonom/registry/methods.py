"""Methods and the table of all of a kind."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from holonom.errors import InputError, UnknownName
from holonom.registry.parameters import Field, imported, parameters_of, read_record

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

__all__ = ["OWN", "Method", "NoParams", "Table"]

OWN = "Holonom's own"
"""Source of what comes from no book: commands, sections of the report."""


@dataclass(frozen=True, slots=True)
class NoParams:
    """Params of a method that takes none."""


@dataclass(frozen=True, slots=True)
class Method:
    """One method of a kind. Its name is that of its line in the table.

    Attributes
    ----------
    help
        One line.
    make
        `make(params)` gives what the kind's table says; itself, or its import path "module:name".
    source
        Book, paper or standard; `OWN` where there is none.
    params
        Frozen dataclass with fields made by `parameter`; itself, or its import path.
    """

    help: str
    make: Callable[[Any], Any] | str
    source: str
    params: type[Any] | str = NoParams

    @property
    def record(self) -> type[Any]:
        """The params record, imported if need be."""
        return imported(self.params) if isinstance(self.params, str) else self.params

    @property
    def fields(self) -> tuple[Field, ...]:
        """Its parameters."""
        return parameters_of(self.record)

    def build(self, params: Any) -> Any:
        """Return what `make` makes of a params record."""
        make: Callable[[Any], Any] = imported(self.make) if isinstance(self.make, str) else self.make
        return make(params)


class Table:
    """All methods of a kind, by name; those of the table first, then those that entry points add.

    Parameters
    ----------
    kind : plural, "controllers"; entry points of the group `holonom.controllers` add to it.
    one : what messages call one of them, "controller".
    product : what `make(params)` gives, in a few words.
    methods : a line each: name and `Method`, or its import path "module:NAME", which is imported when it is used.
    closed : entry points add nothing: words of a grammar, say.
    """

    def __init__(
        self, kind: str, one: str, product: str, methods: Mapping[str, Method | str], *, closed: bool = False
    ) -> None:
        self.kind, self.one, self.product, self.closed = kind, one, product, closed
        self._own = MappingProxyType(dict(methods))

    def __iter__(self) -> Iterator[str]:
        yield from self._own
        yield from sorted({point.name for point in self._points()} - self._own.keys())

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __contains__(self, name: object) -> bool:
        return any(name == known for known in self)

    def __getitem__(self, name: str) -> Method:
        """Return a method.

        Raises
        ------
        UnknownName
            No such method; the message lists them.
        InputError
            An entry point of that name that cannot be loaded, is no `Method`, or takes the name of another one.
        """
        points = [point for point in self._points() if point.name == name]
        if points and (name in self._own or len(points) > 1):
            raise InputError(f"more than one {self.one} is called {name!r}: {self._all_of(name, points)}; rename one")
        if name in self._own:
            line = self._own[name]
            found = imported(line) if isinstance(line, str) else line
        elif points:
            found = self._load(points[0])
        else:
            raise UnknownName(self.one, name, self)
        return found

    @property
    def own(self) -> tuple[str, ...]:
        """Names of the table's own lines."""
        return tuple(self._own)

    def params(self, name: str, given: Mapping[str, Any]) -> Any:
        """Return the params record of a method from named values in SI.

        Raises
        ------
        InputError
            As `__getitem__` and `read_record`.
        """
        return read_record(self[name].record, given, f"{self.one} {name!r}")

    def make(self, name: str, given: Mapping[str, Any] = MappingProxyType({})) -> Any:
        """Return what a method makes of named values; raises as `params` does."""
        return self[name].build(self.params(name, given))

    def survey(self) -> tuple[dict[str, Method], tuple[str, ...]]:
        """Return every method that is sound, and a line for each name that is not."""
        found: dict[str, Method] = {}
        problems = []
        for name in self:
            try:
                found[name] = self[name]
            except InputError as problem:
                problems.append(str(problem))
        return found, tuple(problems)

    def _points(self) -> tuple[EntryPoint, ...]:
        return () if self.closed else _entry_points(f"holonom.{self.kind}", tuple(sys.path))

    def _load(self, point: EntryPoint) -> Method:
        called = f"{self.one} {_called(point)}"
        try:
            found = point.load()
        except Exception as problem:
            raise InputError(
                f"{called} cannot be loaded: {type(problem).__name__}: {problem}; mend that package or uninstall it"
            ) from problem
        if not isinstance(found, Method):
            raise InputError(f"{called} is a {type(found).__name__}; it must be a holonom.registry.Method")
        return found

    def _all_of(self, name: str, points: Iterable[EntryPoint]) -> str:
        own = ["Holonom's own"] if name in self._own else []
        return ", ".join([*own, *map(_called, points)])


def _called(point: EntryPoint) -> str:
    package = point.dist.name if point.dist is not None else "an unknown package"
    return f"{point.name!r} = {point.value} of {package}"


@cache
def _entry_points(group: str, path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    """Entry points of a group."""
    return tuple(_all_entry_points(path).select(group=group)) if _any_of_ours(path) else ()


@cache
def _any_of_ours(path: tuple[str, ...]) -> bool:
    """Whether a package on a module search path names a group of ours: importlib.metadata takes 0.1 s to say no."""
    for folder in path:
        for file in Path(folder).glob("*-info/entry_points.txt"):
            if "[holonom." in file.read_text("utf-8", errors="replace"):
                return True
    return False


@cache
def _all_entry_points(path: tuple[str, ...]) -> EntryPoints:
    """Entry points of all that is installed on a module search path, read once."""
    from importlib.metadata import entry_points

    found: Any = entry_points()  # its type is another one from Python 3.12 on
    return found

"""How a built-in function or instruction is described: one record, from which checks and help are made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

from holonom.lang.program import Value

__all__ = [
    "Builtin",
    "Kind",
    "Parameter",
    "location",
    "new_location",
    "real",
    "target",
    "text",
    "variable",
]

Kind = Literal["real", "string", "location", "joints", "target", "text", "new location", "any", "variable"]


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter: what it is called, what it takes, and what is taken where nothing is given.

    Kinds: "real", "string", "location", "joints"; "target" is a location or joints, "text" a real or a
    string, "new location" a variable that is written, "variable" any variable or element itself. An `optional` one is
    not passed when left out.
    """

    name: str
    kind: Kind
    default: Value | None = None
    optional: bool = False

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.default is None and not self.optional


@dataclass(frozen=True, slots=True)
class Builtin:
    """A built-in function or instruction.

    Attributes
    ----------
    name : str
        As a program writes it, in capitals.
    parameters : tuple of Parameter
        With `repeat` the last one may be given several times.
    run : callable
        `run(vm, *values)`: a function returns its value; an instruction True when it is done and False
        when it has to be asked again in the next tick.
    help : str
        One line for the reference and the editor.
    result : Kind
        What a function returns.
    """

    name: str
    parameters: tuple[Parameter, ...]
    run: Callable[..., Any]
    help: str
    result: Kind = "any"
    repeat: bool = False

    @property
    def usage(self) -> str:
        """How it is written: `TRANS(x, y, ...)` for a function, `APPRO location, distance` for an instruction."""
        names = [p.name if p.required else f"[{p.name}]" for p in self.parameters]
        listed = ", ".join(names) + (", ..." if self.repeat else "")
        if self.result == "any":
            return f"{self.name} {listed}".rstrip()
        return f"{self.name}({listed})" if names else self.name


def real(name: str, default: float | None = None) -> Parameter:
    """Return a parameter that takes a number."""
    return Parameter(name, "real", default)


def text(name: str) -> Parameter:
    """Return a parameter that takes a string."""
    return Parameter(name, "string")


def location(name: str = "location", *, optional: bool = False) -> Parameter:
    """Return a parameter that takes a location."""
    return Parameter(name, "location", optional=optional)


def target(name: str = "location") -> Parameter:
    """Return a parameter that takes a location or a precision point."""
    return Parameter(name, "target")


def variable(name: str = "name") -> Parameter:
    """Return a parameter that takes a variable itself, whether it has a value or not."""
    return Parameter(name, "variable")


def new_location(name: str = "location") -> Parameter:
    """Return a parameter that names the location variable to be written."""
    return Parameter(name, "new location")

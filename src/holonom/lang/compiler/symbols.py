"""Names of a program: what they stand for, who writes them, and whether all uses agree."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from holonom.lang.diagnostics import Span

__all__ = ["PLAIN", "Scope", "Symbol", "SymbolKind", "Table", "kind_of_name"]

SymbolKind = Literal["real", "string", "location", "joints"]

PLAIN: dict[str, str] = {
    "real": "a number",
    "string": "a string",
    "location": "a location",
    "joints": "a precision point",
    "target": "a location or precision point",
    "text": "a number or a string",
    "new location": "a location variable",
}


@dataclass(slots=True)
class Symbol:
    """One variable while its program is compiled.

    `operation` and `slot` say how the machine reaches it. `kind` and `rank` (number of indices, -1 for a
    whole array whose indices are not known yet) are None until a use shows them. `written`: some
    instruction gives it a value; `used` is where it is first read.
    """

    name: str
    operation: Literal["GLOBAL", "LOCAL"]
    slot: int
    kind: SymbolKind | None = None
    rank: int | None = None
    written: bool = False
    used: Span | None = None
    kind_seen: Span | None = None


@dataclass(slots=True)
class Scope:
    """Names of one routine: parameters, AUTO and LOCAL variables; `slots` name what each call holds."""

    own: dict[str, Symbol] = field(default_factory=dict)
    slots: list[str] = field(default_factory=list)

    def automatic(self, name: str, rank: int) -> Symbol:
        """Add a variable that lives as long as one call: a parameter or AUTO."""
        key = name.lower()
        self.own[key] = Symbol(key, "LOCAL", self.hidden(key), kind_of_name(key), rank)
        return self.own[key]

    def hidden(self, name: str) -> int:
        """Return a new slot for each call; `name` is how an error calls it."""
        self.slots.append(name)
        return len(self.slots) - 1


@dataclass(slots=True)
class Table:
    """Names shared by all routines; `slots` names every variable that lives as long as the program."""

    shared: dict[str, Symbol] = field(default_factory=dict)
    slots: list[str] = field(default_factory=list)

    def find(self, name: str, scope: Scope) -> Symbol:
        """Return the symbol of a name, the routine's own before a shared one; a new name is shared."""
        key = name.lower()
        if key in scope.own:
            return scope.own[key]
        if key not in self.shared:
            self.shared[key] = self._new(key, key)
        return self.shared[key]

    def static(self, name: str, rank: int, scope: Scope, routine: str) -> Symbol:
        """Add a LOCAL variable: known to its routine only, its value kept between calls."""
        key = name.lower()
        scope.own[key] = self._new(key, f"{routine}.{key}")
        scope.own[key].rank = rank
        return scope.own[key]

    def _new(self, key: str, shown: str) -> Symbol:
        self.slots.append(shown)
        return Symbol(key, "GLOBAL", len(self.slots) - 1, kind_of_name(key))


def kind_of_name(name: str) -> SymbolKind | None:
    """Return what the first character of a name says: `$` a string, `#` a precision point, else nothing."""
    if name.startswith("$"):
        return "string"
    return "joints" if name.startswith("#") else None

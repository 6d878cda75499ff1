"""What the parts of the compiler share: the code so far, the names, the findings."""

from __future__ import annotations

from dataclasses import dataclass, field

from lark import Token

from holonom.lang.compiler.symbols import PLAIN, Scope, Symbol, SymbolKind, Table
from holonom.lang.diagnostics import Diagnostic, Node, Span, span_of
from holonom.lang.program import Op, Operand

__all__ = ["Argument", "Builder", "Signature"]


@dataclass(frozen=True, slots=True)
class Signature:
    """A routine as its callers see it."""

    name: str
    index: int
    parameters: tuple[Symbol, ...]
    scope: Scope


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument of a CALL and the parameter that takes it.

    `symbol` is the variable passed by reference, or None for a value, whose kind is `kind`; `rank` is 0
    for one value, -1 for a whole array.
    """

    node: Node
    symbol: Symbol | None
    kind: SymbolKind | None
    rank: int
    parameter: Symbol
    routine: str


@dataclass(slots=True)
class Builder:
    """The state of a compilation. `code`, `labels`, `jumps` and `scope` are those of the present routine.

    `own_names`: the AUTO and LOCAL variables of the routines compiled so far.
    """

    file: str
    lines: tuple[str, ...]
    table: Table = field(default_factory=Table)
    routines: dict[str, Signature] = field(default_factory=dict)
    arguments: list[Argument] = field(default_factory=list)
    errors: list[Diagnostic] = field(default_factory=list)
    warnings: list[Diagnostic] = field(default_factory=list)
    own_names: list[Symbol] = field(default_factory=list)
    routine: str = ""
    scope: Scope = field(default_factory=Scope)
    code: list[Op] = field(default_factory=list)
    labels: dict[str, int] = field(default_factory=dict)
    label_nodes: dict[str, Node] = field(default_factory=dict)
    jumps: list[tuple[int, str, Node]] = field(default_factory=list)
    line: int = 1

    def emit(self, code: str, operand: Operand = None) -> int:
        """Add an operation; return its place, for `land`."""
        self.code.append(Op(code, operand, self.line))
        return len(self.code) - 1

    def land(self, *places: int) -> None:
        """Let the jumps at these places end at the next operation."""
        for place in places:
            self.code[place] = self.code[place]._replace(operand=len(self.code))

    def finding(self, node: Node | Token, text: str, hint: str = "") -> Diagnostic:
        """Return what there is to say about a place in the program."""
        return self.at(span_of(node), text, hint)

    def at(self, span: Span, text: str, hint: str = "") -> Diagnostic:
        """Return what there is to say about a stretch of a line."""
        return Diagnostic(self.file, span, text, hint, self.lines[span.line - 1])

    def error(self, node: Node | Token, text: str, hint: str = "") -> None:
        """Note what stops the program from being compiled."""
        self.errors.append(self.finding(node, text, hint))

    def note_kind(self, symbol: Symbol, kind: SymbolKind, node: Node, hint: str = "") -> None:
        """Note that a variable is used as this kind; an error if it was something else before."""
        if symbol.kind is None:
            symbol.kind, symbol.kind_seen = kind, span_of(node)
        elif symbol.kind != kind:
            seen = symbol.kind_seen
            where = f" in line {seen.line}" if seen else ""
            self.error(node, f"{symbol.name!r} is {PLAIN[symbol.kind]}{where}, but {PLAIN[kind]} is wanted here", hint)

    def note_rank(self, symbol: Symbol, rank: int, node: Node) -> None:
        """Note with how many indices a variable is used (-1: as a whole array)."""
        if symbol.rank is None or (symbol.rank == -1 and rank > 0):
            symbol.rank = rank
        elif symbol.rank != rank and not (rank == -1 and symbol.rank > 0):
            was = f"an array of {symbol.rank} indices" if symbol.rank > 0 else "an array"
            was = "no array" if symbol.rank == 0 else was
            self.error(node, f"{symbol.name!r} is {was}", "an element is name[index], a whole array name[]")

"""From program text to a frozen `Program`: parse, compile each routine, then check names across routines."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from holonom.errors import ProgramError
from holonom.files import is_inside, read_text
from holonom.lang.compiler.builder import Argument, Builder, Signature
from holonom.lang.compiler.statements import block
from holonom.lang.compiler.symbols import PLAIN, Scope, Symbol, kind_of_name
from holonom.lang.compiler.syntax import lines_of, parse
from holonom.lang.diagnostics import Node, Span, nearest
from holonom.lang.locations import read_locations, split_name
from holonom.lang.machine import Array
from holonom.lang.program import Global, Program, Routine
from holonom.lang.words.foreign import foreign_hint

__all__ = ["compile_program", "load_program"]

_SHOWN_ERRORS = 20


def compile_program(text: str, file: str = "<program>", locations: Mapping[str, Array] | None = None) -> Program:
    """Compile a program text.

    Parameters
    ----------
    text : str
        One or more `.PROGRAM name(...)` ... `.END`; the first is the one that runs.
    file : str
        Name that messages use.
    locations : mapping of str to array, optional
        Taught locations: poses (4, 4) in m, and joint values (n,) in rad or m for names that begin with `#`,
        as `read_locations` returns them.

    Raises
    ------
    ProgramError
        With all that is wrong: file, line, column, the line, a caret and a hint for each.
    """
    tree = parse(text, file)
    b = Builder(file, tuple(lines_of(text)))
    given = _give(b, locations or {})
    nodes = [node for node in tree.children if isinstance(node, Node)]
    for node in nodes:
        _declare(b, node)
    routines = tuple(_routine(b, node) for node in nodes)
    _settle_arguments(b)
    _check_names(b)
    if b.errors:
        shown = sorted(b.errors, key=lambda e: (e.span.line, e.span.column))[:_SHOWN_ERRORS]
        raise ProgramError("\n".join(error.render() for error in shown))
    names = tuple(Global(name, tuple(given.get(name, ()))) for name in b.table.slots)
    return Program(file, b.lines, routines, names, tuple(b.warnings))


def load_program(
    path: Path | str,
    locations: Path | str | None = None,
    *,
    turns: Sequence[bool] | None = None,
    allow_outside: bool = False,
) -> Program:
    """Compile a program file with a location file.

    `locations` defaults to the file beside the program with the ending `.loc`, if there is one; one that is a link out
    of the folder is refused, unless `allow_outside`. `turns` says of each joint of the arm whether it turns or slides
    (see `read_locations`); all turn unless it is given.

    Raises
    ------
    ProgramError
        When a file cannot be read or is wrong.
    """
    path = Path(path)
    beside = path.with_suffix(".loc")
    taught = Path(locations) if locations is not None else beside if beside.is_file() else None
    if locations is None and taught is not None and not (allow_outside or _is_beside(taught, path)):
        raise ProgramError(f"{taught} is a link that leads out of the program's folder; copy the file into it")
    found = (
        read_locations(read_text(taught, "locations", ProgramError), str(taught), turns) if taught is not None else {}
    )
    return compile_program(read_text(path, "program", ProgramError), str(path), found)


def _is_beside(file: Path, program: Path) -> bool:
    """Whether a file lies where the program does: by its name, or where a link to the program leads."""
    return is_inside(file, program.parent) or is_inside(file, program.resolve().parent)


def _give(b: Builder, locations: Mapping[str, Array]) -> dict[str, list[tuple[tuple[int, ...], Array]]]:
    """Enter the taught locations as shared names; return their values by name."""
    given: dict[str, list[tuple[tuple[int, ...], Array]]] = {}
    for full_name, pose in locations.items():
        name, indices = split_name(full_name)
        symbol = b.table.find(name, Scope())
        symbol.kind, symbol.rank, symbol.written = kind_of_name(name) or "location", len(indices), True
        given.setdefault(symbol.name, []).append((indices, pose))
    return given


def _declare(b: Builder, node: Node) -> None:
    """Enter a routine's name and parameters, so that calls may come before it."""
    name, parameters, _ = node.children
    scope = Scope()
    for declared in parameters.children if parameters is not None else ():
        if declared is None:
            continue
        variable, whole = declared.children
        if str(variable.children[0]).lower() in scope.own:
            b.error(declared, f"parameter {str(variable.children[0])!r} is there twice")
        scope.automatic(str(variable.children[0]), 0 if whole is None else -1)
    key = name.lower()
    if key in b.routines:
        b.error(name, f"there are two programs {str(name)!r}", "give one of the two another name")
    b.routines[key] = Signature(str(name), len(b.routines), tuple(scope.own.values()), scope)


def _routine(b: Builder, node: Node) -> Routine:
    """Compile one routine."""
    name, _, body = node.children
    signature = b.routines[name.lower()]
    b.routine, b.scope, b.code = signature.name, signature.scope, []
    b.labels, b.label_nodes, b.jumps = {}, {}, []
    block(b, body)
    b.line = node.meta.end_line if node.meta.end_line <= len(b.lines) else len(b.lines)
    b.emit("RETURN")
    _resolve_labels(b)
    for symbol in signature.scope.own.values():
        if symbol not in signature.parameters:
            b.own_names.append(symbol)
    return Routine(signature.name, len(signature.parameters), tuple(b.scope.slots), tuple(b.code))


def _resolve_labels(b: Builder) -> None:
    for place, label, node in b.jumps:
        if label in b.labels:
            b.code[place] = b.code[place]._replace(operand=b.labels[label])
        else:
            b.error(node, f"there is no label {label!r} in {b.routine}", nearest(label, b.labels))
    wanted = {label for _, label, _ in b.jumps}
    for label, node in b.label_nodes.items():
        if label not in wanted:
            b.warnings.append(b.finding(node, f"label {label!r} is never used", "remove it, or GOTO it"))


def _settle_arguments(b: Builder) -> None:
    """Let what is known flow from parameters to arguments, then back, until nothing changes; then compare."""
    while sum(_tell_argument(argument) for argument in b.arguments):
        pass
    while sum(_tell_parameter(a) + _tell_argument(a) for a in b.arguments):
        pass
    for argument in b.arguments:
        parameter = argument.parameter
        kind = argument.symbol.kind if argument.symbol else argument.kind
        call = f"{parameter.name!r} of {argument.routine}"
        if kind and parameter.kind and kind != parameter.kind:
            b.error(argument.node, f"{call} is {PLAIN[parameter.kind]}, and this is {PLAIN[kind]}")
        if (argument.rank == 0) != (parameter.rank == 0):
            wanted = "one value" if parameter.rank == 0 else "a whole array, name[]"
            b.error(argument.node, f"{call} is {wanted}, and this is not")


def _tell_argument(argument: Argument) -> bool:
    """Tell the variable passed what the routine does with it; return whether that was news."""
    symbol, parameter = argument.symbol, argument.parameter
    if symbol is None:
        return False
    before = (symbol.kind, symbol.written)
    symbol.kind = symbol.kind or parameter.kind
    symbol.written = symbol.written or parameter.written
    return before != (symbol.kind, symbol.written)


def _tell_parameter(argument: Argument) -> bool:
    """Tell a parameter of unknown kind what is passed; return whether that was news."""
    kind = argument.symbol.kind if argument.symbol else argument.kind
    news = argument.parameter.kind is None and kind is not None
    argument.parameter.kind = argument.parameter.kind or kind
    return news


def _check_names(b: Builder) -> None:
    """Report every name that is used and never given a value."""
    for symbol in (*b.table.shared.values(), *b.own_names):
        if symbol.used and not symbol.written:
            _unknown(b, symbol, symbol.used)


def _unknown(b: Builder, symbol: Symbol, where: Span) -> None:
    what = {"location": "location", "joints": "precision point"}.get(symbol.kind or "", "variable")
    known = [s.name for s in b.table.shared.values() if s.written] + [s.name for s in b.own_names if s.written]
    hint = (
        foreign_hint(symbol.name.upper())
        or nearest(symbol.name, known)
        or ("teach it in the location file or SET it" if what != "variable" else "assign it before it is used")
    )
    b.errors.append(b.at(where, f"{what} {symbol.name!r} is never given a value", hint))

"""Expressions: from syntax tree to operations of the stack machine, with the kind of every value checked."""

from __future__ import annotations

from collections.abc import Callable

from lark import Token

from holonom.lang.compiler.builder import Builder
from holonom.lang.compiler.symbols import PLAIN, Symbol, SymbolKind, kind_of_name
from holonom.lang.diagnostics import Node, nearest, span_of
from holonom.lang.vm.formats import FORMATS, check_format
from holonom.lang.words.builtin import Builtin, Kind
from holonom.lang.words.foreign import OTHERWISE, foreign_hint
from holonom.lang.words.functions import FUNCTIONS, SHIFT

__all__ = ["arguments", "is_variable", "items", "reference", "value", "write"]

_FITS: dict[str, tuple[str, ...]] = {"target": ("location", "joints"), "text": ("real", "string")}


def value(b: Builder, node: Node, wanted: Kind, hint: str = "") -> SymbolKind:
    """Compile an expression that leaves one value of the wanted kind; return the kind it has."""
    kind = _NODES[node.data](b, node, wanted)
    if wanted != "any" and kind != wanted and kind not in _FITS.get(wanted, ()):
        hint = hint or ("locations are given a value with SET" if (kind, wanted) == ("location", "real") else "")
        b.error(node, f"expected {PLAIN[wanted]}, got {PLAIN[kind]}", hint)
    return kind


def is_variable(node: Node) -> bool:
    """Whether an expression is just a variable, so that it can be written or passed by reference."""
    return node.data == "variable" and (node.children[1] is not None or _name(node).upper() not in FUNCTIONS)


def reference(b: Builder, node: Node) -> tuple[Symbol, int]:
    """Compile a variable so that the variable itself is on the stack; return its symbol and its rank there.

    The rank is 0 for a single variable or an element, -1 for a whole array.
    """
    name, index = _name(node), node.children[1]
    symbol = b.table.find(name, b.scope)
    indices = index.children if isinstance(index, Node) and index.data == "index" else []
    whole = isinstance(index, Node) and index.data == "whole"
    b.note_rank(symbol, -1 if whole else len(indices), node)
    b.emit(f"REF_{symbol.operation}", symbol.slot)
    for child in indices:
        value(b, child, "real")
    if indices:
        b.emit("ELEMENT", len(indices))
    return symbol, -1 if whole else 0


def write(b: Builder, node: Node, kind: SymbolKind, hint: str = "") -> None:
    """Compile a variable that an instruction gives a value of this kind to."""
    name = _name(node)
    if node.children[1] is None and name.upper() in FUNCTIONS:
        b.error(node, f"{name.upper()} is a function of the language", "choose another name for the variable")
        return
    symbol, rank = reference(b, node)
    if rank:
        b.error(node, f"{name}[] is a whole array", f"give one element a value: {name}[index]")
    b.note_kind(symbol, kind, node, hint)
    symbol.written = True


def items(b: Builder, node: Node | None) -> tuple[str | None, ...]:
    """Compile the items of TYPE or $ENCODE: values go on the stack, the formats are returned (None: a value)."""
    codes: list[str | None] = []
    for item in node.children if node is not None else []:
        child = item.children[0]
        if child.data != "format":
            value(b, child, "text")
            codes.append(None)
            continue
        code = str(child.children[0]).upper()
        if not check_format(code):
            b.error(child, f"there is no format /{code}", f"there is {', '.join(FORMATS)}, as in /F8.2, /I4, /X3")
        codes.append(code)
    return tuple(codes)


def arguments(b: Builder, node: Node, builtin: Builtin, where: Node | Token) -> int:
    """Compile what a built-in function or instruction is given; return the number of values."""
    given = [argument.children[0] for argument in node.children]
    if given == [None]:
        given = []
    expected = list(builtin.parameters)
    if builtin.repeat:
        expected += expected[-1:] * (len(given) - len(expected))
    if len(given) > len(expected):
        hint = OTHERWISE.get(builtin.name, f"write {builtin.usage}")
        b.error(given[len(expected)] or where, f"too many values for {builtin.name}", hint)
        return 0
    given += [None] * (len(expected) - len(given))
    count = 0
    for parameter, argument in zip(expected, given, strict=True):
        if argument is not None and parameter.kind == "new location":
            _written(b, argument)
        elif argument is not None and parameter.kind == "variable":
            _itself(b, argument)
        elif argument is not None:
            value(b, argument, parameter.kind)
        elif parameter.default is not None:
            b.emit("CONST", parameter.default)
        elif parameter.required:
            b.error(where, f"{builtin.name} needs {parameter.name}", f"write {builtin.usage}")
        count += argument is not None or parameter.default is not None
    return count


def _written(b: Builder, node: Node) -> None:
    if is_variable(node):
        write(b, node, "location")
    else:
        b.error(node, "expected the name of a location variable, which is given a value here")


def _itself(b: Builder, node: Node) -> None:
    if is_variable(node):
        reference(b, node)
    else:
        b.error(node, "expected the name of a variable, or an element of an array")


def _name(node: Node) -> str:
    return str(node.children[0].children[0])


def _number(b: Builder, node: Node, _: Kind) -> SymbolKind:
    number = float(node.children[0])
    if abs(number) > 1e300:
        b.error(node, f"{node.children[0]} is too large a number")
    b.emit("CONST", number)
    return "real"


def _string(b: Builder, node: Node, _: Kind) -> SymbolKind:
    b.emit("CONST", str(node.children[0])[1:-1])
    return "string"


def _variable(b: Builder, node: Node, wanted: Kind) -> SymbolKind:
    name = _name(node)
    if not is_variable(node):
        return _call(b, node, name, [])
    kind = kind_of_name(name) or ("location" if wanted in ("location", "target", "new location") else "real")
    start = len(b.code)
    symbol, rank = reference(b, node)
    if rank:
        b.error(node, f"{name}[] is a whole array", f"use one element: {name}[index]")
    if wanted == "any":
        kind = symbol.kind or kind
    if kind_of_name(name) is None:
        b.note_kind(symbol, kind, node)
    symbol.used = symbol.used or span_of(node)
    if len(b.code) == start + 1:
        b.code[start] = b.code[start]._replace(code=f"LOAD_{symbol.operation}")
    else:
        b.emit("VALUE")
    return symbol.kind or kind


def _paren(b: Builder, node: Node, wanted: Kind) -> SymbolKind:
    inner = node.children[0]
    return _NODES[inner.data](b, inner, wanted)


def _unary(b: Builder, node: Node, _: Kind) -> SymbolKind:
    operator, operand = node.children
    value(b, operand, "real")
    b.emit("UNARY", operator.type)
    return "real"


def _binary(b: Builder, node: Node, _: Kind) -> SymbolKind:
    left, operator, right = node.children
    string = operator.type in ("PLUS", "COMPARE") and (_is_text(left) or _is_text(right))
    for operand in (left, right):
        value(b, operand, "string" if string else "real")
    name = _COMPARISONS[str(operator)] if operator.type == "COMPARE" else operator.type
    b.emit("BINARY", name)
    return "string" if string and operator.type == "PLUS" else "real"


def _compound(b: Builder, node: Node, _: Kind) -> SymbolKind:
    for part in node.children:
        value(b, part, "location")
    b.emit("COMPOUND")
    return "location"


def _here(b: Builder, node: Node, wanted: Kind) -> SymbolKind:
    joints = wanted == "joints"
    b.emit("HERE_JOINTS" if joints else "HERE", int(node.children[0].type == "WHERE"))
    return "joints" if joints else "location"


def _shift(b: Builder, node: Node, _: Kind) -> SymbolKind:
    value(b, node.children[0], "location")
    arguments(b, node.children[1], SHIFT, node)
    b.emit("SHIFT")
    return "location"


def _encode(b: Builder, node: Node, _: Kind) -> SymbolKind:
    b.emit("ENCODE", items(b, node.children[0]))
    return "string"


def _function(b: Builder, node: Node, _: Kind) -> SymbolKind:
    head, given = node.children
    return _call(b, node, str(head if isinstance(head, Token) else head.children[0]), [given])


def _call(b: Builder, node: Node, name: str, given: list[Node]) -> SymbolKind:
    function = FUNCTIONS.get(name.upper())
    if function is None:
        hint = foreign_hint(name) or nearest(name.upper(), FUNCTIONS)
        if name.lower() in b.table.shared or name.lower() in b.scope.own:
            hint = f"an element of an array is written {name}[index]"
        elif name.lower() in b.routines:
            hint = f"a routine is called with CALL {name}(...)"
        b.error(node, f"there is no function {name!r}", hint)
        return kind_of_name(name) or "real"
    empty = Node("arguments", [Node("argument", [None])])
    count = arguments(b, given[0] if given else empty, function, node)
    b.emit("FUNCTION", (function.name, count))
    return function.result  # type: ignore[return-value]


def _is_text(node: Node) -> bool:
    """Whether an expression is a string, seen from its shape: names of strings begin with $."""
    if node.data in ("string", "encode"):
        return True
    if node.data in ("variable", "function"):
        head = node.children[0]
        return str(head if isinstance(head, Token) else head.children[0]).startswith("$")
    if node.data == "binary" and node.children[1].type != "PLUS":
        return False
    return node.data in ("paren", "binary") and any(map(_is_text, (node.children[0], node.children[-1])))


_COMPARISONS = {"==": "EQ", "<>": "NE", "<": "LT", "<=": "LE", "=<": "LE", ">": "GT", ">=": "GE", "=>": "GE"}

_NODES: dict[str, Callable[[Builder, Node, Kind], SymbolKind]] = {
    "number": _number,
    "string": _string,
    "variable": _variable,
    "paren": _paren,
    "unary": _unary,
    "binary": _binary,
    "compound": _compound,
    "here_value": _here,
    "function": _function,
    "shift": _shift,
    "encode": _encode,
}

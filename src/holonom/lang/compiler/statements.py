"""Instructions with a syntax of their own, and the structures that contain others."""

from __future__ import annotations

from collections.abc import Callable

from lark import Token

from holonom.lang.compiler.builder import Argument, Builder
from holonom.lang.compiler.expressions import arguments, is_variable, items, reference, value, write
from holonom.lang.compiler.symbols import Symbol, kind_of_name
from holonom.lang.diagnostics import Node, nearest, span_of
from holonom.lang.words.foreign import foreign_hint
from holonom.lang.words.instructions import INSTRUCTIONS

__all__ = ["block"]


def block(b: Builder, node: Node) -> None:
    """Compile the lines of a block."""
    for line in node.children:
        for child in line.children:
            if isinstance(child, Token):
                continue
            b.line = child.meta.line
            if child.data == "label":
                _label(b, child)
            else:
                _STATEMENTS[child.data](b, child)


def _label(b: Builder, node: Node) -> None:
    name = str(node.children[0]).lower()
    if name in b.labels:
        b.error(node, f"label {name!r} is already there", "give one of the two another name")
    b.labels[name] = len(b.code)
    b.label_nodes[name] = node


def _goto(b: Builder, node: Node) -> None:
    b.jumps.append((b.emit("JUMP"), str(node.children[0].children[0]).lower(), node.children[0]))


def _if_goto(b: Builder, node: Node) -> None:
    condition, target = node.children
    value(b, condition, "real")
    b.jumps.append((b.emit("JUMP_IF_TRUE"), str(target.children[0]).lower(), target))


def _assign(b: Builder, node: Node) -> None:
    variable, expression = node.children
    kind = kind_of_name(str(variable.children[0].children[0]))
    if kind == "joints":
        b.error(variable, "a precision point is given a value with SET", "write SET in front of it")
        return
    foreign = foreign_hint(str(variable.children[0].children[0])) if kind == "string" else ""
    write(b, variable, kind or "real", "a location is given a value with SET")
    value(b, expression, kind or "real", foreign)
    b.emit("ASSIGN")


def _set(b: Builder, node: Node) -> None:
    variable, expression = node.children
    kind = kind_of_name(str(variable.children[0].children[0])) or "location"
    if kind == "string":
        b.error(variable, "SET gives a location its value, not a string", "leave out SET")
        return
    write(b, variable, kind, "a number is given a value without SET")
    value(b, expression, kind)
    b.emit("ASSIGN")


def _here(b: Builder, node: Node) -> None:
    word, variable = node.children
    kind = kind_of_name(str(variable.children[0].children[0])) or "location"
    if kind == "string":
        b.error(variable, f"{word.upper()} takes a location or a precision point, not a string")
        return
    write(b, variable, kind)
    b.emit("HERE_JOINTS" if kind == "joints" else "HERE", int(word.type == "WHERE"))
    b.emit("ASSIGN")


def _action(b: Builder, node: Node) -> None:
    word, given = node.children
    instruction = INSTRUCTIONS[word.upper()]
    b.emit("ACTION", (instruction.name, arguments(b, given, instruction, word)))


def _decompose(b: Builder, node: Node) -> None:
    variable, expression = node.children
    index = variable.children[1]
    if index is None or (index.data == "index" and len(index.children) != 1):
        b.error(variable, "DECOMPOSE fills six elements of an array", "write DECOMPOSE name[first] = location")
        return
    symbol = b.table.find(str(variable.children[0].children[0]), b.scope)
    b.note_rank(symbol, 1, variable)
    b.emit(f"REF_{symbol.operation}", symbol.slot)
    if index.data == "index":
        value(b, index.children[0], "real")
    else:
        b.emit("CONST", 0.0)
    b.note_kind(symbol, "real", variable)
    symbol.written = True
    value(b, expression, "location")
    b.emit("DECOMPOSE")


def _speed(b: Builder, node: Node) -> None:
    expression, *words = node.children
    names = [str(word.type) for word in words]
    if "MONITOR" in names and len(names) > 1:
        b.error(words[0], "SPEED MONITOR takes a per cent for all motions and no other word")
    value(b, expression, "real")
    b.emit("SPEED", tuple(names))


def _tolerance(b: Builder, node: Node) -> None:
    word, always = node.children
    b.emit("TOLERANCE", (word.type.lower(), int(always is not None)))


def _continuous(b: Builder, node: Node) -> None:
    b.emit("CONTINUOUS", int(node.children[0].type == "ON"))


def _wait(b: Builder, node: Node) -> None:
    start = len(b.code)
    value(b, node.children[0], "real")
    b.emit("WAIT", start)


def _timer(b: Builder, node: Node) -> None:
    _, number, seconds = node.children
    value(b, number, "real")
    value(b, seconds, "real")
    b.emit("TIMER")


def _type(b: Builder, node: Node) -> None:
    b.emit("TYPE", items(b, node.children[0]))


def _call(b: Builder, node: Node) -> None:
    name, given = node.children
    routine = b.routines.get(name.lower())
    if routine is None:
        b.error(name, f"there is no program {str(name)!r} in this file", nearest(name.lower(), b.routines))
        return
    passed = [a.children[0] for a in given.children] if given is not None else []
    if passed == [None]:
        passed = []
    if len(passed) != len(routine.parameters) or None in passed:
        names = ", ".join(p.name for p in routine.parameters)
        hint = f"write CALL {routine.name}({names})"
        b.error(name, f"{routine.name} takes {len(routine.parameters)} values, not {len(passed)}", hint)
        return
    for parameter, argument in zip(routine.parameters, passed, strict=True):
        if is_variable(argument):
            symbol, rank = reference(b, argument)
            symbol.used = symbol.used or span_of(argument)
            b.arguments.append(Argument(argument, symbol, None, rank, parameter, routine.name))
        else:
            kind = value(b, argument, "any")
            b.arguments.append(Argument(argument, None, kind, 0, parameter, routine.name))
    b.emit("CALL", routine.index)


def _return(b: Builder, _: Node) -> None:
    b.emit("RETURN")


def _local(b: Builder, node: Node) -> None:
    word, *declared = node.children
    for declaration in declared:
        name, whole, first = declaration.children
        text, rank = str(name.children[0]), 0 if whole is None else -1
        if text.lower() in b.scope.own:
            b.error(declaration, f"{text!r} is already a name of this program")
            continue
        if word.type == "AUTO":
            symbol = b.scope.automatic(text, rank)
        else:
            symbol = b.table.static(text, rank, b.scope, b.routine)
        if first is not None:
            _first_value(b, declaration, symbol, first, once=word.type == "LOCAL")


def _first_value(b: Builder, node: Node, symbol: Symbol, first: Node, *, once: bool) -> None:
    """Give a variable its first value: of LOCAL only where it has none yet."""
    if symbol.rank:
        b.error(node, f"{symbol.name}[] is a whole array", "give its elements their values one by one")
        return
    past = -1
    if once:
        b.emit(f"REF_{symbol.operation}", symbol.slot)
        b.emit("FUNCTION", ("DEFINED", 1))
        past = b.emit("JUMP_IF_TRUE")
    b.emit(f"REF_{symbol.operation}", symbol.slot)
    kind = value(b, first, symbol.kind or "any")
    b.note_kind(symbol, kind, node)
    symbol.written = True
    b.emit("ASSIGN")
    if once:
        b.land(past)


def _if(b: Builder, node: Node) -> None:
    condition, then, *others, otherwise = node.children
    ends = [_branch(b, condition, then)]
    for other in others:
        b.line = other.meta.line
        ends.append(_branch(b, *other.children))
    if otherwise is not None:
        block(b, otherwise.children[0])
    b.land(*ends)


def _branch(b: Builder, condition: Node, then: Node) -> int:
    """Compile one branch; return the place of the jump over what follows it."""
    value(b, condition, "real")
    skip = b.emit("JUMP_IF_FALSE")
    block(b, then)
    end = b.emit("JUMP")
    b.land(skip)
    return end


def _for(b: Builder, node: Node) -> None:
    variable, first, last, step, body = node.children
    if not is_variable(variable) or variable.children[1] is not None:
        b.error(variable, "FOR counts in a variable that is no array element and no function")
        return
    hidden = f"(FOR of line {b.line}, entered by a GOTO?)"
    limit, stride = b.scope.hidden(hidden), b.scope.hidden(hidden)
    write(b, variable, "real")
    value(b, first, "real")
    b.emit("ASSIGN")
    for slot, expression in ((limit, last), (stride, step)):
        b.emit("REF_LOCAL", slot)
        if expression is None:
            b.emit("CONST", 1.0)
        else:
            value(b, expression, "real")
        b.emit("ASSIGN")
    start = len(b.code)
    value(b, variable, "real")
    b.emit("LOAD_LOCAL", limit)
    b.emit("LOAD_LOCAL", stride)
    leave = b.emit("JUMP_IF_PAST")
    line = b.line
    block(b, body)
    b.line = line
    write(b, variable, "real")
    value(b, variable, "real")
    b.emit("LOAD_LOCAL", stride)
    b.emit("BINARY", "PLUS")
    b.emit("ASSIGN")
    b.emit("JUMP", start)
    b.land(leave)


def _while(b: Builder, node: Node) -> None:
    condition, body = node.children
    line, start = b.line, len(b.code)
    value(b, condition, "real")
    leave = b.emit("JUMP_IF_FALSE")
    block(b, body)
    b.line = line
    b.emit("JUMP", start)
    b.land(leave)


def _do(b: Builder, node: Node) -> None:
    body, condition = node.children
    start = len(b.code)
    block(b, body)
    b.line = condition.meta.line
    value(b, condition, "real")
    b.emit("JUMP_IF_FALSE", start)


def _case(b: Builder, node: Node) -> None:
    selector, *values, otherwise = node.children
    slot = b.scope.hidden(f"(CASE of line {b.line}, entered by a GOTO?)")
    b.emit("REF_LOCAL", slot)
    value(b, selector, "real")
    b.emit("ASSIGN")
    ends = []
    for branch in values:
        *wanted, body = branch.children
        b.line = branch.meta.line
        hits = [_equal(b, slot, expression) for expression in wanted]
        skip = b.emit("JUMP")
        b.land(*hits)
        block(b, body)
        ends.append(b.emit("JUMP"))
        b.land(skip)
    if otherwise is not None:
        block(b, otherwise.children[0])
    b.land(*ends)


def _equal(b: Builder, slot: int, expression: Node) -> int:
    b.emit("LOAD_LOCAL", slot)
    value(b, expression, "real")
    b.emit("BINARY", "EQ")
    return b.emit("JUMP_IF_TRUE")


_STATEMENTS: dict[str, Callable[[Builder, Node], None]] = {
    "assign": _assign,
    "set": _set,
    "here": _here,
    "action": _action,
    "decompose": _decompose,
    "speed": _speed,
    "tolerance": _tolerance,
    "continuous": _continuous,
    "wait": _wait,
    "timer": _timer,
    "type": _type,
    "call": _call,
    "return": _return,
    "local": _local,
    "goto": _goto,
    "if_goto": _if_goto,
    "if": _if,
    "for": _for,
    "while": _while,
    "do": _do,
    "case": _case,
}

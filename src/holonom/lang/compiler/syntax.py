"""From text to syntax tree, and from what the parser says to what a person can use."""

from __future__ import annotations

from functools import cache
from importlib import resources
from typing import Any, cast

from lark import Lark, Token, UnexpectedCharacters, UnexpectedEOF, UnexpectedToken
from lark.exceptions import UnexpectedInput

from holonom.errors import ProgramError
from holonom.files import check_lines
from holonom.lang.diagnostics import Diagnostic, Node, Span, nearest, span_of
from holonom.lang.words.foreign import OTHERWISE, foreign_hint
from holonom.lang.words.instructions import INSTRUCTIONS
from holonom.lang.words.table import SYNTAX_WORDS

__all__ = ["WORDS", "lines_of", "parse"]

LINES = 20_000
"""Lines of a program."""
DEEPEST = 300
"""Nodes of the syntax tree within each other: an operator, a bracket or an instruction is one, a block three."""
_STATEMENTS = (*INSTRUCTIONS, *(name for name, word in SYNTAX_WORDS.items() if word.begins))

# Words of the language and the terminal that each of them is for the parser.
WORDS: dict[str, str] = {
    **{name: name if word.carries else f"_{name}" for name, word in SYNTAX_WORDS.items()},
    **dict.fromkeys(INSTRUCTIONS, "ACTION"),
}
"""Words that no name may be, with the token of the grammar that each is."""
_OPENS = {"_IF": "IF", "_FOR": "FOR", "_WHILE": "WHILE", "_CASE": "CASE", "_DO": "DO"}
_NAMES = {"TEXT_NAME", "JOINTS_NAME"}
_ARITHMETIC = {"PLUS", "MINUS", "STAR", "SLASH", "POWER", "MOD", "AND", "OR", "XOR", "BAND", "BOR", "BXOR"}
_VALUES = {"NAME", "NUMBER", "MINUS", "NOT", "COM", "TIMER", "HERE", "WHERE", "_SHIFT", "_ENCODE"}
# What is said in one phrase: the terminals that show it, those it covers besides, and the phrase.
_GROUPS: tuple[tuple[set[str], set[str], str], ...] = (
    (
        {"STRING", "LPAR"},
        _VALUES,
        "a value",
    ),
    ({"ACTION"}, {WORDS[w] for w in _STATEMENTS} | {"NAME", "NUMBER", "_NL"}, "an instruction"),
    ({"OR"}, _ARITHMETIC | {"COMPARE"}, "an operator"),
)
_PLAIN = {
    "_NL": "the end of the line",
    "$END": "the end of the file",
    "NAME": "a name",
    "NUMBER": "a number",
    "EQUAL": "'='",
    "LPAR": "'('",
    "RPAR": "')'",
    "LSQB": "'['",
    "RSQB": "']'",
    "COMMA": "','",
    "COLON": "':'",
    "_COLON_EOL": "':' and the end of the line",
    "_PROGRAM": ".PROGRAM",
    "_DOT_END": ".END",
}


def parse(text: str, file: str) -> Node:
    """Return the syntax tree of a program text.

    Raises
    ------
    ProgramError
        At the first place where the text is not ARPS.
    """
    check_lines(text, file, most=LINES)
    if not text.strip():
        raise ProgramError(f"{file}: the program is empty; it needs .PROGRAM name() ... .END")
    try:
        tree = cast(Node, _parser().parse(text + "\n"))
    except UnexpectedCharacters as error:
        raise ProgramError(_stray_character(error, text, file).render()) from None
    except (UnexpectedToken, UnexpectedEOF) as error:
        raise ProgramError(_misplaced(error, text, file).render()) from None
    _check_nesting(tree, text, file)
    return tree


def lines_of(text: str) -> list[str]:
    """Return the lines of a text as the parser counts them: only a line end ends one."""
    return text.removesuffix("\n").split("\n")


def _check_nesting(tree: Node, text: str, file: str) -> None:
    """Raise `ProgramError` at the first place that is deeper than the compiler goes."""
    waiting = [(tree, 0)]
    while waiting:
        node, depth = waiting.pop()
        if depth > DEEPEST:
            span = span_of(node)
            what = f"nested too deeply: {DEEPEST} levels of operators, brackets and blocks are allowed"
            hint = "use variables for parts of it, or CALL a program"
            raise ProgramError(Diagnostic(file, span, what, hint, _line(text, span.line)).render())
        waiting += [(child, depth + 1) for child in reversed(node.children) if isinstance(child, Node)]


@cache
def _parser() -> Lark:
    """Return the parser; it is built at the first use and keeps nothing of what it has parsed."""
    grammar = resources.files("holonom.lang.compiler").joinpath("arps.lark").read_text(encoding="utf-8")
    return Lark(
        grammar,
        parser="lalr",
        lexer="basic",
        propagate_positions=True,
        tree_class=Node,
        maybe_placeholders=True,
        lexer_callbacks={"NAME": _word, "TEXT_NAME": _encode},
    )


def _word(token: Token) -> Token:
    kind = WORDS.get(token.upper())
    return token if kind is None else token.update(type=kind)


def _encode(token: Token) -> Token:
    return token.update(type="_ENCODE") if token.upper() == "$ENCODE" else token


def _line(text: str, number: int) -> str:
    lines = lines_of(text)
    return lines[number - 1] if number <= len(lines) else ""


def _stray_character(error: UnexpectedCharacters, text: str, file: str) -> Diagnostic:
    source = _line(text, error.line)
    found = source[error.column - 1 : error.column]
    if found == '"':
        what, hint = "this string does not end in its line", 'close it with "'
    else:
        first = source.split(maxsplit=1)[0] if source.strip() else ""
        usual = "a comment begins with ;" if found in "/#!%'" else ""
        what, hint = f"{found!r} has no meaning here", foreign_hint(first.partition("[")[0]) or usual
    return Diagnostic(file, Span(error.line, error.column, error.column + 1), what, hint, source)


def _misplaced(error: UnexpectedInput, text: str, file: str) -> Diagnostic:
    """Explain a token that cannot stand where it stands."""
    token: Token = error.token  # type: ignore[attr-defined]
    parser = error.interactive_parser
    accepted: set[str] = parser.accepts()  # type: ignore[no-untyped-call]
    read = parser.parser_state.value_stack
    before = _word_before(read)
    if before is not None and _begins_line(before, text):
        hint = foreign_hint(before) or nearest(before.upper(), _STATEMENTS) or "an assignment is written name = value"
        what = f"there is no instruction {str(before)!r}"
        return Diagnostic(file, span_of(before), what, hint, _line(text, before.line or 1))
    span = span_of(token)
    if token.type == "$END":
        last = max(1, len(lines_of(text)))
        span = Span(last, len(_line(text, last)) + 1, len(_line(text, last)) + 2)
    what = f"{_describe(token)} cannot stand here; expected {_listed(accepted)}"
    opened = [t for t in read if isinstance(t, Token) and t.type in _OPENS]
    sets = "EQUAL" in accepted and any(isinstance(t, Token) and t.type == "_SET" for t in read[-2:])
    hint = OTHERWISE["SET"] if sets else _unclosed(token, opened) or _hint(token, before, accepted)
    return Diagnostic(file, span, what, hint, _line(text, span.line))


def _word_before(read: list[Any]) -> Token | None:
    """Return the token that was read last, also when the parser has already taken it for a variable."""
    last = read[-1] if read else None
    while isinstance(last, Node) and last.data in ("variable", "name"):
        last = last.children[0]
    return last if isinstance(last, Token) else None


def _begins_line(word: Token, text: str) -> bool:
    """Whether `word` is a name that begins its line, where an instruction belongs."""
    if word.type != "NAME":
        return False
    before = _line(text, word.line or 1)[: (word.column or 1) - 1].strip()
    return not before or before.isdigit() or before.endswith(":")


def _describe(token: Token) -> str:
    if token.type == "_NL":
        return "the end of the line"
    return "the end of the file" if token.type == "$END" else repr(str(token))


def _listed(accepted: set[str]) -> str:
    """Return what may stand here, in plain words."""
    said = [group for group in _GROUPS if group[0] <= accepted]
    left = accepted.difference(_NAMES, *(shown | covered for shown, covered, _ in said))
    words = [phrase for *_, phrase in said] + sorted(_PLAIN.get(kind, kind.strip("_")) for kind in left)
    return " or ".join((", ".join(words[:-1]), words[-1])) if len(words) > 1 else "".join(words)


def _unclosed(token: Token, opened: list[Token]) -> str:
    """Return what is not closed where a program ends too early."""
    if token.type not in ("_DOT_END", "_PROGRAM", "$END"):
        return ""
    if not opened:
        return "a program ends with .END" if token.type == "$END" else ""
    start = opened[-1]
    if start.type == "_DO" and len(opened) > 1 and opened[-2].line == start.line:
        start = opened[-2]
    close = "UNTIL" if start.type == "_DO" else "END"
    return f"the {_OPENS[start.type]} of line {start.line} is not closed; add {close}"


def _hint(token: Token, before: Token | None, accepted: set[str]) -> str:
    """Return what to do about it, where that is known."""
    if foreign := (foreign_hint(token) if token.type == "NAME" else "") or (foreign_hint(before) if before else ""):
        return foreign
    if token.type in ("_END", "_ELSE", "_ELSEIF", "_UNTIL", "_VALUE", "_ANY") and "ACTION" in accepted:
        return f"no block that {token.upper()} could belong to is open here"
    if token.type in ("EQUAL", "LSQB") and before is not None and before.upper() in WORDS:
        return f"{before.upper()} is a word of the language; choose another name for the variable"
    if token.type == "EQUAL" and "OR" in accepted:
        return "values are compared with =="
    if "_PROGRAM" in accepted:
        return "instructions stand between .PROGRAM name() and .END"
    if "_BY" in accepted:
        return "write SHIFT(location BY dx, dy, dz)"
    if token.upper() in WORDS and "NAME" in accepted and "ACTION" not in accepted:
        return f"{token.upper()} is a word of the language and cannot be a name"
    if token.type == "NAME":
        return nearest(token.upper(), [k.strip("_") for k in accepted if k.strip("_") in WORDS])
    return ""

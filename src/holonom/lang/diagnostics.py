"""What is wrong with a program and where: file, line, column, the line itself, a caret and a hint."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from lark import Token, Tree

__all__ = ["Diagnostic", "Node", "Span", "nearest", "span_of"]


_SHOWN = 160
"""Characters of a source line that a message shows: those around its place."""
_PICTURES = {9: " ", 127: "\u2421"} | {c: chr(0x2400 + c) for c in range(32) if c != 9}
"""Control characters as their pictures (Unicode block 2400), one column each."""


_LONG = re.compile(r"\S{80,}")
"""A word that a message does not repeat in full."""


class Node(Tree[Any]):
    """A node of the syntax tree. Its children are nodes, tokens and None, in the order of the grammar."""

    data: str
    children: list[Any]


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch of one source line: line and first column from 1, `end` one past the last column."""

    line: int
    column: int
    end: int


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding about a program text.

    Attributes
    ----------
    file : str
        Name of the file as the user gave it.
    span : Span
        Where; the caret stands under it.
    text : str
        What came and what is allowed.
    hint : str
        What to do; empty where there is nothing to add.
    source : str
        The source line.
    """

    file: str
    span: Span
    text: str
    hint: str
    source: str

    def render(self) -> str:
        """Return the message of several lines that a person reads."""
        number = str(self.span.line)
        margin = " " * len(number)
        line, column = _window(self.source, self.span.column)
        length = max(1, min(self.span.end - self.span.column + column, len(line) + 1) - column)
        caret = " " * (column - 1) + "^" * length
        place, text = f"{self.file}:{self.span.line}:{self.span.column}", _LONG.sub(_shortened, self.text)
        message = f"{place}: {text}\n  {number} | {line}\n  {margin} | {caret}"
        return f"{message}\n  hint: {self.hint}" if self.hint else message


def _shortened(word: re.Match[str]) -> str:
    return f"{word[0][:20]}... ({len(word[0])} characters)"


def _window(source: str, column: int) -> tuple[str, int]:
    """What is shown of a source line, a sign for each control character, and the column in it."""
    line = source.translate(_PICTURES)
    if len(line) <= _SHOWN:
        return line, column
    start = max(0, min(column - 1 - _SHOWN // 2, len(line) - _SHOWN))
    return line[start : start + _SHOWN], column - start


def nearest(name: str, known: Iterable[str]) -> str:
    """Return the hint "did you mean 'x'?" for the known name closest to `name`, or an empty text."""
    close = difflib.get_close_matches(name, list(known), n=1)
    return f"did you mean {close[0]!r}?" if close else ""


def span_of(node: Node | Token) -> Span:
    """Return where a node or token of the syntax tree stands; a node of several lines ends with its first."""
    where = node if isinstance(node, Token) else node.meta
    line, column = where.line or 1, where.column or 1
    end = where.end_column or column + 1
    return Span(line, column, end if where.end_line == line else column + 1)

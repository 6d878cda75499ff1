"""Which line of a TOML text each key and array element stands on; `tomllib` does not say.

The scan is meant for text that `tomllib` has accepted: it relies on the grammar and checks nothing itself.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from holonom.errors import InputError
from holonom.files import DIGITS, NESTING

__all__ = ["KeyPath", "check_bounds", "key_lines"]

KeyPath = tuple[str | int, ...]
"""Keys of tables and indices of arrays from the root down: ("camera", "points", 0, "pixel")."""

KEYS = 10_000
"""Keys and tables of a TOML file."""
_TOKEN = re.compile(
    r"(?P<skip>[ \t\r]+|\#[^\n]*)"
    r'|(?P<text>"""(?:\\.|[^\\])*?"{3,5}|\'\'\'.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\')'
    r"|(?P<mark>[\[\]{}=,.\n])"
    r"|(?P<bare>[^\s\[\]{}=,.\#\"']+)",
    re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    line: int


def key_lines(text: str) -> dict[KeyPath, int]:
    """Return the line number, from 1, of every key, table header and array element of a valid TOML text."""
    return _Scan(list(_tokens(text))).document()


def check_bounds(path: Path, text: str, problem: type[InputError]) -> None:
    """Raise `problem` where a text nests deeper, or holds more keys or a longer number, than a TOML file is read.

    The text need not be valid.
    """
    depth = dots = keys = 0
    last = ""
    for token in _tokens(text):
        mark = token.text if token.kind == "mark" else ""
        keys += mark == "=" or (mark == "[" and depth == 0 and last != "=")
        last = mark
        if keys > KEYS:
            raise problem(f"{path}:{token.line}: more than {KEYS} keys and tables; split the file")
        depth = max(0, depth + (mark in ("[", "{")) - (mark in ("]", "}")))
        dots = dots + 1 if mark == "." else 0 if mark else dots
        if max(depth, dots) > NESTING:
            raise problem(
                f"{path}:{token.line}: nested too deeply; at most {NESTING} tables and lists in each other are read"
            )
        if token.kind == "bare" and len(token.text) > DIGITS:
            raise problem(
                f"{path}:{token.line}: a number or name of {len(token.text)} characters; at most {DIGITS} are read"
            )


def _tokens(text: str) -> Iterator[_Token]:
    line = 1
    for match in _TOKEN.finditer(text):
        kind = match.lastgroup or ""
        if kind != "skip":
            yield _Token(kind, match[0], line)
        line += match[0].count("\n")


class _Scan:
    """One pass over the tokens; `lines` grows as keys are met, `counts` holds the lengths of arrays of tables."""

    def __init__(self, tokens: list[_Token]) -> None:
        self.tokens = [*tokens, _Token("mark", "\n", tokens[-1].line if tokens else 1)]
        self.at = 0
        self.lines: dict[KeyPath, int] = {}
        self.counts: dict[KeyPath, int] = {}

    def document(self) -> dict[KeyPath, int]:
        table: KeyPath = ()
        while self.at < len(self.tokens):
            if self._take("\n"):
                continue
            if self._take("["):
                table = self._header()
            else:
                self._pair(table)
        return self.lines

    def _take(self, mark: str) -> bool:
        token = self.tokens[self.at]
        taken = token.kind == "mark" and token.text == mark
        self.at += taken
        return taken

    def _header(self) -> KeyPath:
        """`[a.b]` or `[[a.b]]`, behind its first bracket; each array of tables on the way means its last element."""
        line = self.tokens[self.at].line
        array = self._take("[")
        path: KeyPath = ()
        keys = self._key()
        for number, key in enumerate(keys, start=1):
            path = (*path, key)
            self.lines.setdefault(path, line)
            if array and number == len(keys):
                self.counts[path] = self.counts.get(path, 0) + 1
            if path in self.counts:
                path = (*path, self.counts[path] - 1)
                self.lines.setdefault(path, line)
        self.at += 2 if array else 1
        return path

    def _key(self) -> list[str]:
        keys = [self._name()]
        while self._take("."):
            keys.append(self._name())
        return keys

    def _name(self) -> str:
        token = self.tokens[self.at]
        self.at += 1
        return next(iter(tomllib.loads(f"{token.text} = 0")))

    def _pair(self, table: KeyPath) -> None:
        line = self.tokens[self.at].line
        path = table
        for key in self._key():
            path = (*path, key)
            self.lines.setdefault(path, line)
        self._take("=")
        self._value(path)

    def _value(self, path: KeyPath) -> None:
        if self._take("["):
            self._array(path)
        elif self._take("{"):
            self._inline_table(path)
        else:
            while self.tokens[self.at].kind != "mark" or self.tokens[self.at].text == ".":
                self.at += 1

    def _array(self, path: KeyPath) -> None:
        index = 0
        while not self._take("]"):
            if self._take("\n") or self._take(","):
                continue
            self.lines[(*path, index)] = self.tokens[self.at].line
            self._value((*path, index))
            index += 1

    def _inline_table(self, path: KeyPath) -> None:
        while not self._take("}"):
            if not (self._take("\n") or self._take(",")):
                self._pair(path)

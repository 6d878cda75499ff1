"""XML with line numbers, read by expat without document types: no entity is ever expanded, no other file opened."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from xml.parsers import expat

from holonom.errors import ModelError
from holonom.files import decimal

__all__ = ["MAX_BYTES", "Element", "NotWellFormed", "Origin", "fault", "parse_xml", "placed"]

MAX_BYTES = 16 * 2**20
MAX_DEPTH = 64
LARGEST = 1e100
"""Of any number: products of three of them are still numbers."""
MAX_ELEMENTS = 200_000


class NotWellFormed(ModelError):
    """A document that is no XML."""


Origin = tuple[str, int]
"""File and line that an element was written at."""


@dataclass(slots=True)
class Element:
    """An XML element: where it stands, its attributes, its children."""

    tag: str
    source: str
    line: int
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list[Element]:
        """Children of a tag."""
        return [child for child in self.children if child.tag == tag]

    def need(self, tag: str, why: str) -> Element:
        """The first child of a tag; `why` says what to do where it is missing."""
        found = self.all(tag)
        if not found:
            raise fault(self, f"{self.called()} has no <{tag}>; {why}")
        return found[0]

    def called(self) -> str:
        """How a message names the element: tag and name."""
        name = self.attributes.get("name")
        return f"<{self.tag}>" if name is None else f"{self.tag} {name!r}"

    def word(self, attribute: str) -> str:
        """A text attribute that must be there and not be empty."""
        value = self.attributes.get(attribute, "").strip()
        if not value:
            raise fault(self, f'<{self.tag}> needs {attribute}="..."; it is missing or empty')
        return value

    def number(self, attribute: str, default: float | None = None) -> float:
        """A finite number; without `default` it must be there."""
        if attribute not in self.attributes and default is not None:
            return default
        return _finite(self, attribute, self.word(attribute))

    def numbers(self, attribute: str, default: tuple[float, float, float]) -> tuple[float, float, float]:
        """Three finite numbers."""
        if attribute not in self.attributes:
            return default
        words = self.attributes[attribute].split()
        if len(words) != 3:
            raise fault(self, f'<{self.tag}> {attribute}="{self.attributes[attribute]}": three numbers are needed')
        x, y, z = (_finite(self, attribute, word) for word in words)
        return x, y, z

    def misspelt(self, known: Iterable[str]) -> Iterator[tuple[Element, str]]:
        """The children whose tags are close to known ones, and what was meant."""
        names = list(known)
        for child in self.children:
            close = difflib.get_close_matches(child.tag, names, n=1, cutoff=0.75)
            if close and child.tag not in names:
                yield child, close[0]


def _short(word: str) -> str:
    return word if len(word) <= 40 else f"{word[:20]}... ({len(word)} characters)"


def _finite(element: Element, attribute: str, word: str) -> float:
    try:
        value = decimal(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise fault(element, f'<{element.tag}> {attribute}="{_short(word)}": a finite number is needed')
    if abs(value) > LARGEST:
        raise fault(element, f'<{element.tag}> {attribute}="{_short(word)}": numbers up to {LARGEST:g} are read')
    return value


def placed(element: Element, what: str) -> str:
    """Return a message that starts with the element's file and line."""
    return f"{element.source}, line {element.line}: {what}"


def fault(element: Element, what: str) -> ModelError:
    """Return an error that starts with the element's file and line."""
    return ModelError(placed(element, what))


def parse_xml(
    content: str | bytes, source: str, origins: Sequence[Origin] | None = None, *, before: int = 0
) -> Element:
    """Return the root element.

    Parameters
    ----------
    content : the document; bytes may state their encoding.
    source : what messages call it, a file name.
    origins : where each element was written, in document order, for a document that a macro processor wrote.
    before : lines of the file before the document.

    Raises
    ------
    ModelError
        Not XML; a document type (and with it any entity); too large or too deep.
    """
    if len(content) > MAX_BYTES:
        raise ModelError(f"{source}: {len(content)} bytes or more; at most {MAX_BYTES} are read")
    reader = _Reader(source, origins, "utf-8" if isinstance(content, str) else None, before)
    return reader.read(content.encode() if isinstance(content, str) else content)


class _Reader:
    """Builds the tree from expat's events."""

    def __init__(self, source: str, origins: Sequence[Origin] | None, encoding: str | None, before: int) -> None:
        self._source, self._origins, self._before = source, origins, before
        self._open: list[Element] = []
        self._root: Element | None = None
        self._count = 0
        self._parser = expat.ParserCreate(encoding)
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.StartDoctypeDeclHandler = self._doctype

    def read(self, content: bytes) -> Element:
        try:
            self._parser.Parse(content, True)
        except expat.ExpatError as error:
            problem, line = expat.ErrorString(error.code), error.lineno + self._before
            raise NotWellFormed(
                f"{self._source}, line {line}, column {error.offset + 1}: not well-formed XML ({problem})"
            ) from None
        except (LookupError, UnicodeError) as error:
            raise ModelError(f"{self._source}, line 1: not well-formed XML ({error}); save the file as UTF-8") from None
        assert self._root is not None  # expat calls an empty document ill-formed
        return self._root

    def _here(self) -> Origin:
        if self._origins is not None and self._count < len(self._origins):
            return self._origins[self._count]
        return self._source, self._parser.CurrentLineNumber + self._before

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, *self._here(), attributes)
        self._count += 1
        if len(self._open) >= MAX_DEPTH or self._count > MAX_ELEMENTS:
            raise fault(element, f"more than {MAX_DEPTH} levels or {MAX_ELEMENTS} elements; no robot needs that")
        if self._open:
            self._open[-1].children.append(element)
        else:
            self._root = element
        self._open.append(element)

    def _end(self, tag: str) -> None:
        self._open.pop()

    def _text(self, text: str) -> None:
        self._open[-1].text += text

    def _doctype(self, name: str, system: str | None, public: str | None, internal: bool) -> None:
        line = self._parser.CurrentLineNumber + self._before
        raise ModelError(
            f"{self._source}, line {line}: a document type (<!DOCTYPE {name}>) is not "
            "accepted, for its entities can read files and grow without bound; delete it"
        )

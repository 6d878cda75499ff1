"""Options of a command: fields of one record, from which argparse's are made.

`argument` makes a positional one, `option` one that is written `--name`; a `bool` is a switch. A tuple of arguments
takes one word or more; one of an option takes as many as its metavar names, or with a single metavar such as "X,Y" one
word with commas. argparse only sorts words: every value is read and checked by its field's `registry.Parameter`.
"""

from __future__ import annotations

import argparse
import dataclasses
import re
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, dataclass
from types import NoneType
from typing import Any, NoReturn, get_args, get_origin

from holonom.errors import InputError, UnknownName, UsageError
from holonom.registry import Field, check_value, parameter, parameters_of

__all__ = ["allow_outside", "argument", "option", "output", "parse_options", "quiet", "seed"]

_KEY = "holonom.option"
_NEGATIVE = re.compile(r"-(\d|\.\d|inf\b|nan\b)")
_MARK = "\0"  # before a negative number, so that argparse takes it for a value; no word of a command line holds one


@dataclass(frozen=True, slots=True)
class _Form:
    """How a field is written: its place or a flag; metavar, one or several; the group of which only one may come."""

    positional: bool = False
    metavar: str | tuple[str, ...] | None = None
    short: str = ""
    either: str = ""

    def flags(self, field: Field) -> tuple[str, ...]:
        """Return what it is called on the command line."""
        if self.positional:
            return (str(self.metavar),)
        return tuple(filter(None, (self.short, "--" + field.name.rstrip("_").replace("_", "-"))))


def argument(meaning: str, *, metavar: str, default: Any = MISSING, **given_as: Any) -> Any:
    """Return the field of a positional argument, `said` as of `registry.parameter`; with a default it may be left out.

    A tuple takes one word or more, with the default () any number.
    """
    return parameter(default, meaning=meaning, extra={_KEY: _Form(True, metavar)}, **given_as)


def option(
    default: Any,
    meaning: str,
    *,
    metavar: str | tuple[str, ...] | None = None,
    short: str = "",
    either: str = "",
    **given_as: Any,
) -> Any:
    """Return the field of an option, `said` as of `registry.parameter`; with the default MISSING it must be given.

    Of the options with the same `either` only one may come.
    """
    return parameter(default, meaning=meaning, extra={_KEY: _Form(False, metavar, short, either)}, **given_as)


def output(meaning: str) -> Any:
    """Return the field of `-o DIR`."""
    return option(None, meaning, metavar="DIR", short="-o")


def quiet() -> Any:
    """Return the field of `--quiet`, which `--json` switches on too."""
    return option(False, "no progress bar", short="-q")


def allow_outside() -> Any:
    """Return the field of `--allow-outside`."""
    return option(False, "programs, locations, photograph and layout may lie outside of the cell's folder")


def seed(default: int | None, meaning: str) -> Any:
    """Return the field of `--seed N`."""
    return option(default, meaning, metavar="N", least=0, most=2**63 - 1)


class _Parser(argparse.ArgumentParser):
    """Says what is wrong by an exception."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{message.replace(_MARK, '')}; '{self.prog} --help' says what it takes")


def parse_options(record: type[Any], words: Sequence[str], *, prog: str, description: str) -> Any:
    """Read the words behind a command into its record.

    Raises
    ------
    UsageError
        An option that there is not, a value that does not fit, one too many or too few.
    SystemExit
        Status 0, after `--help`.
    """
    fields = _fields(record)
    parser = _parser(fields, prog, description)
    _refuse_unknown(fields, words, prog)
    marked = [_MARK + word if _NEGATIVE.match(word) else word for word in words]
    found, rest = parser.parse_known_args(marked)
    if rest:
        parser.error(f"{rest[0]!r} came; it is unknown or one too many")
    given = vars(found)
    as_json = given.pop("json")
    try:
        values = {f.name: _read(form.flags(f)[-1], given[f.name], f, form) for f, form in fields if f.name in given}
    except InputError as problem:
        parser.error(str(problem))
    if as_json and any(f.name == "quiet" for f, _ in fields):
        values["quiet"] = True
    return record(**values)


def _fields(record: type[Any]) -> list[tuple[Field, _Form]]:
    forms: dict[str, _Form] = {f.name: f.metadata[_KEY] for f in dataclasses.fields(record)}
    return [(field, forms[field.name]) for field in parameters_of(record)]


def _parser(fields: Iterable[tuple[Field, _Form]], prog: str, description: str) -> _Parser:
    parser = _Parser(prog=prog, description=description, allow_abbrev=False)
    groups: dict[str, Any] = {"": parser}
    for field, form in fields:
        if form.either not in groups:
            groups[form.either] = parser.add_mutually_exclusive_group()
        _add(groups[form.either], field, form)
    parser.add_argument("--json", action="store_true", help="print the result, or the error, as JSON")
    return parser


def _add(parser: Any, field: Field, form: _Form) -> None:
    given_as: dict[str, Any] = {"help": _help(field), "default": argparse.SUPPRESS}
    if field.type is bool:
        given_as["action"] = "store_true"
    else:
        names = field.parameter.names()
        given_as["metavar"] = form.metavar or (f"{{{','.join(names)}}}" if names else None)
        given_as["nargs"] = _nargs(field, form)
    if form.positional:
        parser.add_argument(field.name, **given_as)
    else:
        parser.add_argument(*form.flags(field), dest=field.name, required=field.required, **given_as)


def _nargs(field: Field, form: _Form) -> str | int | None:
    if isinstance(form.metavar, tuple):
        return len(form.metavar)
    if not form.positional:
        return None
    if get_origin(field.type) is tuple:
        return "+" if field.required else "*"
    return None if field.required else "?"


def _help(field: Field) -> str:
    default = field.default
    stated = f", {default} unless given" if isinstance(default, (int, float, str)) and field.type is not bool else ""
    return (field.parameter.meaning + stated).replace("%", "%%")


def _refuse_unknown(fields: Iterable[tuple[Field, _Form]], words: Sequence[str], prog: str) -> None:
    """Refuse an option that there is not before argparse complains of what else it then misses."""
    known = ["--help", "--json", *(flag for field, form in fields if not form.positional for flag in form.flags(field))]
    for word in words:
        name = word.partition("=")[0]
        if name == "--":
            return
        if name.startswith("--") and name not in known:
            raise UsageError(str(UnknownName(f"option of {prog}", name, [k for k in known if k.startswith("--")])))


def _read(called: str, given_as: str | Sequence[str] | bool, field: Field, form: _Form) -> Any:
    """Return the value of what came for a field."""
    if isinstance(given_as, bool):
        return given_as
    kind = field.type
    if NoneType in get_args(kind):
        kind = next(part for part in get_args(kind) if part is not NoneType)
    if get_origin(kind) is not tuple:
        assert isinstance(given_as, str)
        return check_value(called, _from_text(called, given_as, kind), field)
    words = given_as.split(",") if isinstance(given_as, str) else given_as
    return check_value(called, tuple(_from_text(called, word, get_args(kind)[0]) for word in words), field)


def _from_text(called: str, text: str, kind: Any) -> Any:
    text = text.removeprefix(_MARK)
    try:
        return kind(text)
    except ValueError:
        raise InputError(f"{called} is {text!r}; it must be {NUMBERS[kind]}") from None


NUMBERS = {int: "a whole number", float: "a number"}

"""What was asked for on the command line: help, the version, or a command with its options."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from holonom import __version__
from holonom.app.commands import COMMANDS
from holonom.app.console.options import parse_options
from holonom.app.console.printable import say
from holonom.errors import UnknownName, UsageError
from holonom.registry import Method

__all__ = ["find_command", "show_help"]

_HELP = ("-h", "--help")
_USAGE = """usage: holonom [-h] [--version] COMMAND ...

Robot control system: everything between a joint motor and a robot program.

commands:
{commands}

'holonom COMMAND --help' says what a command takes. Exit status: 0; 2 for bad input, found before anything runs; 1 for
what fails after the start; 130 for Ctrl-C."""


def show_help(words: Sequence[str]) -> bool:
    """Print help or the version where that is what was asked; that of a command is left to it."""
    if words[:1] == ["--version"]:
        say(f"holonom {__version__}")
    elif words and words[0] in _HELP:
        sound, problems = COMMANDS.survey()
        say("\n".join([_USAGE.format(commands=_listed(sound)), *problems]))
    elif len(words) > 1 and words[1] in _HELP and words[0] not in COMMANDS and (subjects := _subjects(words[0])):
        say(f"usage: holonom {words[0]} [-h] SUBJECT ...\n\nsubjects:\n{_listed(subjects)}")
    else:
        return False
    return True


def find_command(words: Sequence[str]) -> tuple[Method, Any]:
    """Return a command and its options.

    Raises
    ------
    UsageError
        No command, one that there is not, or words behind it that it does not take.
    InputError
        A command of another package that cannot be loaded.
    """
    name = _name(words)
    command = COMMANDS[name]
    rest = words[len(name.split()) :]
    return command, parse_options(command.record, rest, prog=f"holonom {name}", description=command.help)


def _name(words: Sequence[str]) -> str:
    """Return the name of the command that the words begin with, of one word or two."""
    given_as = [word for word in words[:2] if not word.startswith("-")]
    if not given_as or words[0] != given_as[0]:
        came = f"option {words[0]!r} came before a command" if words else "no command came"
        raise UsageError(f"{came}; there is {', '.join(COMMANDS)}; 'holonom --help' says what they do")
    subjects = _subjects(given_as[0])
    if given_as[0] in COMMANDS and " ".join(given_as) not in subjects:  # a command that has subjects, too
        return given_as[0]
    if not subjects:
        _check("command", given_as[0], {name.split()[0] for name in COMMANDS})
        return given_as[0]
    if len(given_as) < 2:
        raise UsageError(
            f"holonom {given_as[0]} needs a subject; there is {', '.join(name.split()[1] for name in subjects)}"
        )
    _check(f"subject of holonom {given_as[0]}", given_as[1], [name.split()[1] for name in subjects])
    return " ".join(given_as)


def _check(kind: str, name: str, known: Iterable[str]) -> None:
    if name not in known:
        raise UsageError(str(UnknownName(kind, name, known)))


def _subjects(group: str) -> list[str]:
    return [name for name in COMMANDS if name.startswith(f"{group} ")]


def _listed(names: Iterable[str]) -> str:
    return "\n".join(f"  {name:20}{COMMANDS[name].help}" for name in names)

"""The one way of putting text into a page: whatever is no markup already is escaped.

Names, labels, program lines and events come from cells, recordings and other machines: none of it can be markup, script
or style. Characters that turn a line around or steer otherwise are shown by their numbers, as on a terminal. The page's
policy lets a browser run nothing but the scripts that were written here.
"""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Sequence
from html import escape
from string import Formatter
from typing import Any

from holonom.app.console.printable import printable

__all__ = ["Html", "colour", "html", "joined", "policy", "script_json"]

NO_CHARACTERS = re.compile("[\ufdd0-\ufdef\ufffe\uffff]")
"""What no page may hold."""
STEERS = re.compile(r"\\(?:u(061c|200[ef]|202[a-e]|206[6-9])|.)")
"""In JSON: an escape; of a mark of direction, its number."""
COLOUR = re.compile(r"#[0-9a-fA-F]{3,8}|[a-zA-Z]{1,30}|var\(--[a-z]+\)")
NEUTRAL = "#64748b"


class Html(str):
    """Text that is markup; only `html` and `joined` make it, or a constant of ours."""

    __slots__ = ()


class _Escaping(Formatter):
    """`str.format` that escapes what is no markup."""

    def format_field(self, value: Any, format_spec: str) -> str:
        return value if isinstance(value, Html) else _safe(format(value, format_spec))

    def check_unused_args(self, used_args: Any, args: Any, kwargs: Any) -> None:
        unused = [k for k in range(len(args)) if k not in used_args] + [k for k in kwargs if k not in used_args]
        assert not unused, f"markup does not use {unused}"


_ESCAPING = _Escaping()


def html(markup: str, *values: object, **named: object) -> Html:
    """Markup with values in its `{}` places, each escaped unless it is `Html`; quotes too, so also in attributes."""
    return Html(_ESCAPING.vformat(markup, values, named))


def joined(parts: Iterable[Html], between: str = "") -> Html:
    """Pieces of markup in a row, with markup between them."""
    return Html(between.join(parts))


def colour(text: str) -> str:
    """A colour that stands in a style: itself, or grey where it is none."""
    return text if COLOUR.fullmatch(text) else NEUTRAL


def script_json(value: object) -> Html:
    """JSON that nothing within it can end, or turn into markup or script."""
    text = json.dumps(value, separators=(",", ":"))  # in ASCII: line separators are \\u2028 and \\u2029
    text = STEERS.sub(lambda found: f"\\\\u{found[1]}" if found[1] else found[0], text)
    return Html(text.replace("&", "\\u0026").replace("<", "\\u003c").replace(">", "\\u003e"))


def policy(scripts: Sequence[str]) -> Html:
    """The content security policy of a page that runs only these scripts, and loads nothing from anywhere."""
    hashes = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{value}'" for value in hashes)
    return Html(
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: blob:; "
        "base-uri 'none'; form-action 'none'; require-trusted-types-for 'script'"
    )


def _safe(text: str) -> str:
    return escape(NO_CHARACTERS.sub("\ufffd", printable(text)))

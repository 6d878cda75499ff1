"""The built pages ask no other machine for anything: what they load lies beside them, or the build fails."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from sphinx.errors import ExtensionError

FOREIGN = r"(?:https?:)?//[^\s\"')>]+"
LOADS = [
    re.compile(
        rf"<(?:script|img|iframe|source|video|audio|embed)\b[^>]*?\s(?:src|srcset)\s*=\s*[\"']?({FOREIGN})", re.I
    ),
    re.compile(
        rf"<link\b(?=[^>]*\brel=[\"']?(?:stylesheet|preload|icon|preconnect|dns-prefetch))[^>]*?\shref=[\"']?({FOREIGN})",
        re.I,
    ),
    re.compile(rf"(?:url\(|@import\s+)[\"']?({FOREIGN})", re.I),
    re.compile(rf"(?:fetch|importScripts|import)\(\s*[\"'`]({FOREIGN})", re.I),
]


def loads(text: str) -> list[str]:
    """Return the addresses of other machines from which a page, style sheet or script would load something."""
    return [address for pattern in LOADS for address in pattern.findall(text)]


def check(folder: Path) -> list[str]:
    """Return a line for each file below a folder that would load something from elsewhere."""
    files = [path for path in sorted(folder.rglob("*")) if path.suffix in (".html", ".css", ".js")]
    found = {path: loads(path.read_text("utf-8", errors="replace")) for path in files}
    return [
        f"{path.relative_to(folder)} loads {', '.join(addresses)}" for path, addresses in found.items() if addresses
    ]


def _finished(app: Sphinx, problem: Exception | None) -> None:
    if problem is None and app.builder.format == "html" and (wrong := check(Path(app.outdir))):
        raise ExtensionError("the pages need a network:\n" + "\n".join(wrong))


def setup(app: Sphinx) -> dict[str, Any]:
    """Look at the end of each build."""
    app.connect("build-finished", _finished)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

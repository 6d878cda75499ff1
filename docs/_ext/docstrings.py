"""NumPy-style docstrings as Markdown."""

from __future__ import annotations

import re
import textwrap

LISTED = ("Parameters", "Attributes", "Raises", "Warns")
SECTIONS = (*LISTED, "Returns", "Notes", "Yields", "Examples", "References", "See Also")
SECTION = re.compile(r"^(\S.*)\n-{3,}$", re.M)
RULE = re.compile(r"^=+( +=+)+$")


def escaped(text: str) -> str:
    """Return prose in which only backticks mean something to Markdown."""
    pieces = re.split(r"(``.+?``|`[^`\n]+`)", text, flags=re.DOTALL)
    return "".join(piece if i % 2 else re.sub(r"([\\*_$<>\[\]|^#])", r"\\\1", piece) for i, piece in enumerate(pieces))


def table(rows: list[list[str]], heads: list[str]) -> str:
    """Return a Markdown table of cells that are Markdown already, without columns that are empty throughout."""
    kept = [i for i, head in enumerate(heads) if not rows or any(row[i] for row in rows) or i == 0]
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join("| " + " | ".join(line[i].replace("\n", " ") for i in kept) + " |" for line in lines) + "\n"


def markdown(doc: str) -> str:
    """Return a docstring as Markdown, its sections as bold words and lists.

    Raises
    ------
    ValueError
        A heading that is none of `SECTIONS`.
    """
    pieces = SECTION.split(doc)
    out = [prose(pieces[0])]
    for name, body in zip(pieces[1::2], pieces[2::2], strict=True):
        if name not in SECTIONS:
            raise ValueError(f"a docstring has a section {name!r}; there are {', '.join(SECTIONS)}")
        out.append(f"**{name}**\n")
        hangs = name == "Returns" and re.search(r"^\S.*\n +\S", textwrap.dedent(body).strip("\n"))
        out.append(listed(body) if name in LISTED or hangs else prose(textwrap.dedent(body)))
    return "\n".join(out).strip() + "\n"


def listed(body: str) -> str:
    """Return the entries of a section as a list: a line at the margin begins one, what is indented says more."""
    entries: list[list[str]] = []
    for line in textwrap.dedent(body).strip("\n").splitlines():
        if line[:1].strip() or not entries:
            entries.append([line.strip()])
        elif line.strip():
            entries[-1].append(line.strip())
    lines = []
    for head, *more in entries:
        name, _, kind = head.partition(" : ")
        said = " ".join(filter(None, [kind, *more]))
        plain = re.fullmatch(r"[\w, *.]+", name) is not None
        lines.append(
            f"- `{name}`{':' if said else ''} {escaped(said)}"
            if plain
            else f"- {escaped(head)} {escaped(' '.join(more))}"
        )
    return "\n".join(lines) + "\n"


def prose(text: str) -> str:
    """Return paragraphs; tables of `===` become tables, doctests and indented paragraphs stand as they are."""
    out, lines = [], text.strip("\n").splitlines()
    while lines:
        line = lines.pop(0)
        if RULE.match(line.strip()):
            out.append(_table(line, lines))
        elif line.lstrip().startswith(">>>") or (lines and lines[0].startswith("├")):
            block = [line]
            while lines and lines[0].strip():
                block.append(lines.pop(0))
            out.append("\n```pycon\n" + textwrap.dedent("\n".join(block)) + "\n```\n")
        elif line.startswith("    ") and out and not out[-1].strip():
            block = [line]
            while lines and (lines[0].startswith("    ") or not lines[0].strip()):
                block.append(lines.pop(0))
            out.append("```text\n" + textwrap.dedent("\n".join(block)).rstrip() + "\n```\n")
        elif line[:1].strip() and lines and lines[0].startswith("    ") and not line.endswith((",", ":", ";")):
            out.append(f"\n**{escaped(line)}**")
            while lines and lines[0].startswith("    "):
                out.append(escaped(lines.pop(0).strip()))
            out.append("")
        else:
            bullet = re.match(r"\s*- ", line)
            out.append(bullet[0] + escaped(line[len(bullet[0]) :]) if bullet else escaped(line))
    return "\n".join(out) + "\n"


def _table(rule: str, lines: list[str]) -> str:
    """Take a table off the lines."""
    starts = [match.start() for match in re.finditer(r"=+", rule)]
    rows: list[list[str]] = []
    while lines and not RULE.match(lines[0].strip()):
        line = lines.pop(0)
        cells = [line[a:b].strip() for a, b in zip(starts, [*starts[1:], None], strict=True)]
        if cells[0] or not rows:
            rows.append(cells)
        else:
            rows[-1] = [f"{old} {new}".strip() for old, new in zip(rows[-1], cells, strict=True)]
    if lines:
        lines.pop(0)
    return "\n" + table([[escaped(cell) for cell in row] for row in rows], ["name", *["what"] * (len(starts) - 1)])

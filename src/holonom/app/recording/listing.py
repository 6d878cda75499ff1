"""The table of signals as a page of the documentation shows it."""

from __future__ import annotations

from holonom.signals import TOPICS

__all__ = ["topics_table"]


def topics_table() -> str:
    """Return all topics as a Markdown table."""
    lines = ["| topic | type | kind | units | frame | content |", "|---|---|---|---|---|---|"]
    for topic in TOPICS:
        name = topic.name.replace("{", "<").replace("}", ">")
        kind = topic.type.replace("/", "/msg/")
        lines.append(f"| `{name}` | `{kind}` | {topic.kind} | {topic.units} | {topic.frame} | {topic.meaning} |")
    return "\n".join(lines)

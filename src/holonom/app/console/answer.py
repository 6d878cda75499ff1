"""What a command has to say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["Answer"]


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of a command: `text` for a person, `data` (JSON values only, no NaN) for `--json`."""

    text: str
    data: Mapping[str, Any]

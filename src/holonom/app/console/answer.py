"""What a command has to say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["Answer"]


@dataclass(frozen=True, slots=True)
class Answer:
    """The result of a command: `text` for a person, `data` (JSON values only, no NaN) for `--json`.

    `status` is 2 where the answer is that the input contradicts itself.
    """

    text: str
    data: Mapping[str, Any]
    status: int = 0

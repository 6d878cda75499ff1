"""Faults found while a table is read, each at its key, so that a cell's faults name file, line and key."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pydantic import ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from holonom.app.toml_lines import KeyPath
from holonom.errors import InputError

__all__ = ["Faults", "refuse"]


def refuse(at: KeyPath, problem: object, came: object = None) -> ValidationError:
    """Return the error for a key, which `at` leads to from the table that is read."""
    return ValidationError.from_exception_data("cell", [_detail(at, str(problem), came)])


class Faults:
    """Collects what several readers of one table find wrong."""

    def __init__(self) -> None:
        self._found: list[InitErrorDetails] = []

    def call(self, read: Callable[[], Any], at: KeyPath = ()) -> Any:
        """Return what a reader gives; None where it found faults, which are kept."""
        try:
            return read()
        except ValidationError as error:
            for fault in error.errors(include_url=False):
                known = InitErrorDetails(type=fault["type"], loc=(*at, *fault["loc"]), input=fault["input"])
                known["ctx"] = fault.get("ctx", {})
                self._found.append(known)
        except InputError as problem:
            self._found.append(_detail(at, str(problem), None))
        return None

    def raise_any(self) -> None:
        """Raise `ValidationError` with all that was found, if anything was."""
        if self._found:
            raise ValidationError.from_exception_data("cell", self._found)


def _detail(at: KeyPath, text: str, came: object) -> InitErrorDetails:
    told: Mapping[str, Any] = {"error": text}
    return InitErrorDetails(type=PydanticCustomError("value_error", "{error}", dict(told)), loc=at, input=came)

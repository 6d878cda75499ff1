"""Faults found while a table is read, each at its key, so that a cell's faults name file, line and key."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from holonom.app.fields.toml_faults import MOST, explained
from holonom.app.fields.toml_lines import KeyPath
from holonom.errors import InputError

__all__ = ["Faults", "read_form", "refuse"]

Form = TypeVar("Form", bound=BaseModel)


def refuse(at: KeyPath, problem: object, came: object = None) -> ValidationError:
    """Return the error for a key, which `at` leads to from the table that is read."""
    return ValidationError.from_exception_data("cell", [_detail(at, str(problem), came)])


def read_form(form: type[Form], given: object, context: Any = None) -> Form:
    """Return a table read as one of several forms that its key may have.

    Raises
    ------
    ValidationError
        Its faults in the words of that form.
    """
    try:
        return form.model_validate(given, context=context)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        details = [_detail(fault["loc"], explained(form, fault), fault["input"]) for fault in faults[:MOST]]
        if len(faults) > MOST:
            details.append(_detail((), f"and {len(faults) - MOST} more faults in this table", None))
        raise ValidationError.from_exception_data("cell", details) from None


class Faults:
    """Collects what several readers of one table find wrong."""

    def __init__(self) -> None:
        self._found: list[InitErrorDetails] = []

    def call(self, at: KeyPath, read: Callable[..., Any], *given: Any) -> Any:
        """Return what a reader of the key at `at` gives; None where it found faults, which are kept."""
        try:
            return read(*given)
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

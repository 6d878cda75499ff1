"""A file for `holonom tune`: its tables, and by the first of them who answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType

from holonom.app.console.answer import Answer
from holonom.app.drives.tuning.axis import tune_axis_file
from holonom.app.drives.tuning.process import tune_process_file
from holonom.app.drives.tuning.tables import TuningFile
from holonom.app.fields.toml_faults import parse_toml
from holonom.errors import ModelError
from holonom.files import read_text

__all__ = ["SUBJECTS", "tune_file"]

SUBJECTS: Mapping[str, Callable[[TuningFile, str | None, Path | None], Answer]] = MappingProxyType(
    {"process": tune_process_file, "motor": tune_axis_file}
)
"""Table of a file to what answers it: (file, rule, output folder)."""


def tune_file(path: Path, *, rule: str | None = None, output: Path | None = None) -> Answer:
    """Tune what a file describes.

    Parameters
    ----------
    path : TOML with a table [process], or with [motor] and the tables of an axis.
    rule : a name, "all", or None for the one that fits.
    output : folder for what is found.

    Raises
    ------
    InputError
        No such file, no TOML, a table or key that is unknown, missing or wrong; with file, line and key.
    """
    text = read_text(path, "sheet", ModelError)
    file = TuningFile(path, text, parse_toml(path, text, ModelError, "lag = 14.0"))
    for subject, answer in SUBJECTS.items():
        if subject in file.data:
            return answer(file, rule, output)
    came = ", ".join(f"[{name}]" for name in file.data) or "nothing"
    raise ModelError(f"{path}:1: {came} came; a table {' or '.join(f'[{name}]' for name in SUBJECTS)} is needed")

"""`holonom doctor`: what is installed, what is missing, what it would take; and two looks inside."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import os
import platform
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from holonom import __version__
from holonom.app.console.answer import Answer

if TYPE_CHECKING:
    from holonom.trace import CacheUse

__all__ = ["empty_cache", "examine", "schema", "show_kernel"]

NEEDED = ("numpy", "numba", "llvmlite", "scipy", "lark", "pydantic", "mcap", "zstandard", "lz4", "rich")


@dataclass(frozen=True, slots=True)
class Extra:
    """What an extra is for, and the modules that it brings with the distributions that they come from."""

    purpose: str
    modules: Mapping[str, str]


EXTRAS: Mapping[str, Extra] = {
    "vision": Extra("cells with a camera", {"cv2": "opencv-python-headless"}),
    "xacro": Extra("robots in xacro files", {"xacro": "xacro"}),
    "motion": Extra("plan_transfer, motions with a limited jerk", {"ruckig": "ruckig"}),
    "plots": Extra("figures and pages to turn", {"matplotlib": "matplotlib", "plotly": "plotly"}),
    "symbolic": Extra("formulas to read", {"sympy": "sympy"}),
    "mpc": Extra("the path law mpc", {"osqp": "osqp"}),
    "docs": Extra(
        "these pages as HTML",
        {
            "sphinx": "sphinx",
            "myst_parser": "myst-parser",
            "furo": "furo",
            "latex2mathml": "latex2mathml",
            "matplotlib": "matplotlib",
        },
    ),
    "oracle": Extra(
        "comparisons with peer libraries",
        {
            "pinocchio": "pin",
            "eaik": "eaik",
            "roboticstoolbox": "roboticstoolbox-python",
            "toppra": "toppra",
            "mujoco": "mujoco",
            "gym_electric_motor": "gym-electric-motor",
        },
    ),
    "check": Extra(
        "lint, types and layers",
        {
            "ruff": "ruff",
            "mypy": "mypy",
            "importlinter": "import-linter",
            "matplotlib": "matplotlib",
            "xacro": "xacro",
        },
    ),
    "test": Extra(
        "the tests",
        {
            "pytest": "pytest",
            "xdist": "pytest-xdist",
            "hypothesis": "hypothesis",
            "mcap_ros2": "mcap-ros2-support",
            "selenium": "selenium",
            "hatchling": "hatchling",
        },
    ),
}
"""The extras of the package, all but `all`, which is all of them."""

BROWSERS = ("chromium", "chromium-browser", "google-chrome")


def examine() -> Answer:
    """Say which versions are there, which extras are complete, and where things lie; nothing heavy is imported."""
    from holonom.trace import cache_use

    data = {
        "holonom": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "cache": _of_cache(cache_use()),
        "packages": {name: _version(name) for name in NEEDED},
        "extras": {name: _missing(extra.modules) for name, extra in EXTRAS.items()},
        "browser": next(filter(None, map(shutil.which, BROWSERS)), None),
        "browser_driver": shutil.which("chromedriver"),
    }
    return Answer(_as_text(data), data)


def empty_cache() -> Answer:
    """Remove every compiled kernel; each is compiled again when it is needed.

    Raises
    ------
    OutputError
        The cache folder cannot be written.
    """
    from holonom.trace import empty_cache as empty

    had = _of_cache(empty())
    return Answer(f"removed from the kernel cache {_use_as_text(had)}", {"removed": had})


def schema() -> Answer:
    """Print the JSON Schema of cell files: `holonom doctor --schema > docs/cell.schema.json`."""
    from holonom.app.cell import cell_schema

    text = json.dumps(cell_schema(), indent=2)
    return Answer(text, json.loads(text))


def show_kernel(name: str) -> Answer:
    """Print the generated code of an arm's kernel.

    Parameters
    ----------
    name : preset and kernel, such as "puma560.inverse_dynamics"; without a preset the Puma's.

    Raises
    ------
    UnknownName
        No such preset or kernel.
    """
    from holonom.mechanics import load_arm

    preset, _, kernel = name.rpartition(".")
    found = load_arm(preset or "puma560").kernel(kernel)
    return Answer(found.source, {"kernel": name, "source": found.source, "block_source": found.block_source})


def _version(distribution: str) -> str | None:
    try:
        return importlib.metadata.version(distribution)
    except importlib.metadata.PackageNotFoundError:
        return None


def _missing(modules: Mapping[str, str]) -> list[str]:
    """Return the distributions whose module is not there."""
    return [name for module, name in modules.items() if importlib.util.find_spec(module) is None]


def _of_cache(use: CacheUse) -> dict[str, Any]:
    return use._asdict() | {"folder": str(use.folder)}


def _use_as_text(cache: Mapping[str, Any]) -> str:
    size, limit = (cache[key] / 2**20 for key in ("size", "limit"))
    return f"{cache['folder']} ({cache['kernels']} kernels, {size:.1f} of at most {limit:.0f} MiB)"


def _as_text(data: Mapping[str, Any]) -> str:
    rows = [("holonom", data["holonom"]), ("python", data["python"]), ("platform", data["platform"])]
    rows += [("cores", data["cores"]), ("kernel cache", _use_as_text(data["cache"]))]
    rows += [(name, version or "missing: in the clone, pip install -e .") for name, version in data["packages"].items()]
    for name, missing in data["extras"].items():
        lacks = f"lacks {', '.join(missing)}: in the clone, pip install -e '.[{name}]'"
        rows.append((f"[{name}]", f"{lacks if missing else 'installed'}; for {EXTRAS[name].purpose}"))
    rows.append(("browser", data["browser"] or "none: the browser tests skip"))
    rows.append(("browser driver", data["browser_driver"] or "none: the browser tests skip"))
    return "\n".join(f"{name:<16}{value}" for name, value in rows)

"""The drawing of the layers in docs/index.md, from the contract in pyproject.toml: the directive `{layers}`."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.parsers.rst import Directive
from sphinx.application import Sphinx

ROOT = Path(__file__).resolve().parents[2]
MEANS = {
    "__main__": "the command `holonom`",
    "app": "commands, cells, runs, recordings, reports",
    "closed_loop": "controller and plant together",
    "machine": "the controller",
    "sim": "plants, floors, work pieces",
    "drivers": "other ends: buses, ROS 2",
    "lang": "robot programs",
    "plots": "figures",
    "planning": "paths among obstacles",
    "localise": "where a robot is",
    "control": "laws",
    "mobile": "wheels and bases",
    "vision": "a camera over a table",
    "mechanics": "arms",
    "devices": "motors, gears, encoders",
    "model": "what a robot is",
    "geometry": "shapes and distances",
    "numeric": "small linear algebra",
    "spatial": "rotations and poses",
    "trace": "the kernel compiler",
    "registry": "tables of methods",
    "signals": "what crosses a border",
    "errors": "what goes wrong",
    "arrays": "arrays that came from outside",
    "files": "files that are read, within bounds",
}


def rows() -> list[list[str]]:
    """Return the layers from the top down, the names of each; those in brackets are not there yet."""
    contract = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"][0]
    return [[name.strip() for name in row.split("|")] for row in contract["layers"]]


class Layers(Directive):
    """One line for each layer."""

    def run(self) -> list[nodes.Node]:
        """Return the drawing as a literal block."""
        table = [("   ".join(row), "; ".join(MEANS.get(name.strip("() "), "") for name in row)) for row in rows()]
        width = max(len(left) for left, _ in table)
        text = "\n".join(f"{left:{width}}   {said.replace('`', '')}".rstrip() for left, said in table)
        return [nodes.literal_block(text, text, language="text")]


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the directive."""
    app.add_directive("layers", Layers)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

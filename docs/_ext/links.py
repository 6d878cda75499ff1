"""Code in running text is a link where it names something of the reference: `plan_line`, `arm.fk`, `holonom check`."""

from __future__ import annotations

import importlib
import inspect
import re
from functools import cache
from types import ModuleType
from typing import Any

from docutils import nodes
from reference_python import home, public
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util.nodes import make_refnode

from holonom.app.commands import COMMANDS

SHORT = {"hm": "holonom", "arm": "holonom.mechanics.Arm", "base": "holonom.mobile.WheelBase"}
SHORT |= {"loop": "holonom.closed_loop.BaseLoop", "controller": "holonom.machine.BaseController"}
CODE = re.compile(r"([A-Za-z_][\w.]*)(\(.*\))?", re.DOTALL)


@cache
def names() -> dict[str, str]:
    """Return every public name, module and member, with what kind it is in the Python domain: "mod" or "obj"."""
    found = dict.fromkeys(public(), "mod")
    for module, listed in public().items():
        for name in listed:
            value = getattr(importlib.import_module(module), name)
            if isinstance(value, ModuleType) or home(value, name) != module:
                continue
            found[f"{module}.{name}"] = "obj"
            members = vars(value) if inspect.isclass(value) else ()
            found |= {f"{module}.{name}.{m}": "obj" for m in members if not m.startswith("_")}
    return found


@cache
def aliases() -> dict[str, str]:
    """Return the full names of what other modules list too: `holonom.load_arm`."""
    found = {}
    for module, listed in public().items():
        for name in listed:
            value = getattr(importlib.import_module(module), name)
            place = value.__name__ if isinstance(value, ModuleType) else f"{home(value, name)}.{name}"
            if place != f"{module}.{name}":
                found[f"{module}.{name}"] = place
    return found


@cache
def by_ending() -> dict[str, list[str]]:
    """Return full names by their last one, two, three ... words."""
    found: dict[str, list[str]] = {}
    for full in names():
        words = full.split(".")
        for start in range(1, len(words)):
            found.setdefault(".".join(words[start:]), []).append(full)
    return found


def resolve(code: str) -> str | None:
    """Return the full name that code names, `holonom COMMAND` for a command, None for anything else."""
    if code.startswith("holonom "):
        words = code.split()
        candidates = (" ".join(words[1:3]), words[1])
        return next((f"holonom {name}" for name in candidates if name in COMMANDS.own), None)
    match = CODE.fullmatch(code.strip())
    if match is None:
        return None
    path = match[1]
    first, _, rest = path.partition(".")
    if rest and first in SHORT:
        path = f"{SHORT[first]}.{rest}"
    if path in names() or (path := aliases().get(path, path)) in names():
        return path
    telling = (
        rest
        or "_" in path
        or match[2]
        or re.search("[a-z][A-Z]|^[A-Z]{4}", path)
        or (path[:1].isupper() and len(path) > 3)
    )
    fitting = by_ending().get(path, []) if telling else []
    functions = [full for full in fitting if names().get(full.rpartition(".")[0]) == "mod"]
    found = functions if len(functions) == 1 else fitting
    return found[0] if len(found) == 1 else None


class Links(SphinxPostTransform):
    """Wraps literals in links, but those that are links or heads already."""

    default_priority = 5

    def run(self, **_: Any) -> None:
        """Go through the literals of a page."""
        for literal in list(self.document.findall(nodes.literal)):
            inside, parent = [], literal.parent
            while parent is not None:
                inside.append(parent)
                parent = parent.parent
            if any(
                isinstance(node, (nodes.reference, nodes.title, pending_xref, nodes.literal_block)) for node in inside
            ):
                continue
            if link := self._link(resolve(literal.astext()), literal):
                literal.replace_self(link)

    def _link(self, found: str | None, literal: nodes.literal) -> nodes.reference | None:
        builder, page = self.app.builder, self.env.docname
        if found is None:
            return None
        if found.startswith("holonom "):
            if page == "reference/commands":
                return None
            return make_refnode(builder, page, "reference/commands", nodes.make_id(found), literal.deepcopy(), found)
        entry = self.env.domains.python_domain.objects.get(found)
        if entry is None or (entry.docname == page and page.startswith("reference")):
            return None
        return make_refnode(builder, page, entry.docname, entry.node_id, literal.deepcopy(), found)


def setup(app: Sphinx) -> dict[str, Any]:
    """Add the transform."""
    app.add_post_transform(Links)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

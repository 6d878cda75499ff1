"""Formulas as MathML, made at build: no script, no network, and what cannot be rendered fails the build.

latex2mathml takes what it does not know for letters, so its result is looked at: no backslash, brace or `&` may be
left, and every fraction, root and script has its parts. Then what browsers do not do with old attributes is said in
MathML Core: spaces beside words such as `sin`, brackets that stretch over their own matrix only.
"""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

NAMESPACE = "http://www.w3.org/1998/Math/MathML"
PARTS = {"mfrac": 2, "mroot": 2, "msub": 2, "msup": 2, "mover": 2, "munder": 2, "msubsup": 3, "munderover": 3}
LEFT_OVER = re.compile(r"[\\{}&]")
WORD = re.compile("[A-Za-z]{2,}")
OPENS = ("(", "[", ",", ".", ")")
EMPTY = [(r"(\\\\\s*|&\s*|\}\s*)(?=&)", r"\1{} "), (r"(&\s*)(?=\\\\|\\end)", r"\1{} ")]
BRACES = (r"\{", r"\}", r"\lbrace", r"\rbrace", "{cases}")
log = logging.getLogger(__name__)


class FormulaError(Exception):
    """A formula that cannot be rendered."""


def mathml(latex: str, *, block: bool = False) -> str:
    """Return a formula as MathML.

    Raises
    ------
    FormulaError
        It cannot be rendered; says why.
    """
    text = latex.strip().replace("{aligned}", "{split}")
    text = re.sub(r"\\operatorname\{([A-Za-z]+\d+)\}", r"\\text{\1}", text)  # "atan2", which it spells as a product
    for empty, filled in EMPTY:  # it drops a row that begins with an empty cell
        text = re.sub(empty, filled, text)
    if text.count("{") - text.count(r"\{") != text.count("}") - text.count(r"\}"):
        raise FormulaError("braces do not match")
    try:
        root = ElementTree.fromstring(convert(text, display="block" if block else "inline"))
    except Exception as problem:  # it has an exception for each fault, and some faults that have none
        raise FormulaError(f"{type(problem).__name__} {problem}".strip()) from problem
    for element in root.iter():
        element.tag = element.tag.removeprefix(f"{{{NAMESPACE}}}")
    _wrap_matrices(root)
    for element in root.iter():
        _check(element, text)
    _check_cells(root, text)
    _tidy(root, block=block)
    root.set("xmlns", NAMESPACE)
    return ElementTree.tostring(root, encoding="unicode")


def _check(element: ElementTree.Element, latex: str) -> None:
    found = LEFT_OVER.search(element.text or "")
    if found and not (found[0] in "{}" and any(brace in latex for brace in BRACES)):
        raise FormulaError(f"{element.text!r} is not known")
    expected = PARTS.get(element.tag, len(element))
    if len(element) != expected:
        raise FormulaError(f"{element.tag} has {len(element)} parts instead of {expected}")


def _check_cells(root: ElementTree.Element, latex: str) -> None:
    """Refuse a table that lost rows or cells on the way."""
    rows = latex.count(r"\begin{") + len(re.findall(r"\\\\(?!\s*\\end)", latex))
    cells = rows + len(re.findall(r"(?<!\\)&", latex))
    found = [sum(1 for _ in root.iter(tag)) for tag in ("mtr", "mtd")]
    if latex.count(r"\begin{") and found != [rows, cells]:
        raise FormulaError(f"{rows} rows and {cells} cells became {found[0]} and {found[1]}")


def _tidy(element: ElementTree.Element, *, block: bool) -> None:
    children = list(element)
    for place, child in enumerate(children):
        _tidy(child, block=block)
        if child.tag == "mo" and child.text == "/":
            child.attrib |= {"lspace": "0", "rspace": "0"}
        elif child.tag == "mo" and child.text == "\u2202":
            child.tag = "mi"
        head = child[0] if child.tag in ("msub", "msup", "msubsup") else child
        if head.tag in ("mi", "mo") and WORD.fullmatch(head.text or ""):
            follower = (children[place + 1].text or "") if place + 1 < len(children) else "("
            head.tag = "mo"
            head.attrib |= {"lspace": "0.1667em" if place else "0", "rspace": "0" if follower in OPENS else "0.1667em"}
        if block and child.tag == "msub" and head.text in ("max", "min"):
            child.tag = "munder"


def _wrap_matrices(element: ElementTree.Element) -> None:
    """Put a table and its brackets into a row of their own, so that a script behind them is the row's."""
    children = list(element)
    for child in children:
        _wrap_matrices(child)
    for place, child in enumerate(children):
        if child.tag != "mtable" or not 0 < place < len(children) - 1:
            continue
        before, after = children[place - 1], children[place + 1]
        if before.text not in ("[", "(") or after.text not in ("]", ")"):
            continue
        row = ElementTree.Element("mrow")
        before.attrib |= {"stretchy": "true", "form": "prefix"}
        after.attrib |= {"stretchy": "true", "form": "postfix"}
        index = list(element).index(before)
        for part in (before, child, after):
            element.remove(part)
            row.append(part)
        element.insert(index, row)


def _visit(self: Any, node: nodes.math) -> None:
    self.body.append(_rendered(node, block=False))
    raise nodes.SkipNode


def _visit_block(self: Any, node: nodes.math_block) -> None:
    self.body.append(f'<div class="math">{_rendered(node, block=True)}</div>\n')
    raise nodes.SkipNode


def _rendered(node: nodes.Element, *, block: bool) -> str:
    try:
        return mathml(node.astext(), block=block)
    except FormulaError as problem:
        log.warning("this formula cannot be rendered: %s: %s", problem, node.astext(), location=node)
        return f"<code>{nodes.make_id(node.astext())}</code>"


def setup(app: Sphinx) -> dict[str, Any]:
    """Make it Sphinx's renderer of formulas, `html_math_renderer = "mathml"`."""
    app.add_html_math_renderer("mathml", (_visit, None), (_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

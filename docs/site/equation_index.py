"""Entries of the search for equations: 4.12, (4.12) and "equation 4.12" lead to the sections that have it."""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes

NUMBER = re.compile(r"\(([1-9]\.\d{1,2}[a-z]?)\)")


def index_equations(_app: Any, document: nodes.document) -> None:
    """Add to each section the numbers of the equations of the thesis in it, as index entries, which the search has."""
    for section in document.findall(nodes.section):
        own = [child for child in section.children if not isinstance(child, nodes.section)]
        numbers = dict.fromkeys(number for child in own for number in NUMBER.findall(text_of(child)))
        if numbers and section["ids"]:
            entries = [("single", text, section["ids"][0], "", None)
                       for number in numbers for text in (f"({number})", f"equation {number}")]
            section.insert(1, addnodes.index(entries=entries))


def text_of(node: nodes.Node) -> str:
    """Text of a part of a page with the TeX of its equations, whose numbers stand in it behind \\qquad."""
    return "\n".join(text.astext() for text in node.findall(nodes.Text)) if node.children else node.astext()


def setup(app: Any) -> dict[str, bool]:
    """Ask Sphinx to be called for each page that is read."""
    app.connect("doctree-read", index_equations)
    return {"parallel_read_safe": True}

"""Equations of the site as MathML: nothing is loaded from a network, and nothing is drawn by a script."""

from typing import Any

from docutils import nodes

from fmi_export.pages.mathml import mathml


def inline(writer: Any, node: nodes.math) -> None:
    """Write an equation within a line."""
    writer.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def display(writer: Any, node: nodes.math_block) -> None:
    """Write an equation on lines of its own."""
    number = node.get("number")
    label = f'<span class="eqno">({number})</span>' if number else ""
    writer.body.append(f'<div class="math">{mathml(node.astext(), display=True)}{label}</div>')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, bool]:
    """Name the renderer to Sphinx."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}

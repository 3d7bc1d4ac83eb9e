"""What Sphinx does not do by itself: equations as MathML and found by their numbers, pages for keys, our colours."""

import re
import struct
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes

from maglev.fmi.documentation import mathml

COLOURS = Path(__file__).parents[2] / "maglev" / "pages" / "shell" / "tokens.css"
NUMBER = re.compile(r"\(([1-9]\.\d{1,2}[a-z]?)\)")
CAPTION = '<p class="caption" role="heading">'
MADE = {CAPTION: f'{CAPTION[:-1]} aria-level="2">',
        "<pre>": '<pre tabindex="0">',                       # lines and equations may be longer than a screen is wide
        '<div class="math">': '<div class="math" tabindex="0">',
        '<th class="head"><p></p></th>': "<td></td>"}
PICTURE = re.compile(r'<img ([^>]*?src="[^"]*_images/([^"]+)")')
SIZE = re.compile(rb'<svg[^>]* width="(\d+)" height="(\d+)"')


def setup(app: Any) -> dict[str, bool]:
    """Extension of Sphinx; pages are changed after the theme has made its navigation."""
    app.add_html_math_renderer("mathml", (inline, None), (display, None))
    app.connect("doctree-read", index_equations)
    app.connect("html-page-context", make_readable, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write_tokens(folder: Path) -> None:
    """Write the colours of the report and of the live page under the site's switch of light and dark."""
    blocks = re.findall(r":root \{\n(.*?)\n *\}", COLOURS.read_text(encoding="utf-8"), re.DOTALL)
    light, dark = (re.sub(r"\s*color-scheme:[^;]*;", "", block).strip() for block in blocks[:2])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tokens.css").write_text(
        f"body {{ {light} }}\nbody[data-theme=dark] {{ {dark} }}\n@media (prefers-color-scheme: dark) {{\n"
        f"body:not([data-theme=light]) {{ {dark} }}\n}}\n", encoding="utf-8")


def inline(writer: Any, node: nodes.math) -> None:
    """Write an equation within a line, which nothing from a network and no script draws."""
    writer.body.append(mathml(node.astext()))
    raise nodes.SkipNode


def display(writer: Any, node: nodes.math_block) -> None:
    """Write an equation on lines of its own."""
    number = node.get("number")
    label = f'<span class="eqno">({number})</span>' if number else ""
    writer.body.append(f'<div class="math">{mathml(node.astext(), display=True)}{label}</div>')
    raise nodes.SkipNode


def index_equations(_app: Any, document: nodes.document) -> None:
    """Add to each section the numbers of the thesis's equations in it: the search has "(4.12)" and "equation 4.12"."""
    for section in document.findall(nodes.section):
        own = [child for child in section.children if not isinstance(child, nodes.section)]
        numbers = dict.fromkeys(number for child in own for number in NUMBER.findall(node_text(child)))
        if numbers and section["ids"]:
            entries = [("single", text, section["ids"][0], "", None)
                       for number in numbers for text in (f"({number})", f"equation {number}")]
            section.insert(1, addnodes.index(entries=entries))


def node_text(node: nodes.Node) -> str:
    """Text of a part of a page with the TeX of its equations, whose numbers stand in it behind \\qquad."""
    return "\n".join(text.astext() for text in node.findall(nodes.Text)) if node.children else node.astext()


def make_readable(app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Put into a page levels of captions, keys to scroll and the sizes of pictures; take out empty headers."""
    for part in ("body", "furo_navigation_tree"):
        for without, made in MADE.items():
            if context.get(part):
                context[part] = context[part].replace(without, made)
    if context.get("body"):
        sources = {name: Path(app.srcdir) / path for path, name in app.builder.images.items()}
        context["body"] = PICTURE.sub(lambda match: f"<img {size_of(sources[match[2]])}{match[1]}", context["body"])


def size_of(picture: Path) -> str:
    """Width and height of a PNG or SVG as attributes: what is below keeps its place when the picture comes."""
    content = picture.read_bytes()
    known = SIZE.search(content)
    if picture.suffix == ".png":
        width, height = struct.unpack(">II", content[16:24])
    elif known is not None:
        width, height = map(int, known.groups())
    else:
        return ""
    return f'width="{width}" height="{height}" '

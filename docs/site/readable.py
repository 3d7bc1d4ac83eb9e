"""What Sphinx leaves out: levels of captions, keys to scroll, no empty headers, and the sizes of pictures."""

import re
import struct
from pathlib import Path
from typing import Any

CAPTION = '<p class="caption" role="heading">'
MADE = {CAPTION: f'{CAPTION[:-1]} aria-level="2">',
        "<pre>": '<pre tabindex="0">',                       # lines and equations may be longer than a screen is wide
        '<div class="math">': '<div class="math" tabindex="0">',
        '<th class="head"><p></p></th>': "<td></td>"}


PICTURE = re.compile(r'<img ([^>]*?src="[^"]*_images/([^"]+)")')
SIZE = re.compile(rb'<svg[^>]* width="(\d+)" height="(\d+)"')


def setup(app: Any) -> dict[str, Any]:
    """Extension of Sphinx; after the theme has made its navigation."""
    app.connect("html-page-context", make_readable, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def make_readable(app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Put into a page what it lacks."""
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

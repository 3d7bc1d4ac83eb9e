"""What Sphinx leaves out for readers without eyes or mouse: levels of captions, keys to scroll, no empty headers."""

from typing import Any

CAPTION = '<p class="caption" role="heading">'
MADE = {CAPTION: f'{CAPTION[:-1]} aria-level="2">',
        "<pre>": '<pre tabindex="0">',                       # lines and equations may be longer than a screen is wide
        '<div class="math">': '<div class="math" tabindex="0">',
        '<th class="head"><p></p></th>': "<td></td>"}


def setup(app: Any) -> dict[str, Any]:
    """Extension of Sphinx; after the theme has made its navigation."""
    app.connect("html-page-context", make_readable, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def make_readable(_app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Put into a page what it lacks."""
    for part in ("body", "furo_navigation_tree"):
        for without, made in MADE.items():
            if context.get(part):
                context[part] = context[part].replace(without, made)

"""Captions of the navigation as headings with a level: Sphinx gives them the role alone, which says too little."""

from typing import Any

CAPTION = '<p class="caption" role="heading">'


def setup(app: Any) -> dict[str, Any]:
    """Extension of Sphinx; after the theme has made its navigation."""
    app.connect("html-page-context", give_levels, priority=900)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def give_levels(_app: Any, _page: str, _template: str, context: dict[str, Any], _tree: Any) -> None:
    """Give the captions of a page the level of its sections."""
    for part in ("body", "furo_navigation_tree"):
        if context.get(part):
            context[part] = context[part].replace(CAPTION, f'{CAPTION[:-1]} aria-level="2">')

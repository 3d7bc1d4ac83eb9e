"""Colours of the site: those of the report and of the live page, from the one style sheet that has them."""

import re
from pathlib import Path

PAGES = Path(__file__).parents[2] / "maglev"
COLOURS = PAGES / "pages" / "tokens.css"


def tokens() -> str:
    """Style sheet with the colours under the site's switch of light and dark."""
    blocks = re.findall(r":root \{\n(.*?)\n *\}", COLOURS.read_text(encoding="utf-8"), re.DOTALL)
    light, dark = (re.sub(r"\s*color-scheme:[^;]*;", "", block).strip() for block in blocks[:2])
    return (f"body {{ {light} }}\nbody[data-theme=dark] {{ {dark} }}\n@media (prefers-color-scheme: dark) {{\n"
            f"body:not([data-theme=light]) {{ {dark} }}\n}}\n")


def write_tokens(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tokens.css").write_text(tokens(), encoding="utf-8")

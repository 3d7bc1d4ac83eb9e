"""Colours of the site: those of the report and of the live page, from the one style sheet that has them."""

import re
from pathlib import Path

PAGES = Path(__file__).parents[2] / "maglev"
COLOURS, STYLE = PAGES / "pages" / "tokens.css", PAGES / "report" / "style.css"


def tokens() -> str:
    """Style sheet with the colours under the site's switch of light and dark, and the rules of static pictures."""
    colours, text = (path.read_text(encoding="utf-8") for path in (COLOURS, STYLE))
    light, dark = (re.sub(r"\s*color-scheme:[^;]*;", "", block).strip()
                   for block in re.findall(r":root \{\n(.*?)\n *\}", colours, re.DOTALL)[:2])
    pictures = "".join(f"{line}\n" for line in text.splitlines() if line.startswith(".still"))
    return (f"body {{ {light} }}\nbody[data-theme=dark] {{ {dark} }}\n@media (prefers-color-scheme: dark) {{\n"
            f"body:not([data-theme=light]) {{ {dark} }}\n}}\nsvg.still path {{ fill: none; }}\n{pictures}")


def write_tokens(folder: Path) -> None:
    """Write them as tokens.css into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "tokens.css").write_text(tokens(), encoding="utf-8")

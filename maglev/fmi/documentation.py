"""documentation/index.html of an FMU: the equations from its packages, the variables from its table."""

import re
from collections import Counter
from collections.abc import Sequence
from decimal import Decimal
from functools import lru_cache
from html import escape
from pathlib import Path
from urllib.parse import quote

from maglev.files.fmi_units import RAISED, typeset_unit
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.icon import Shape, svg_file, svg_icon
from maglev.fmi.sketch import STYLE as SKETCH_STYLE
from maglev.fmi.templates import filled
from maglev.language.sources import module_path

HERE = Path(__file__).with_name("pages")

# Classes of the columns of a table after the name.
LOOKS = (' class="number"', ' class="unit"', ' class="range"', "", ' class="text"', ' class="text source"')

# Equations in the HTML of a page: \(…\) within a line, \[…\] on a line of its own.
TEX = re.compile(r"\\\((.+?)\\\)|\\\[(.+?)\\\]", re.DOTALL)
PAIRS = ("{", "}"), (r"\\begin\b", r"\\end\b"), (r"\\left\b", r"\\right\b")


def external_dependencies(definition: FmuDefinition) -> str:
    """Return the text about the environment that an FMU needs to run in Python."""
    needed = ", ".join(definition.requires)
    return filled(HERE / "externalDependencies.txt", {
        "PACKAGES": f"with the packages {needed}" if needed else "its standard library alone: no other packages"})


def icon_of(definition: FmuDefinition) -> tuple[Shape, ...]:
    return () if definition.icon is None else tuple(definition.icon.drawn())


def documentation(definition: FmuDefinition, version: str, pages: Sequence[Path] = ()) -> str:
    """HTML page with a sketch, the block's equations, limits and variables; sections are in further folders, too."""
    sections = typeset("\n".join(block_section(pages, package, name) for package, name in definition.documentation))
    sketch = "" if definition.sketch is None else definition.sketch.drawn()
    return with_contents(filled(HERE / "page.html", {
        "NAME": escape(definition.name), "ABOUT": escape(definition.description),
        "ICON": quote(svg_file(icon_of(definition)).strip(), safe=" =/:.-'"), "SVG_ICON": svg_icon(icon_of(definition)),
        "STYLE": f"\n{(HERE / 'page.css').read_text(encoding='utf-8')}{SKETCH_STYLE}",
        "TITLE": f"{breakable(definition.name)} {escape(version)}", "SKETCH": sketch, "SECTIONS": sections,
        **{f"{causality.upper()}S": variable_table(definition, causality)
           for causality in ("input", "output", "parameter")}}))


def with_contents(page: str) -> str:
    """A page with an anchor at each heading of its sections, and links to these where it has a place for them."""
    links, used = list[str](), Counter[str]()

    def anchored(heading: re.Match[str]) -> str:
        place = re.sub(r"[^a-z0-9]+", "-", heading[1].lower()).strip("-")
        used[place] += 1
        place += f"-{used[place]}" if used[place] > 1 else ""
        links.append(f'<a href="#{place}">{heading[1]}</a>')
        return f'<h2 id="{place}">{heading[1]}</h2>'

    return re.sub("<h2>(.*?)</h2>", anchored, page).replace("<!--contents-->", "\n".join(links))


def block_section(pages: Sequence[Path], package: str, name: str) -> str:
    """HTML of a section: from one of the further folders of packages, or else from that of the package."""
    written = (folder / package / "documentation" / name for folder in pages)
    page = next((file for file in written if file.is_file()), module_path(package).parent / "documentation" / name)
    return page.read_text(encoding="utf-8").strip()


def variable_table(definition: FmuDefinition, causality: str) -> str:
    """Table of the variables of a causality; start values and sources where they have one."""
    titles = ("name", "start", "unit", "range", "variability", "meaning", "source of the value")
    rows = []
    for v in (variable for variable in definition.variables if variable.causality == causality):
        start = "" if v.causality == "output" else str(definition.start_value(v)).lower()
        bounds = "" if v.minimum is None or v.maximum is None else f"{numeral(v.minimum)} … {numeral(v.maximum)}"
        start = start if v.causality == "output" or v.boolean else numeral(float(start))
        rows.append((v.name, start, typeset_unit(v.unit), bounds, v.variability, v.description, v.source))
    shown = [k for k in range(len(titles)) if any(row[k] for row in rows)]
    head = "".join(f'<th scope="col">{titles[k]}</th>' for k in shown)
    body = "\n".join(f'<tr><th scope="row">{breakable(row[0])}</th>' + "".join(
        f"<td{LOOKS[k - 1]}>{escape(row[k])}</td>" for k in shown[1:])
        + "</tr>" for row in rows)
    return f'<div class="wide" tabindex="0"><table><thead><tr>{head}</tr></thead>\n{body}\n</table></div>'


def breakable(name: str) -> str:
    """HTML of a name that may be broken between its words."""
    return re.sub(r"(?<=\.)|(?<=[a-z])(?=[A-Z])", "<wbr>", escape(name))


def numeral(value: float) -> str:
    """A number as people write it, with all its digits: 0.0002, −1000, 10⁻⁶, 2.5 · 10⁷."""
    text = repr(value).removesuffix(".0")
    if value and not 1e-4 <= abs(value) < 1e6:
        mantissa, _, exponent = f"{Decimal(text).normalize():e}".partition("e")
        power = f"10{str(int(exponent)).translate(RAISED)}"
        text = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa} · {power}")
    return text.replace("-", "−")


@lru_cache(maxsize=1024)
def mathml(tex: str, display: bool = False) -> str:
    """An equation within a line, or on a line of its own: there one for each part between \\qquad, to be wrapped."""
    # Reading its table of symbols takes a tenth of a second, which only who typesets something shall wait for.
    from latex2mathml.converter import convert

    if not display:
        return str(convert(tex))
    first, *others = tex.split(r"\qquad")
    parts = [first]
    for part in others:
        if all(len(re.findall(begun, parts[-1])) == len(re.findall(ended, parts[-1])) for begun, ended in PAIRS):
            parts.append(part)
        else:
            parts[-1] += rf"\qquad{part}"
    return "".join(convert(part, display="block") for part in parts)


def typeset(html: str) -> str:
    """HTML with its equations as MathML."""
    return TEX.sub(lambda match: mathml(match[1]) if match[1] else
                   f"<div>{mathml(match[2], display=True)}</div>", html)

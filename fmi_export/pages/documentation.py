"""documentation/index.html of an FMU: the equations from its packages, the variables from its table."""

import re
from decimal import Decimal
from html import escape
from urllib.parse import quote

from fmi_export.definition import FmuDefinition
from fmi_export.pages.icon import Shape, svg_file, svg_icon
from fmi_export.pages.mathml import typeset
from fmi_export.pages.sketch import STYLE as SKETCH_STYLE
from fmi_export.sources import module_path
from fmi_export.units import RAISED, typeset_unit

LOOKS = ("name", "number", "unit", "number", "variability", "text", "text")   # of the columns of a table

STYLE = """
:root { color-scheme: light dark; --page: #ffffff; }
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; background: var(--page);
overflow-wrap: break-word; } h1 { display: flex; align-items: center; gap: .5em; line-height: 1.2;
font-size: clamp(1.25em, 6vw, 2em); } h1 span { min-width: 0; overflow-wrap: anywhere; }
.icon { width: 2em; height: 2em; flex: none; border-radius: .2em; }
table { border-collapse: collapse; font-size: 14px; } td, th { border: 1px solid #8886; padding: .2em .5em;
text-align: left; vertical-align: top; } .number, .unit { white-space: nowrap; } .number { text-align: right; }
.eq { margin: .6em 0 .6em 2em; overflow: auto hidden; } .eq div { display: flex; flex-wrap: wrap; align-items: baseline;
gap: 0 2em; } .eq math { margin: .4em 0; width: max-content; font-size: 1.1em; }
mover:not([accent]) > mo { font-size: 1.2em; }
.wide { overflow-x: auto; } .text { min-width: 12em; } @media screen { td wbr { display: none; } }
@media (max-width: 40em) { .eq { margin-left: 0; font-size: 90%; } }
@media (prefers-color-scheme: dark) { :root { --page: #181818; } body { color: #ddd; } a { color: #8cf; } }
@media print { :root { color-scheme: light; --page: #ffffff; } body { color: #000; max-width: none; margin: 0; }
.wide, .eq { overflow: visible; } .eq { margin-left: .5em; font-size: 90%; }
table { font-size: 8.5px; }
.text { min-width: 0; } tr, .eq, .sketch { break-inside: avoid; } h2 { break-after: avoid; } }
"""

# Of an FMU on pythonfmu: what FMI asks to document (2.0.5, section 2.3).
EXTERNAL_DEPENDENCIES = """\
This FMU runs in a Python interpreter inside the importing process; needsExecutionTool stands for that. It needs

- Python 3.11 or newer, 64 bit, {packages}.
- Linux on x86-64 with the GNU C library 2.32 or newer and libstdc++. A program that is no Python interpreter has to
  load the Python library before the FMU, for instance with LD_PRELOAD=/usr/lib/x86_64-linux-gnu/libpython3.11.so.
- Or Windows on x86-64 with python3.dll in the search path and the Visual C++ runtime (MSVCP140.dll, VCRUNTIME140.dll,
  VCRUNTIME140_1.dll).

The native FMU of the same name needs none of this.
"""


def external_dependencies(definition: FmuDefinition) -> str:
    """Text of what an FMU that runs in Python needs around it."""
    needed = ", ".join(definition.requires)
    return EXTERNAL_DEPENDENCIES.format(
        packages=f"with the packages {needed}" if needed else "its standard library alone: no other packages")


def icon_of(definition: FmuDefinition) -> tuple[Shape, ...]:
    """Shapes of the icon; none if the definition has no icon."""
    return () if definition.icon is None else tuple(definition.icon.drawn())


def documentation(definition: FmuDefinition, version: str) -> str:
    """HTML page with a sketch, the block's equations, limits and variables."""
    module = definition.block.__module__
    sections = typeset("\n".join(section(module, package, name) for package, name in definition.documentation))
    sketch = "" if definition.sketch is None else definition.sketch.drawn()
    name, about = escape(definition.name), escape(definition.description)
    icon = quote(svg_file(icon_of(definition)).strip())
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}</title>
<meta name="description" content="{about}">
<meta property="og:title" content="{name}">
<meta property="og:description" content="{about}">
<link rel="icon" href="data:image/svg+xml,{icon}">
<style>{STYLE}{SKETCH_STYLE}</style></head>
<body>
<h1>{svg_icon(icon_of(definition))}<span>{breakable(definition.name)} {escape(version)}</span></h1>
<p>{about}</p>
{sketch}
{sections}
<h2>Inputs</h2>
{variable_table(definition, "input")}
<h2>Outputs</h2>
{variable_table(definition, "output")}
<h2>Parameters</h2>
<p>A tunable parameter acts at the next step, a fixed one can be set until the initialization ends. A value outside
its range is refused with a message before the next step.</p>
{variable_table(definition, "parameter")}
</body>
</html>
"""


def section(module: str, package: str, name: str) -> str:
    """HTML of a section: what is written with the module of a block, or else from the folder of a package."""
    written = module_path(module).parents[1] / package / "documentation" / name
    page = written if written.is_file() else module_path(package).parent / "documentation" / name
    return page.read_text(encoding="utf-8").strip()


def variable_table(definition: FmuDefinition, causality: str) -> str:
    """Table of the variables of a causality; start values and sources where they have one."""
    titles = ("name", "start", "unit", "range", "variability", "meaning", "source of the value")
    rows = []
    for v in (variable for variable in definition.variables if variable.causality == causality):
        start = "" if v.causality == "output" else str(definition.start_value(v))
        bounds = "" if v.minimum is None or v.maximum is None else f"{number(v.minimum)} … {number(v.maximum)}"
        start = start if v.causality == "output" or v.boolean else number(float(start))
        rows.append((v.name, start, typeset_unit(v.unit), bounds, v.variability, v.description, v.source))
    shown = [k for k in range(len(titles)) if any(row[k] for row in rows)]
    head = "".join(f'<th scope="col">{titles[k]}</th>' for k in shown)
    body = "\n".join("<tr>" + "".join(f'<td class="{LOOKS[k]}">{breakable(row[k]) if k == 0 else escape(row[k])}</td>'
                                      for k in shown) + "</tr>" for row in rows)
    return f'<div class="wide" tabindex="0"><table><thead><tr>{head}</tr></thead>\n{body}\n</table></div>'


def breakable(name: str) -> str:
    """HTML of a name that may be broken between its words."""
    return re.sub(r"(?<=\.)|(?<=[a-z])(?=[A-Z])", "<wbr>", escape(name))


def number(value: float) -> str:
    """A number as people write it, with all its digits: 0.0002, −1000, 10⁻⁶, 2.5 · 10⁷."""
    text = repr(value).removesuffix(".0")
    if value and not 1e-4 <= abs(value) < 1e6:
        mantissa, _, exponent = f"{Decimal(text).normalize():e}".partition("e")
        power = f"10{str(int(exponent)).translate(RAISED)}"
        text = {"1": power, "-1": f"-{power}"}.get(mantissa, f"{mantissa} · {power}")
    return text.replace("-", "−")

"""documentation/index.html of an FMU: the equations from its packages, the variables from its table."""

from html import escape
from importlib.resources import files

from fmi_export.definition import FmuDefinition, Variable

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; font-size: 14px; } td, th { border: 1px solid #8886; padding: .2em .5em;
text-align: left; vertical-align: top; } .eq { margin: .6em 2em; font-family: "Latin Modern Math", Cambria, serif; }
.wide { overflow-x: auto; } sup, sub { line-height: 0; }
@media (prefers-color-scheme: dark) { body { background: #181818; color: #ddd; } a { color: #8cf; } }
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


def documentation(definition: FmuDefinition, version: str) -> str:
    """HTML page with the block's equations, limits and variables."""
    sections = "\n".join(
        files(package).joinpath("documentation", name).read_text(encoding="utf-8").strip()
        for package, name in definition.documentation)
    parameters = [v for v in definition.variables if v.causality == "parameter"]
    inputs = [v for v in definition.variables if v.causality == "input"]
    outputs = [v for v in definition.variables if v.causality == "output"]
    name = escape(definition.name)
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}</title><style>{STYLE}</style></head>
<body>
<h1>{name} {escape(version)}</h1>
<p>{escape(definition.description)}</p>
{sections}
<h2>Inputs</h2>
{variable_table(definition, inputs)}
<h2>Outputs</h2>
{variable_table(definition, outputs)}
<h2>Parameters</h2>
<p>A tunable parameter acts at the next step, a fixed one can be set until the initialization ends. A value outside
its range is refused with a message before the next step.</p>
{variable_table(definition, parameters)}
</body>
</html>
"""


def variable_table(definition: FmuDefinition, variables: list[Variable]) -> str:
    """Table of variables; start values and sources where they have one."""
    rows = []
    for v in variables:
        start = "" if v.causality == "output" else str(definition.start_value(v))
        bounds = "" if v.minimum is None else f"{v.minimum:g} … {v.maximum:g}"
        cells = (v.name, start, v.unit, bounds, v.variability, v.description, v.source)
        rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{title}</th>"
                   for title in ("name", "start", "unit", "range", "variability", "meaning", "source of the value"))
    return f'<div class="wide"><table><tr>{head}</tr>\n' + "\n".join(rows) + "\n</table></div>"

"""Pages made when the site is built: the command line, the functions, experiments, notebooks; the first page moves."""

import re
import shutil
from pathlib import Path
from typing import Any

import typer
from typer.cli import get_docs_for_click
from typer.main import get_command

import maglev
from maglev.api.catalogue import RunEntry
from maglev.cli.app import app as command_line

ROOT = Path(__file__).parents[2]
MADE = "_made"   # folder in docs, not committed

LIVE = """```{raw} html
<div class="live">
<iframe src="stage/live.html#run=3dof-setpoints-improved" title="The live stage" loading="lazy"></iframe>
<p>Drag the platform. <a href="stage/live.html">On its own page</a> it has plots, and an editor for your controller.</p>
</div>
```"""

FUNCTIONS = """# Functions

Everything that `import maglev` offers. What the command line does, these functions do.

```{eval-rst}
.. currentmodule:: maglev

"""


def command_line_page() -> str:
    """Every command with its options, as its help says."""
    click = get_command(command_line)
    context = typer.Context(click)
    text: str = get_docs_for_click(obj=click, ctx=context, name="maglev")
    return text.replace("# `maglev`", "# Command line", 1)


def functions_page() -> str:
    """Every public name with its docstring: functions first, then what they give, then the errors."""
    public = [(name, getattr(maglev, name)) for name in maglev.__all__]
    errors = [name for name, what in public if isinstance(what, type) and issubclass(what, Exception)]
    classes = [name for name, what in public if isinstance(what, type) and name not in errors]
    functions = [name for name, what in public if not isinstance(what, type)]
    return (FUNCTIONS + "".join(f".. autofunction:: {name}\n\n" for name in functions)
            + "".join(f".. autoclass:: {name}()\n   :members:\n\n" for name in classes)
            + "".join(f".. autoexception:: {name}()\n\n" for name in errors) + "```\n")


def experiments_page(pages: Path) -> str:
    """List of the experiments, with a link to the page of each that `docs/site/experiments.py` has made."""
    runs: dict[str, RunEntry] = {}
    for run in maglev.scenarios():
        runs.setdefault(run.scenario, run)
    made = [scenario for scenario in runs if (pages / f"{scenario}.md").is_file()]
    if not made:
        return "# Experiments\n\nTheir pages are made by `make docs`; `maglev list` lists them.\n"
    rows = "".join(f"| [{scenario}]({pages.name}/{scenario}.md) | {runs[scenario].title.replace('|', ',')} | "
                   f"{', '.join(runs[scenario].figures)} |\n" for scenario in made)
    return ("# Experiments\n\nEvery experiment has a page with its picture and its commands, most a link that runs it "
            f"live.\n\n| experiment | what it is | figures of the thesis |\n"
            f"|---|---|---|\n{rows}\n```{{toctree}}\n:hidden:\n:glob:\n\n{pages.name}/*\n```\n")


def live_first_page(app: Any, page: str, source: list[str]) -> None:
    """Have the live stage run on the first page, instead of its picture, where `make docs` has made it."""
    if page == "index" and (Path(app.srcdir) / MADE / "extra" / "stage" / "live.html").is_file():
        source[0], number = re.subn(r"^!\[The live stage[^\n]*$", LIVE, source[0], flags=re.MULTILINE)
        if number != 1:
            raise ValueError("index.md: expected one picture of the live stage, whose place the stage takes")


def make_pages(app: Any) -> None:
    folder = Path(app.srcdir) / MADE
    folder.mkdir(exist_ok=True)
    pages = {"command_line.md": command_line_page(), "functions.md": functions_page(),
             "experiments.md": experiments_page(folder / "experiments")}
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        shutil.copy(notebook, folder / notebook.name)


def setup(app: Any) -> dict[str, bool]:
    """Ask Sphinx to be called before it reads."""
    app.connect("builder-inited", make_pages)
    app.connect("source-read", live_first_page)
    return {"parallel_read_safe": True}

"""Pages of the reference, made when the site is built: the command line, the functions, the gallery, notebooks."""

import shutil
from pathlib import Path
from typing import Any

import typer
from typer.cli import get_docs_for_click
from typer.main import get_command

import maglev
from maglev.cli.app import app as command_line

ROOT = Path(__file__).parents[2]
MADE = "_made"   # folder in docs, not committed

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
    found = [(name, getattr(maglev, name)) for name in maglev.__all__]
    errors = [name for name, each in found if isinstance(each, type) and issubclass(each, Exception)]
    classes = [name for name, each in found if isinstance(each, type) and name not in errors]
    functions = [name for name, each in found if not isinstance(each, type)]
    return (FUNCTIONS + "".join(f".. autofunction:: {name}\n\n" for name in functions)
            + "".join(f".. autoclass:: {name}()\n   :members:\n\n" for name in classes)
            + "".join(f".. autoexception:: {name}()\n\n" for name in errors) + "```\n")


def gallery_page(pictures: Path) -> str:
    """Pictures of the main runs, those in a folder that `docs/site/gallery.py` has filled."""
    drawn = sorted(pictures.glob("*.png"))
    text = "".join(f"## {path.stem}\n\n![{path.stem}](gallery/{path.name})\n\n" for path in drawn)
    return "# Gallery\n\n" + (text or "The pictures are made by `make docs`.\n")


def make_pages(app: Any) -> None:
    """Write the pages before Sphinx reads."""
    folder = Path(app.srcdir) / MADE
    folder.mkdir(exist_ok=True)
    pages = {"command_line.md": command_line_page(), "functions.md": functions_page(),
             "gallery.md": gallery_page(folder / "gallery")}
    for name, text in pages.items():
        (folder / name).write_text(text, encoding="utf-8")
    for notebook in (ROOT / "examples").glob("*.ipynb"):
        shutil.copy(notebook, folder / notebook.name)


def setup(app: Any) -> dict[str, bool]:
    """Ask Sphinx to be called before it reads."""
    app.connect("builder-inited", make_pages)
    return {"parallel_read_safe": True}

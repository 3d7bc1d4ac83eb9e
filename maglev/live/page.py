"""The page: data, modules and scripts in one file that needs no network."""

import base64
import gzip
import json
from importlib.metadata import version
from pathlib import Path
from string import Template

from fmi_export.whole_file import write_whole
from maglev.live.content import FLOWN, page_data
from maglev.live.link import NAME

FOLDER = Path(__file__).parent
WORKER = ("fmu.js", "signals.js", "flight.js", "worker.js")                      # in the thread that flies
SCRIPTS = ("state.js", "history.js", "traces.js", "plots.js", "stage.js", "controls.js", "main.js", "hands.js",
           "start.js")


def write_live(out: str | Path = "results", *, fmus: str | Path = "fmus") -> Path:
    """Write `live.html`: one page that flies the stages in a browser, from disk and without network.

    Parameters
    ----------
    out : path
        Folder for the page, made if it is not there.
    fmus : path
        Folder of the FMUs, whose folder `wasm` has the WebAssembly modules and their descriptions.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    MaglevError
        If a module is missing: `build(native=True, target="wasm")` makes them.
    """
    path = Path(out) / NAME
    write_whole(path, live_page(Path(fmus) / "wasm"))
    return path


def live_page(fmus: Path) -> str:
    """Text of the page; the same files give the same text."""
    data = json.dumps(page_data(fmus), allow_nan=False, separators=(",", ":"))
    modules = {name: packed((fmus / f"{name}.wasm").read_bytes()) for name in FLOWN}
    return Template(read("page.html")).substitute(
        style=read("style.css"),
        version=version("maglev-fmus"),
        modules="\n".join(f'<script type="text/plain" id="fmu-{name}">{text}</script>'
                          for name, text in modules.items()),
        data=packed(data.encode("utf-8")),
        worker="\n".join(read(name) for name in WORKER),
        scripts="\n".join(f"<script>\n{read(name)}</script>" for name in SCRIPTS))


def read(name: str) -> str:
    """Text of a file of this package."""
    return (FOLDER / name).read_text(encoding="utf-8")


def packed(data: bytes) -> str:
    """Bytes as gzip in base64: its time is zero, so that the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")

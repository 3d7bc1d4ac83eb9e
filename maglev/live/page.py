"""The page: data, modules and scripts in one file that needs no network."""

import json
from collections.abc import Iterable, Mapping
from html import escape
from importlib.metadata import version
from pathlib import Path

from maglev.live.content import live_runs, not_live, page_data
from maglev.live.link import NAME
from maglev.own_stage.loop import loop_table
from maglev.own_stage.reading import read_own
from maglev.pages import shell
from maglev.schema.loading import load_plans
from maglev.schema.run_plan import RunPlan
from maglev.toml_file import read_toml

FOLDER = Path(__file__).parent
WORKER = ("fmu.js", "law.js", "signals.js", "flight.js", "worker.js")                      # in the thread that flies
SCRIPTS = ("state.js", "history.js", "traces.js", "pen.js", "plots.js", "forces.js", "stage.js", "camera.js",
           "space.js", "controls.js", "stories.js", "own.js", "messages.js", "main.js", "hands.js", "start.js")
POLICY = ("script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; "
          "img-src data:")


def write_live(out: str | Path = "results", *, files: Iterable[str | Path] = (), fmus: str | Path = "fmus") -> Path:
    """Write one page that flies stages in a browser, from disk and without network.

    Parameters
    ----------
    out : path
        Folder for the page, made if it is not there.
    files : iterable of path
        What flies there in place of all packaged runs: scenarios, or descriptions of stages, which rest at their start.
    fmus : path
        Folder of the FMUs, whose folder `wasm` has the WebAssembly modules and their descriptions.

    Returns
    -------
    Path
        The page: `live.html`, or `live-NAME.html` after the first file NAME.toml.

    Raises
    ------
    MaglevError
        If a module is missing or was built of other variables: `build(native=True, target="wasm")` makes them; or if a
        run cannot fly there.
    """
    named = [*map(Path, files)]
    plans = [plan for file in named for plan in plans_of(file)] if named else live_runs()
    path = Path(out) / (f"{Path(NAME).stem}-{named[0].stem}.html" if named else NAME)
    shell.publish(path, live_page(Path(fmus) / "wasm", plans, {} if named else not_live()))
    return path


def plans_of(file: Path) -> list[RunPlan]:
    """Runs of a scenario, or a description's stage at rest."""
    if file.suffix != ".toml" or {"rig", "extends", "fmus"} & read_toml(file).keys():
        return load_plans(file)
    rig = read_own(file)
    table = {**loop_table(rig), "rig": str(file), "name": rig.name, "title": f"{rig.title}, at rest"}
    return [RunPlan.model_validate({**table, "stop_time": 1e4 * table["output_interval"]})]


def live_page(fmus: Path, plans: Iterable[RunPlan], elsewhere: Mapping[str, Iterable[str]] | None = None) -> str:
    """Text of a page that flies runs, and says why others are `elsewhere`; the same files give the same text."""
    data = page_data(fmus, plans)
    modules = {name: shell.packed((fmus / f"{name}.wasm").read_bytes()) for name in data["fmus"]}
    return shell.page(
        "live", "Maglev stage, live", read("style.css"), read("page.html"), POLICY,
        version=version("maglev-fmus"),
        elsewhere=reasons(elsewhere or {}),
        modules="\n".join(f'<script type="text/plain" id="fmu-{name}">{text}</script>'
                          for name, text in modules.items()),
        data=shell.packed(json.dumps(data, allow_nan=False, separators=(",", ":")).encode("utf-8")),
        worker="\n".join(read(name) for name in WORKER),
        scripts=shell.scripts(*map(read, SCRIPTS)))


def reasons(elsewhere: Mapping[str, Iterable[str]]) -> str:
    """A list of runs that a page does not fly, by the reason; empty if there are none."""
    rows = "\n".join(f"<li>{escape(', '.join(names))}: {escape(why)}</li>" for why, names in elsewhere.items())
    return f"<details><summary>Runs that do not fly here</summary><ul>\n{rows}</ul></details>\n" if rows else ""


def read(name: str) -> str:
    return (FOLDER / name).read_text(encoding="utf-8")

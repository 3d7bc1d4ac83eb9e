"""The page: data, modules and scripts in one file that needs no network."""

import json
from collections.abc import Iterable, Mapping
from functools import partial
from html import escape
from importlib.metadata import version
from pathlib import Path

from maglev.files.side_by_side import Say, Watch, unwatched, warn
from maglev.files.toml_file import read_toml
from maglev.pages import shell
from maglev.pages.javascript import parts_text
from maglev.pages.live_content import NAME, live_runs, modules_of, not_live, page_data, require_live
from maglev.scenario.catalogue import WASM
from maglev.scenario.fmus_for_runs import built
from maglev.scenario.loading import load_plans
from maglev.scenario.run_plan import RunPlan
from maglev.user.reading import read_own
from maglev.user.scenario_loop import loop_table

FOLDER = Path(__file__).with_name("live")
EDITOR = FOLDER / "vendor" / "codemirror.js"   # not ours: see next to it
WAVES = "from pmlsm.sine_cosine import sine_cosine"   # for references, as blocks compute them
WORKER = ("fmu.js", "law.js", "signals.js", "simulation.js", "worker.js")                      # in the thread that runs
SCRIPTS = ("state.js", "history.js", "plots.js", "forces.js", "controls.js", "starters.js", "editor.js",
           "beat.js", "stories.js", "own.js", "messages.js", "main.js", "picture.js", "panel.js", "hands.js",
           "start.js")
read = partial(shell.read, folder=FOLDER)
of_report = partial(shell.read, folder=FOLDER.with_name("report"))
PLOTS = ("plots/plot.js", "plots/plot_hands.js")   # of the report
ABOUT = "A platform that magnets hold in the air: drag it, drop a weight on it, write a controller that does better."
POLICY = ("script-src 'unsafe-inline' 'wasm-unsafe-eval' blob:; worker-src blob:; style-src 'unsafe-inline'; "
          "img-src data: blob:")


def write_live(out: str | Path = "results", *, files: str | Path | Iterable[str | Path] = (),
               fmus: str | Path | None = None, say: Say = warn, watch: Watch = unwatched) -> Path:
    """Write one page that runs stages in a browser, from disk and without network.

    Parameters
    ----------
    out : path
        Folder for the page, made if it is not there.
    files : path, or iterable of path
        Replacement of all packaged runs: scenarios, or descriptions of stages, which rest at their start.
    fmus : path, optional
        Folder of FMUs, whose folder `wasm` has the WebAssembly modules and their descriptions. If not given, these are
        built where they are missing, which needs the extra `native`, and kept in the user's cache.
    say, watch : callable
        Told what is built, and how much of it.

    Returns
    -------
    Path
        The page: `live.html`, or `live-NAME.html` after the first file NAME.toml.

    Raises
    ------
    MaglevError
        If a module is missing or was built of other variables, which `build(kind="native", target="wasm")` makes; or
        if a run cannot run there.
    """
    named = [*map(Path, [files] if isinstance(files, str | Path) else files)]
    plans = [plan for file in named for plan in plans_of(file)] if named else live_runs()
    path = Path(out) / (f"{Path(NAME).stem}-{named[0].stem}.html" if named else NAME)
    if fmus is None:
        for plan in plans:
            require_live(plan)
        names = dict.fromkeys(name for plan in plans if plan.stage is not None for name in modules_of(plan.stage))
        folder = built(names, WASM, say, watch)
    else:
        folder = Path(fmus) / "wasm"
    shell.publish(path, live_page(folder, plans, {} if named else not_live()))
    return path


def plans_of(file: Path) -> list[RunPlan]:
    """Runs of a scenario, or a description's stage at rest."""
    keys = read_toml(file) if file.suffix == ".toml" else {}
    if not keys or {"extends", "fmus"} & keys.keys() or isinstance(keys.get("stage"), str):
        return load_plans(file)   # in a description [plant] has constants
    stage = read_own(file)
    table = {**loop_table(stage), "stage": str(file), "name": stage.name, "title": f"{stage.title}, at rest"}
    return [RunPlan.model_validate({**table, "stop_time": 1e4 * table["output_interval"]})]


def live_page(fmus: Path, plans: Iterable[RunPlan], elsewhere: Mapping[str, Iterable[str]] | None = None) -> str:
    """Text of a page that simulates runs, and says why others are `elsewhere`; the same files give the same text."""
    data = page_data(fmus, plans)
    modules = {name: shell.packed_text((fmus / f"{name}.wasm").read_bytes()) for name in data["fmus"]}
    return shell.page(
        "live", "Maglev stage, live", ABOUT, of_report("plots/plots.css") + read("style.css"), read("page.html"),
        POLICY,
        version=version("maglev-fmus"),
        elsewhere=reasons(elsewhere or {}),
        modules="\n".join(f'<script type="text/plain" id="fmu-{name}">{text}</script>'
                          for name, text in modules.items()),
        data=shell.packed_text(json.dumps(data, allow_nan=False, separators=(",", ":")).encode("utf-8")),
        editor=shell.packed_text(b"/*\n%s*/\n%s" % (EDITOR.with_name("LICENSE").read_bytes(), EDITOR.read_bytes())),
        worker=shell.packed_text(worker_text().encode("utf-8")),
        scripts=shell.scripts(shell.scene(), *map(of_report, PLOTS), *map(read, SCRIPTS)))


def worker_text() -> str:
    """The script of the thread that runs."""
    return shell.COMMENT.sub("", "\n".join((parts_text([WAVES]), *map(read, WORKER))))


def reasons(elsewhere: Mapping[str, Iterable[str]]) -> str:
    """A list of runs that a page does not run, by the reason; empty if there are none."""
    rows = "\n".join(f"<li>{escape(', '.join(names))}: {escape(why)}</li>" for why, names in elsewhere.items())
    return f"<details><summary>Runs that are not here</summary><ul>\n{rows}</ul></details>\n" if rows else ""

"""Scenario files as they stand: TOML, files that extend others, variants; and those that come with the package.

Their values are not checked here, because a list of the runs needs only their names.
"""

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any, NamedTuple

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import ScenarioError, nearest, shortened
from maglev.files.toml_file import read_toml, toml_text
from maglev.user.reading import read_own
from maglev.user.scenario_loop import loop_table, setpoint_signals

# The experiments are a folder next to the package in the repository, and in it where it is installed; in it a folder
# for each stage has the experiments themselves.
HERE = Path(__file__).parents[1]
PACKAGED = next(folder for folder in (HERE / "scenarios", HERE.parent / "scenarios") if folder.is_dir())

DEEPEST = 30        # files that extend each other one after the other
SETPOINTS = "setpoints"   # instead of signals: those that follow from the stage of a description
MOST_LAYERS = 300   # files on all paths of a scenario: those that meet again double their number


@dataclass(frozen=True)
class ScenarioTable:
    """A scenario that was given as a table, in JSON: it is read as a file in the working folder."""

    text: str

    def __str__(self) -> str:
        name = re.sub(r"[^\w-]", "_", str(json.loads(self.text).get("name", "without a name")))
        return f"table {name} {hashlib.sha256(self.text.encode()).hexdigest()[:8]}"

    @property
    def parent(self) -> Path:
        """Return the folder in which its relative file names begin."""
        return Path()


Scenario = str | Path | Mapping[str, Any]   # a name or a file, or the content of one
ScenarioSource = Path | ScenarioTable


class Layer(NamedTuple):
    """A table, and where it stands, for messages."""

    place: object
    table: dict[str, Any]


def read_layers(source: ScenarioSource, extending: tuple[ScenarioSource, ...] = ()) -> list[Layer]:
    """Read a scenario and the files it extends, the scenario itself last.

    ScenarioError if a file is missing, is not TOML, or extends itself.
    """
    if source in extending:
        raise ScenarioError(f"{extending[0]}: extends = {str(source)!r}: a file cannot extend itself")
    if len(extending) == DEEPEST:
        raise ScenarioError(f"{extending[0]}: extends: {DEEPEST} files extend each other before {source}, expected "
                            "fewer")
    return extended(source, scenario_table(source), extending)


def extended(path: ScenarioSource, table: dict[str, Any], extending: tuple[ScenarioSource, ...] = ()) -> list[Layer]:
    """Return the layers of the files that a table at a path extends, in their order, and the table itself last."""
    bases = table.get("extends", [])
    layer = Layer(path, {key: value for key, value in table.items() if key != "extends"})
    bases = [bases] if isinstance(bases, str) else bases
    if not isinstance(bases, list) or not all(isinstance(base, str) for base in bases):
        raise ScenarioError(f"{path}: extends = {bases!r}: expected the relative path of a scenario file, or a list")
    layers = []
    signals = table.get("signals")
    if isinstance(signals, str) and (signals != SETPOINTS or "stage" not in table):
        raise ScenarioError(f'{path}: signals = {signals!r}: expected "{SETPOINTS}" with stage = "NAME.toml", or '
                            "[[signals]]")
    stage = table.get("stage", "")
    if isinstance(stage, dict) or {"motor", "geometry", "catalogue"} & {*table}:
        raise ScenarioError(f"{path}: is the description of a stage, expected a scenario, such as one with "
                            f'stage = "{Path(str(path)).name}"')
    if not isinstance(stage, str):
        raise ScenarioError(f'{path}: stage = {shortened(stage)}: expected the file of a description, "NAME.toml"')
    if "stage" in table:
        description = read_own(Path(table["stage"]))
        layers = [Layer(Path(table["stage"]), loop_table(description))]
        if table.get("signals") == SETPOINTS:
            layer.table["signals"] = setpoint_signals(description)
    for base in bases:
        layers += read_layers(extended_file(path, base), (*extending, path))
        if len(layers) > MOST_LAYERS:
            raise ScenarioError(f"{path}: extends: more than {MOST_LAYERS} files on all its paths, expected fewer")
    return [*layers, layer]


def extended_file(path: ScenarioSource, base: str) -> Path:
    """Return the file that a file extends: next to it, or else among those of the package, such as "loops/3dof.toml".
    """
    folders = (PACKAGED, *(PACKAGED / stage for stage in PACKAGED_STAGES))
    for file in (folder / base for folder in (path.parent, *folders)):
        if file.is_file():
            return file.resolve()
    beside = [str(Path(base).parent / file.name) for file in (path.parent / base).parent.glob("*.toml")
              if file != path]
    packaged = sorted(str(file.relative_to(folder)) for folder in folders for file in folder.rglob("*.toml"))
    raise ScenarioError(f"{path}: extends = {base!r}: there is no such file next to it or in the package; "
                        f"{nearest(base, [*beside, *packaged])}")


def scenario_source(given: Scenario | ScenarioTable) -> ScenarioSource:
    """Return the path of a scenario, or the table that was given.

    ScenarioError if it is neither a name, a file nor a table, or the table has a value that TOML cannot have.
    """
    if isinstance(given, ScenarioTable):
        return given
    if isinstance(given, str | Path):
        return Path(given)
    if not isinstance(given, Mapping):
        raise ScenarioError(f"scenario = {shortened(given)}: expected a name, a path or a table")
    try:
        return ScenarioTable(json.dumps(dict(given), default=json_value))
    except ValueError as error:
        raise ScenarioError(f"scenario given as a table: {error}, expected no table in itself") from None


def json_value(value: Any) -> Any:
    """Return a value of a table in a form that JSON has."""
    if isinstance(value, Mapping):
        return dict(value)
    if isinstance(value, Path):
        return str(value)
    if getattr(value, "shape", None) == ():   # of numpy
        return value.item()
    raise ScenarioError(f"scenario given as a table: {shortened(value)}, expected what TOML has: texts, numbers, "
                        "Booleans, lists and tables")


def merged(layers: list[Layer]) -> dict[str, Any]:
    """Merge layers, later ones over earlier ones."""
    table: dict[str, Any] = {}
    for layer in layers:
        table = merge(without_wired(table, layer.table), layer.table)
    return table


def without_wired(base: dict[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table without connections and signals to the inputs that `over` connects.

    Entries of other types are left as they are; they are refused later.
    """
    fed = {f"{name}.{port}" for name, fmu in entries(over.get("fmus")).items()
           for port in entries(entries(fmu).get("inputs"))}
    fed |= {wired_input(pair) for pair in items(over.get("connections"))}
    fed.discard("")
    if not fed or not base:
        return base
    table = dict(base)
    if isinstance(base.get("connections"), list):
        table["connections"] = [pair for pair in base["connections"] if wired_input(pair) not in fed]
    if isinstance(base.get("signals"), list):
        table["signals"] = [{key: value for key, value in signal.items() if key != "rate_to"}
                            if text(signal, "rate_to") in fed else signal for signal in base["signals"]
                            if text(signal, "to") not in fed]
    if isinstance(base.get("fmus"), Mapping):
        table["fmus"] = {name: {**fmu, "inputs": {port: source for port, source in fmu["inputs"].items()
                                                  if f"{name}.{port}" not in fed}}
                         if isinstance(entries(fmu).get("inputs"), Mapping) else fmu
                         for name, fmu in base["fmus"].items()}
    return table


def wired_input(pair: Any) -> str:
    """Return the input of a connection; empty text if the entry is no connection."""
    return pair[1] if isinstance(pair, list) and len(pair) == 2 and isinstance(pair[1], str) else ""


def text(table: Any, key: str) -> str:
    """Return the text at a key of a table; an empty one if there is none."""
    entry = entries(table).get(key)
    return entry if isinstance(entry, str) else ""


def entries(value: Any) -> Mapping[str, Any]:
    """Return the value if it is a table, or else an empty one."""
    return value if isinstance(value, Mapping) else {}


def items(value: Any) -> list[Any]:
    """Return the value if it is a list, or else an empty one."""
    return value if isinstance(value, list) else []


def scenario_table(source: ScenarioSource) -> dict[str, Any]:
    """Return the table of one scenario, with absolute file names. It must not be changed."""
    return placed_once(source, source.text if isinstance(source, ScenarioTable) else toml_text(source))


@lru_cache(maxsize=256)
def placed_once(path: ScenarioSource, text: str) -> dict[str, Any]:
    """Return the table of the text of a file, parsed once: most files are extended by many."""
    table = json.loads(text) if isinstance(path, ScenarioTable) else read_toml(path, text)
    for part in (table, *entries(table.get("variants")).values()):
        if isinstance(part, dict):
            place_files(part, path.parent)
            if not is_packaged(path):
                own_claims(part)
    return table


def is_packaged(path: ScenarioSource) -> bool:
    return isinstance(path, Path) and path.resolve().is_relative_to(PACKAGED.resolve())


def own_claims(table: dict[str, Any]) -> None:
    """Mark the claims in a table of a user's file: no other file that is merged with it makes them the thesis's."""
    for part in (table, entries(table.get("procedure"))):
        for claim in items(part.get("claims")):
            if isinstance(claim, dict):
                claim["own"] = True


def place_files(table: dict[str, Any], folder: Path) -> None:
    """Make the file names in a table absolute: they lie next to their file, not next to one that extends it."""
    if isinstance(table.get("stage"), str):
        table["stage"] = str(folder / table["stage"])
    for entry in (*entries(table.get("fmus")).values(), *items(table.get("signals"))):
        if isinstance(entry, dict) and isinstance(entry.get("file"), str):
            entry["file"] = str(folder / entry["file"])


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Merge two tables deeply: `over` wins, lists are replaced, new keys go to the end.

    For an FMU, `file` replaces `model` or another file, and `model` replaces `file`. The start values of the replaced
    one are then under `inherited`.
    """
    merged = dict(base)
    for one, other in (("model", "file"), ("file", "model")):
        if one in over and other not in over and isinstance(over[one], str):
            if (other in base or one == "file" != base.get(one, over[one]) != over[one]) and "start" in base:
                merged["inherited"] = {**base.get("inherited", {}), **merged.pop("start")}
            merged.pop(other, None)
    for key, value in over.items():
        if isinstance(value, Mapping) and isinstance(merged.get(key), Mapping):
            merged[key] = merge(merged[key], value)
        else:
            merged[key] = value
    return merged


def child(table: Any, key: str | int) -> Any:
    if isinstance(table, Mapping):
        return table.get(key)
    if isinstance(table, list) and isinstance(key, int) and key < len(table):
        return table[key]
    return None


@cache
def packaged_files() -> dict[str, Path]:
    """Return the files of the scenarios that come with the package, by name, in the order of these."""
    return {path.stem: path for stage in PACKAGED_STAGES
            for path in sorted((PACKAGED / stage).glob("*.toml"), key=lambda p: p.stem)}


@cache
def packaged_runs() -> dict[str, str]:
    """Return the names of all packaged runs, one for each variant, with the scenarios that they belong to."""
    return {name: scenario for scenario, path in packaged_files().items() for name in names_of_runs(run_layers(path))}


@lru_cache(maxsize=256)
def scenario_of(run: str) -> str | None:
    """Return the scenario of the package that a run belongs to, by its name; None if there is none."""
    return next((scenario for scenario, path in packaged_files().items()
                 if run.startswith(scenario) and run in names_of_runs(run_layers(path))), None)


def run_layers(path: ScenarioSource) -> list[list[Layer]]:
    """Return the layers of each run of a scenario file: one for each entry of `variants`, or the scenario itself.

    A variant is merged over the scenario; its claims come after the scenario's own. ScenarioError if a file cannot be
    read, extends itself, or its variants are no tables.
    """
    layers = read_layers(path)
    table = merged(layers)
    variants = table.get("variants", {})
    if not isinstance(variants, dict) or not all(isinstance(variant, dict) for variant in variants.values()):
        raise ScenarioError(f"{path}: variants = {variants!r}: expected tables, one for each variant")
    base = [Layer(layer.place, {key: value for key, value in layer.table.items() if key != "variants"})
            for layer in layers]
    runs = []
    for name, variant in variants.items():
        claims = [*table.get("claims", []), *variant.get("claims", [])]
        over = {**variant, "name": f"{table.get('name')}-{name}", "claims": claims}
        runs.append([*base, *extended(path, over)])
    return runs or [base]


def names_of_runs(runs: list[list[Layer]]) -> list[str]:
    return [next((str(layer.table["name"]) for layer in reversed(layers) if "name" in layer.table), "None")
            for layers in runs]

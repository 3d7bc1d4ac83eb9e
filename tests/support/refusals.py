"""What readers of parameters answer to what people write: `python tests/support/refusals.py FMUS`, a folder with FMUs.

It writes tests/maglev/refusals.txt, whose difference shows what becomes of a message.
"""

import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from maglev.analysis.pair import read_values
from maglev.api.studying import varied
from maglev.cosim.fmu import read_description
from maglev.files.errors import MaglevError
from maglev.linear.parameters import block_of
from maglev.many.episode_draws import Draw, Parameters
from maglev.many.study_design import target_values, targets_of
from maglev.runs.carried_experiments import File
from maglev.runs.carried_experiments import given_starts as carried_values
from maglev.runs.preparation import prepare
from maglev.runs.starts import parameter_values
from maglev.scenario.loading import load_plan
from maglev.scenario.settings import start_values
from maglev.user.new_stage import new_stage
from maglev.user.reading import read_own

ANSWERS = Path(__file__).parents[1] / "maglev/refusals.txt"
SCENARIO = "2dof-setpoints"

NAMES = ("v.mass", "v.locked", "v.mas", "v.position", "")
VALUES: tuple[Any, ...] = (7.5, 7, "7.5 kg", "7500 g", "7.5 mm", "7.5 furlong", "7,5 kg", "7.5", "heavy", "", True,
                           "true", -1.0, 1e9, float("nan"), float("inf"), [7.5], None)

SSV = ('<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" '
       'name="set"><ssv:Parameters><ssv:Parameter name="{}"><ssv:Real value="{}"/></ssv:Parameter></ssv:Parameters>'
       "</ssv:ParameterSet>")


def readers(fmus: Path, folder: Path) -> dict[str, Callable[[str, Any], object]]:
    """What reads a value of a parameter of the 2-DOF plant, by who writes it; the answer is what has been read."""
    plant = fmus / "Plant2DOF.fmu"
    description = read_description("plant", plant)
    variables = {variable.name: variable for variable in description.modelVariables}
    plan = load_plan(SCENARIO)
    known = {name: variable for name, variable in variables.items() if variable.causality == "parameter"}
    new_stage(folder / "mine.toml", like="2dof")
    described = (folder / "mine.toml").read_text(encoding="utf-8")

    def of_run(name: str, value: Any) -> object:
        experiment = prepare(plan, fmus, {}, start_values({f"plant.{name}": value}))
        experiment.check()
        return experiment.plan.fmus["plant"].start[name].value

    def of_scenario(name: str, value: Any) -> object:
        table = {"name": "mine", "extends": str(plan.source), "fmus": {"plant": {"start": {name: value}}}}
        experiment = prepare(load_plan(table), fmus, {}, {})
        experiment.check()
        return experiment.plan.fmus["plant"].start[name].value

    def of_study(name: str, value: Any) -> object:
        study = varied(SCENARIO, {f"plant.{name}": [value]}, None, (), None, 0)
        targets = targets_of(study.vary, prepare(plan, fmus, {}, {}), "study")
        return target_values(targets, np.array([[quantity.value for quantity in study.vary[0].quantities]]), "study")

    def of_stage(name: str, value: Any) -> object:
        key = name.partition(".")[2]
        text = described.replace("mass = 4.35 ", f"{key or 'mass.'} = {toml(value)} ", 1)
        (folder / "mine.toml").write_text(text, encoding="utf-8")
        return read_own(folder / "mine.toml").axes[0].mass

    def set_of(name: str, value: Any) -> File:
        (folder / "set.ssv").write_text(SSV.format(name, value), encoding="utf-8")
        return File(str(folder / "set.ssv"), (folder / "set.ssv").read_bytes())

    def of_parameter_set(name: str, value: Any) -> object:
        set_of(name, value)
        experiment = prepare(plan, fmus, {}, parameter_values({"plant": folder / "set.ssv"}, [*plan.fmus]))
        experiment.check()
        return experiment.plan.fmus["plant"].start[name].value

    def of_environment(name: str, value: Any) -> object:
        draw = Parameters("plant", known, {name: value}).draws[name]
        assert isinstance(draw, Draw)
        return draw.values

    return {
        "--set": of_run, "scenario": of_scenario, "study": of_study, "parameter set": of_parameter_set,
        "stage": of_stage,
        "gym": of_environment,
        "linear model": lambda name, value: block_of("Plant2DOF", {name: value}).axes[0].mass,
        "margins of an FMU": lambda name, value: read_values("plant.fmu", {name: value}, description)[name],
        "carried": lambda name, value: carried_values(set_of(name, value), description)[name]}


def toml(value: Any) -> str:
    """A value as TOML has it."""
    return str(value).lower() if isinstance(value, bool | float) or value is None else repr(value).replace("'", '"')


def answers(fmus: Path) -> Iterator[str]:
    """A line for each reader, name and value."""
    with tempfile.TemporaryDirectory() as place:
        for reader, read in readers(fmus, Path(place)).items():
            for name in NAMES:
                for value in VALUES if name == "v.mass" else (7.5, True):
                    try:
                        answer = f"takes {read(name, value)!r}"
                    except MaglevError as error:
                        answer = f"{type(error).__name__}: {error}"
                    except Exception as error:   # none may come through: it would be a bug of ours
                        answer = f"BUG {type(error).__name__}: {error}"
                    answer = re.sub(r"table mine \w+", "table mine", answer.replace(place, "…"))
                    yield f"{reader}, {name or 'no name'} = {value!r}: {answer}"


if __name__ == "__main__":
    ANSWERS.write_text("\n".join(answers(Path(sys.argv[1]))) + "\n", encoding="utf-8")

"""What the FMUs of a run start with: the plan's values, and over these what is asked for."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from maglev.cosim.open import read_description
from maglev.errors import ScenarioError, nearest, option
from maglev.experiment.following import Following, Own, following
from maglev.experiment.ports.replacement import Replacement, given_and_left_out
from maglev.schema.run_plan import RunOutput, RunPlan, StartValue
from maglev.user_controllers.source import is_written


@dataclass
class Starts:
    """Start values of the FMUs of a run, by their names in it."""

    given: dict[str, dict[str, StartValue]]
    taken: dict[str, dict[str, RunOutput]]   # those that other runs come to
    # why others of the plan, `fmu.variable`, are not given to the FMU that takes the place of the plan's
    left_out: dict[str, str]

    @classmethod
    def planned(cls, plan: RunPlan, replaced: Mapping[str, Replacement], put_in: Iterable[str]) -> "Starts":
        """The plan's, as far as they are given to FMUs in the place of others; of these, `put_in` are the user's."""
        starts = cls({name: {**fmu.inherited, **fmu.start} for name, fmu in plan.fmus.items()},
                     {name: dict(fmu.start_from) for name, fmu in plan.fmus.items()}, {})
        for name, replacement in replaced.items():
            starts.given[name], why = given_and_left_out(plan, name, replacement, name in put_in)
            starts.taken[name] = {variable: source for variable, source in starts.taken[name].items()
                                  if variable not in why}
            starts.left_out |= {f"{name}.{variable}": reason for variable, reason in why.items()}
        return starts

    def ask(self, plan: RunPlan, settings: Mapping[str, StartValue]) -> list[str]:
        """Take what is asked for, `fmu.variable`; returns a sentence for each value that another run would come to."""
        overruled = []
        for full, value in settings.items():
            name, _, variable = full.partition(".")
            known_participant(plan, value.origin, name)
            self.give(full, value)
            source = self.taken[name].pop(variable, None)
            if source is not None:
                overruled.append(f"{plan.name}: {full} is as {value.file or option('set')} says, not what "
                                 f"{source.run} comes to")
        return overruled

    def give(self, full: str, value: StartValue) -> None:
        """Give a value, also where the plan's was left out."""
        name, _, variable = full.partition(".")
        self.given[name][variable] = value
        self.left_out.pop(full, None)

    def follow(self, plan: RunPlan, files: Mapping[str, Path], asked: set[str]) -> Following:
        """Let the controller's model follow the plant, but for what is asked for, to which its constants are added."""
        origin = option("model", "plant")

        def own(name: str) -> Own:
            known_participant(plan, origin, name)
            return lambda variable: (float(self.given[name][variable].value) if variable in self.given[name] else
                                     known_start(name, files[name], variable))

        followed = following(plan.rig, own("plant"), own("controller"), asked)
        for full, value in followed.settings({}).items():
            source = self.taken["controller"].get(full.removeprefix("controller."))
            if source is not None:
                raise ScenarioError(f"{origin}: {plan.name} takes {full} from {source.run}, expected only runs that "
                                    "take no constants from others")
            self.give(full, StartValue(value, None, repr(value), origin))
            asked.add(full)
        return followed

    def of(self, plan: RunPlan) -> RunPlan:
        return plan.model_copy(update={"fmus": {
            name: fmu.model_copy(update={"start": self.given[name], "start_from": self.taken[name], "inherited": {}})
            for name, fmu in plan.fmus.items()}})


def known_start(name: str, file: Path, variable: str) -> float | None:
    """Start value that an FMU itself has for a variable; None where it has none, or cannot be read yet."""
    if not (file.is_file() or is_written(file)):
        return None
    text = next((v.start for v in read_description(name, file).modelVariables if v.name == variable), None)
    try:
        return {"true": 1.0, "false": 0.0}.get(str(text)) if text in ("true", "false") else float(str(text))
    except ValueError:
        return None


def known_participant(plan: RunPlan, key: str, name: str) -> None:
    """Refuse an FMU that the plan does not have."""
    if name not in plan.fmus:
        raise ScenarioError(f"{key}: scenario {plan.name} has no FMU {name}, expected one of "
                            f"{', '.join(plan.fmus)}; nearest is {nearest(name, plan.fmus)}")

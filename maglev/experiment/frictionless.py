"""The same experiment on a stage without friction: what if what is assumed of the guides were not there."""

from dataclasses import replace

from maglev.experiment.preparation import Experiment
from maglev.schema.run_plan import StartValue

FRICTION = (".friction.coulomb", ".friction.viscous")   # ends of the names of its parameters, of every axis


def without_friction(experiment: Experiment) -> Experiment:
    """The experiment with all Coulomb and viscous friction of its FMUs at 0; what differs is in its `changes`."""
    found = {full: value for full, value in experiment.parameters().items() if full.endswith(FRICTION) and value}
    plan = experiment.plan
    fmus = {name: fmu.model_copy(update={"start": {
        **fmu.start, **{full.partition(".")[2]: StartValue(0.0, None, 0) for full in found
                        if full.partition(".")[0] == name}}}) for name, fmu in plan.fmus.items()}
    changes = tuple(f"{full} = 0 instead of {value:g}" for full, value in found.items())
    return replace(experiment, plan=plan.model_copy(update={"fmus": fmus, "title": f"{plan.title}, without friction"}),
                   changes=(*experiment.changes, *changes))

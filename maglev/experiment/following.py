"""A controller's model at the masses of the plant: what the option `model` "plant" asks for."""

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from maglev.errors import ScenarioError, option
from maglev.own_fmus import definition
from maglev.parameter import Parameter
from pmlsm.rig import Rig

Own = Callable[[str], float | None]   # what a variable of an FMU is that runs, or None if it has none


@dataclass(frozen=True)
class Following:
    """What a controller's model has at the nominal masses, and the plant's parameters that are about its mass."""

    rig: Rig
    # constants, and of a platform that tilts masses and inertias, by the names of the controller
    model: Mapping[str, float]
    masses: Mapping[str, float]   # parameters of the plant, SI

    def settings(self, changes: Mapping[str, float | bool]) -> dict[str, float]:
        """Values `controller.C1` … at the plant's masses, with other values `plant.y.mass` … of some.

        The constants are accelerations at the nominal masses: the same forces make them, times nominal over present
        mass. What that is, payload included, the plant's own block says.
        """
        plant = definition(f"Plant{self.rig.suffix}")
        block = plant.new_block()
        for variable in plant.variables:
            if variable.name in self.masses:
                value = changes.get(full := f"plant.{variable.name}", self.masses[variable.name])
                setattr(*variable.slot(block), Parameter.of(variable).read(value, full, ScenarioError))
        block.start()
        block.step(0.0, self.rig.sample_time)
        axes = {axis.name: getattr(block, axis.name) for axis in self.rig.axes}
        rows = {constant.name: constant.axis for constant in self.rig.constants}
        return {f"controller.{name}": value * axes[rows[name]].mass_ratio if name in rows else
                axes[name.partition(".")[0]].present_mass for name, value in self.model.items()}


def following(rig: Rig | None, plant: Own, controller: Own, asked: Collection[str]) -> Following:
    """How the model of a run's controller follows its plant; what of it was asked for, `controller.C1`, does not.

    ScenarioError if plant or controller have no such parameters.
    """
    if rig is None:
        raise ScenarioError(f"{option('model', 'plant')}: expected runs of a stage that is described, by whose "
                            "nominal masses it follows")
    variables = definition(f"Plant{rig.suffix}").variables
    axes = {axis.name: f"{axis.name}.{'inertia' if axis.rotation else 'mass'}" for axis in rig.axes}
    masses = [*axes.values(), *(variable.name for variable in variables if variable.name.startswith("payload."))]
    model = [*(constant.name for constant in rig.constants), *(axes.values() if rig.rotations else ())]
    model = [name for name in model if f"controller.{name}" not in asked]
    return Following(rig, values("controller", controller, model), values("plant", plant, masses))


def values(fmu: str, own: Own, names: list[str]) -> dict[str, float]:
    own_values = {name: own(name) for name in names}
    lacking = [name for name, value in own_values.items() if value is None]
    if lacking:
        raise ScenarioError(f"{option('model', 'plant')}: the {fmu} has no {', '.join(lacking)}, expected one with "
                            "masses, or a model, as this project's have")
    return {name: value for name, value in own_values.items() if value is not None}

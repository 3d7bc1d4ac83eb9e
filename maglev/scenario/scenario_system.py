"""A run as a system of FMUs in one file, for the masters of other tools."""

from pathlib import Path
from tempfile import TemporaryDirectory

from maglev.descriptions.own_fmus import definition
from maglev.files.errors import BuildError
from maglev.files.whole_file import whole_files
from maglev.fmi.definition import FmuDefinition, with_inputs
from maglev.fmi.parameter_set import SSV, parameter_set, xml_file
from maglev.fmi.ssp import add_units, all_start_values, write_ssp
from maglev.scenario.catalogue import Kind, build_errors, maker
from maglev.scenario.run_plan import RunPlan


@build_errors()
def build_scenario(plan: RunPlan, folder: Path, kind: Kind) -> list[Path]:
    """Write the FMUs of a run, their connections and start values as `NAME.ssp` into a folder; return its files.

    `NAME.ssv` next to it has the start values, for tools that do not take them from the system. A system has no
    signals: the inputs that they feed are inputs of the system. Nor does it set a parameter between two steps:
    parameters with a signal or a connection are inputs of the FMUs in it. Raises BuildError for an FMU that is not of
    this project, and for start values that are results of other runs; other errors as `maker` does.
    """
    parts = system_parts(plan)
    make = maker(kind)
    start = {name: {variable: value.value for variable, value in fmu.start.items()}
             for name, fmu in plan.fmus.items()}
    values = [value._replace(name=f"{name}.{value.name}") for name, part in parts.items()
              for value in all_start_values(part, start[name]) if value.name in start[name]]
    with TemporaryDirectory() as place, whole_files(folder) as unfinished:
        built = {part.name: make(part, Path(place)) for part in parts.values()}
        system = write_ssp(unfinished / f"{plan.name}.ssp", {name: (part, built[part.name])
                                                             for name, part in parts.items()},
                           list(plan.wires.values()), plan.stop_time, fmi=kind.fmi, start=start)
        table = parameter_set(plan.name, values)
        add_units(table, SSV, {value.unit for value in values if value.unit})
        system.with_suffix(".ssv").write_bytes(xml_file(table))
    return [folder / f"{plan.name}{ending}" for ending in (".ssp", ".ssv")]


def system_parts(plan: RunPlan) -> dict[str, FmuDefinition]:
    """Return the FMUs of a run as parts of its system, by name in the run."""
    led_to = {target for _, target in plan.wires.values()}
    led_to |= {name for signal in plan.signals for name in (signal.to, signal.rate_to) if name}
    parts = {}
    for name, fmu in plan.fmus.items():
        if fmu.model is None:
            raise BuildError(f"{plan.source}: fmus.{name}.file = {fmu.file!r}: an SSP file is written of FMUs of this "
                             "project, expected `model`")
        if fmu.start_from:
            raise BuildError(f"{plan.source}: fmus.{name}.start_from: results of another run are not known when an SSP "
                             "file is written, expected `start`")
        part = definition(fmu.model)
        fed = [variable for variable in part.variables
               if variable.causality == "parameter" and f"{name}.{variable.name}" in led_to]
        for variable in fed:
            if variable.variability == "fixed":
                raise BuildError(f"{plan.source}: something leads to {name}.{variable.name}, a fixed parameter, "
                                 "expected inputs and tunable parameters")
        names = [variable.name for variable in fed]
        parts[name] = with_inputs(part, f"{part.name}_{name}", names) if fed else part
    return parts

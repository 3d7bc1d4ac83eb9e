"""The order in which FMUs are initialised: a measurement begins with what the plant that it measures begins with.

Which initial outputs depend on inputs is in the model structure of an FMU (InitialUnknowns, FMI 2.0.4, section 2.2.8).
"""

from collections.abc import Mapping

from maglev.cosim.fmu import Fmu


def beginning(fmus: Mapping[str, Fmu], sources: Mapping[str, str]) -> dict[str, set[str]]:
    """FMUs in the order of their initialization, with those of them whose initial outputs each is given in it.

    FMUs whose own initial outputs depend on no input are given none, and wait for no others; that of the others has
    themselves, for their signals. Of a circle the FMU that steps first comes last: it samples what the others begin
    with.

    Parameters
    ----------
    fmus : mapping of str to Fmu
        In the order of stepping.
    sources : mapping of str to str
        Source of each fed input, `fmu.variable`; a signal is named as its input.
    """
    waiting = list(fmus)
    feeding = {name: {owner(source) for target, source in sources.items() if owner(target) == name} - {name}
               if begins_with_inputs(fmu) else set() for name, fmu in fmus.items()}
    found: dict[str, set[str]] = {}
    while waiting:
        free = next((name for name in waiting if not feeding[name] & {*waiting}), waiting[len(waiting) > 1])
        waiting.remove(free)
        found[free] = feeding[free] & {*found} | ({free} if begins_with_inputs(fmus[free]) else set())
    return found


def owner(full: str) -> str:
    """FMU of a variable `fmu.variable`."""
    return full.partition(".")[0]


def begins_with_inputs(fmu: Fmu) -> bool:
    """Whether an initial output of an FMU depends on an input; without a list of dependencies, on each."""
    inputs = {variable.valueReference for variable in fmu.description.modelVariables if variable.causality == "input"}
    return any(inputs if unknown.dependencies is None else
               inputs & {known.valueReference for known in unknown.dependencies}
               for unknown in fmu.description.initialUnknowns if unknown.variable.causality == "output")

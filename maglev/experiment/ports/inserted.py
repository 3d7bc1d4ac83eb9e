"""Blocks that a scenario puts into a loop: what follows their outputs, and what they delay by the order of stepping."""

from collections.abc import Callable, Sequence

from maglev.cosim import Order
from maglev.schema.run_plan import RunPlan


def with_generated_references(plan: RunPlan) -> RunPlan:
    """Plan whose axes have as their references the outputs that feed these: an input that is wired is not recorded."""
    sources = {target: source for source, target in plan.wires.values()}
    generated = {name: axis.model_copy(update={"reference": sources[axis.reference]})
                 for name, axis in plan.axes.items() if axis.reference in sources}
    return plan.model_copy(update={"axes": {**plan.axes, **generated}}) if generated else plan


def needless_delays(plan: RunPlan, order: Order, samples: Callable[[str], bool]) -> list[str]:
    """Sentences about FMUs that are stepped after one that they feed, where another order would have no such delay.

    In a loop one connection has to run from an FMU to one that is stepped before it. Nothing is late of what gives at
    the end of a step what it has come to, as a plant does: it is about FMUs that compute from samples, by their names.
    """
    if order != "sequential":
        return []   # every connection is delayed
    names = list(plan.fmus)
    wires = {(source.partition(".")[0], target.partition(".")[0]) for source, target in plan.wires.values()}
    wires = {(source, target) for source, target in wires if source in plan.fmus and target in plan.fmus}
    delays = []
    for source, target in sorted(wires):
        if names.index(source) <= names.index(target):
            continue
        others = [name for name in names if name != source]
        others.insert(others.index(target), source)
        if delayed(wires, others) < delayed(wires, names) and samples(source):
            delays.append(f"{source} is stepped after {target}, which gets what it computes a step of {plan.step:g} s "
                          f"late; before = \"{target}\" under [fmus.{source}] has it stepped in time")
    return delays


def delayed(wires: set[tuple[str, str]], order: Sequence[str]) -> int:
    """Number of pairs of FMUs of which one feeds the other and is stepped after it."""
    return sum(order.index(source) > order.index(target) for source, target in wires)

"""Whether a stage can run at all: what cannot says why, with numbers, before anything is built."""

from operator import attrgetter
from pathlib import Path

from maglev.errors import LinearModelError, RigError
from maglev.linear.equilibrium import equilibrium
from maglev.linear.loop import linearise_loop
from maglev.linear.parameters import linear_names
from maglev.own_stage.adoption import know_stage
from maglev.own_stage.design import SLOWEST_SAMPLING, strongest, unstable_rate
from maglev.parameter import Parameter
from maglev.stages import STAGES
from pmlsm.rig import Rig, RigAxis


def flyable(path: str | Path) -> Rig:
    """Read a description and check that its stage can run.

    RigError, ScenarioError if it is no description; if stops are outside the field's range, no current below the limits
    holds the mover at its start, thrust does not overcome bias and friction, sampling is too slow for the unstable
    pole, or the loop of a regulator is unstable; with the numbers.
    """
    rig = know_stage(path)
    try:
        require_field(rig)
        require_within_ranges(rig)
        start = {axis.name: axis.start for axis in rig.axes}
        for kind in ("Plant", "Regulator"):
            equilibrium(f"{kind}{rig.suffix}", start)
        for axis in rig.horizontal:
            require_thrust(rig, axis)
        rate = max(unstable_rate(rig, axis.name) for axis in (rig.vertical, *rig.rotations))
        if rate * rig.sample_time > SLOWEST_SAMPLING:
            raise RigError(f"sample_time: {1e3 * rig.sample_time:g} ms, expected at most "
                           f"{1e3 * SLOWEST_SAMPLING / rate:.3g} ms: without control the mover leaves its start with "
                           f"exp({rate:.3g} t/s)")
        loop = linearise_loop(f"Plant{rig.suffix}", f"Regulator{rig.suffix}", start)
        if not loop.stable:
            raise RigError(f"design: with these gains the loop at the start grows with a pole of magnitude "
                           f"{max(abs(loop.poles)):.4g} per sample of {1e3 * rig.sample_time:g} ms, expected all below "
                           f"1: other gains or poles, or a shorter sample_time; without control the mover leaves with "
                           f"exp({rate:.3g} t/s)")
    except (RigError, LinearModelError) as error:
        raise RigError(f"{path}: {error}") from None
    return rig


def require_field(rig: Rig) -> None:
    """Refuse stops between which the field of the magnets is not known."""
    stop, fields = rig.gap_stop, [rig.motor(motor).field for motor in rig.motors]
    lower, upper = max(field.lower for field in fields), min(field.upper for field in fields)
    if not lower <= stop.lower < stop.upper <= upper:
        place = "motor_stop" if rig.rotations else f"axes.{rig.vertical.name}.stop"
        raise RigError(f"{place}: from {1e3 * stop.lower:g} to {1e3 * stop.upper:g} mm, expected "
                       f"within {1e3 * lower:g}…{1e3 * upper:g} mm, where the field is known")


def require_within_ranges(rig: Rig) -> None:
    """Refuse what no FMU takes as a start value."""
    for definition in map(STAGES.definition, linear_names(rig)):
        block = definition.new_block()
        for variable in definition.variables:
            if variable.causality == "parameter" and not variable.boolean:
                Parameter.of(variable).read(attrgetter(variable.place)(block), f"{definition.name}: {variable.name}",
                                            RigError)


def require_thrust(rig: Rig, axis: RigAxis) -> None:
    """Refuse motors that cannot overcome what holds their axis."""
    needed, given = abs(axis.bias) + axis.friction.coulomb / axis.mass, strongest(rig, axis.name)
    if given <= needed:
        raise RigError(f"axes.{axis.name}: its motors give {axis.mass * given:.3g} N at their limit and the start gap, "
                       f"bias and friction take {axis.mass * needed:.3g} N, expected more thrust")

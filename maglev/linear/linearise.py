"""`linearise`: the linear model of a plant or a controller."""

from collections.abc import Mapping
from typing import Any, Literal, get_args

from maglev.files.errors import LinearModelError, one_of
from maglev.fmi.parameter import Parameter
from maglev.linear.controller_model import linear_controller, linear_measurement
from maglev.linear.equilibrium import check_limit, equilibrium_of, read_positions
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.parameters import Quantity, block_of, controllers, linear_names, linear_stage, measurements
from maglev.linear.plant_model import linear_plant

Currents = Literal["dq", "phases"]


def linearise(name: str, at: Mapping[str, Quantity] | Equilibrium, *, currents: Currents = "dq",
              amplifier: bool = True, hold: Quantity | None = None, forces: bool = False,
              parameters: Mapping[str, Quantity | bool] | None = None) -> LinearModel:
    """Linearise a plant, a controller or a measurement about an equilibrium.

    The model is exact: its matrices are derivatives of the block's computations, not differences.

    In the model of a plant: motors (4.3), (5.3) with the modulation of the attraction, gravity, bias (through the
    equilibrium), mass, viscous friction, ripple, flexible modes, the lag of the amplifiers. Terms that are not smooth
    are left out: Coulomb friction with its presliding spring, end stops, the limits of the amplifiers, the rounding of
    the encoders. So is the roughness of the guides, whose slope is a random number at each place. With friction on,
    motions that are short next to its presliding displacement meet its spring, which this model does not have.

    The model of a measurement has its delay and the slope of its periodic error. Offset, drift and noise are added to
    its outputs. Jitter and lost samples raise an error. The model of a controller is sampled at its sample time:
    observer, internal model or integral and pre-filter, and its law at the operating point. Left out: the current limit
    with its anti-windup, the safety trip, and the compensation of Coulomb friction. A scheduled law has the gains of
    the region that the gap lies in, an adaptive one the constants of its parameters: at rest none of them moves.

    Parameters
    ----------
    name : str
        A plant such as "Plant3DOF", a controller such as "Regulator3DOF", "AdaptiveRegulator2DOF", "PID3DOF", or
        "Measurement3DOF".
    at : mapping of str to float or str, or Equilibrium
        Position of each axis, m or rad or text such as "25 mm". The air gap, `v` or `y`, is required, the others are
        0 by default. A controller alone gets the currents of its own model; with the equilibrium of a plant, as in
        `linearise("Regulator3DOF", plant.equilibrium)`, it is linearised where that plant rests.
    currents : {"dq", "phases"}
        Inputs of a plant, outputs of a controller: direct and quadrature currents or phase currents. Those in d and q
        are commutated with the true displacement at every moment, or, where they are held, with that at the sample.
    amplifier : bool
        True if the plant has the first-order lag of its amplifiers.
    hold : float or str, optional
        Sample time, s or text such as "0.2 ms", of a plant whose phase currents are held between the samples; exact.
        Without it a plant is continuous in time.
    forces : bool
        True if the external forces, or torques, on the axes are inputs of the plant, too.
    parameters : mapping, optional
        Parameters of the FMU that differ from their start values, such as {"y.mass": 7.2, "C3": 330.0}.

    Returns
    -------
    LinearModel
        Of a plant: states are positions, velocities, with lag delivered i_d, i_q of each motor, and deflection and rate
        of each flexible mode. Its outputs are positions, and on a tilting platform the gaps at the motors, which its
        controllers measure; next to these the encoders' readings, where they see a mode. Of a controller: inputs are
        reference and rate of each axis and the measurements, outputs the commanded currents. Of a measurement: inputs
        are the encoders' readings, outputs the controller's measurements, states the samples in between.

    Raises
    ------
    LinearModelError
        If there is no linear model of that name, or no such axis, parameter or equilibrium.

    Examples
    --------
    >>> plant = linearise("Plant3DOF", {"y": "25 mm"}, amplifier=False)
    >>> plant.states
    ('y.position', 'x.position', 'z.position', 'y.velocity', 'x.velocity', 'z.velocity')
    >>> print(f"{max(plant.poles.real):.1f} /s")
    38.7 /s
    """
    stage = linear_stage(name)
    if currents not in get_args(Currents):
        raise LinearModelError(f"currents = {currents!r}, expected {one_of(str(currents), get_args(Currents))}")
    block = block_of(name, parameters or {})
    if hold is not None and name not in linear_names(stage)[:1]:
        raise LinearModelError(f"{name}: hold = {hold}: not possible, it is sampled at its sample_time")
    if name in measurements():
        return linear_measurement(name, stage, block, resting(name, block, at))
    if name in controllers():
        return linear_controller(name, stage, block, resting(name, block, at), currents == "phases")
    return linear_plant(name, stage, block, resting(name, block, at), currents == "phases", amplifier, forces,
                        None if hold is None else Parameter("s").read(hold, f"{name}: hold", LinearModelError))


def resting(name: str, block: Any, at: Mapping[str, Quantity] | Equilibrium) -> Equilibrium:
    """Equilibrium of a block: found at given positions, or given and checked."""
    if not isinstance(at, Equilibrium):
        if name in measurements():   # where the plant rests that is as it starts
            plant = linear_names(linear_stage(name))[0]
            return equilibrium_of(plant, block_of(plant, {}), read_positions(name, at))
        return equilibrium_of(name, block, read_positions(name, at))
    if at.motors != linear_stage(name).motor_names:
        raise LinearModelError(f"{name} at {at}: expected an equilibrium of its own stage, with "
                               f"{', '.join(linear_stage(name).motor_names)}")
    if name in controllers():
        check_limit(f"{name} at {at}", block, at)
    return at

"""FMUs for model exchange alone in a co-simulation: SUNDIALS' CVODE, as fmpy brings it along, makes their steps."""

from collections.abc import Callable
from ctypes import c_double
from typing import Any

from fmpy.fmi1 import FMICallException
from fmpy.model_description import CoSimulation, ModelDescription
from fmpy.sundials import CVodeSolver

TOLERANCE = 1e-8   # relative, and of the nominal value of each state
ENDED = 1e-9       # of a step, by which rounding may miss its end
FAILED = 3         # fmi2Error, fmi3Error
MOST_EVENTS = 1000   # at one instant, after which an FMU is not believed to come to an end

ENDS = "the FMU asks for the end of the simulation"


class SolverInterface(CoSimulation):  # type: ignore[misc]   # fmpy has no types
    """What a co-simulation sees of an FMU for model exchange: any step, since a solver makes it."""


def with_solver(description: ModelDescription) -> None:
    """Give the description of an FMU for model exchange alone what one for co-simulation has."""
    exchange = description.modelExchange
    description.coSimulation = SolverInterface(
        modelIdentifier=exchange.modelIdentifier, canHandleVariableCommunicationStepSize=True,
        canGetAndSetFMUstate=exchange.canGetAndSetFMUstate)


class NoInput:
    """Inputs are held over a step."""

    def apply(self, *_: object) -> None:
        """Nothing changes."""


class Integration:
    """Steps of an instance for model exchange, called as fmi2DoStep; `update` takes in an event, `say` why one fails.

    Between two steps it is in event mode: inputs that are set, and outputs that are read, are those of an event.
    """

    def __init__(self, instance: Any, description: ModelDescription, update: Callable[[], tuple[Any, ...]],
                 say: Callable[[str], None]):
        self.instance = instance
        self.description = description
        self.update = update
        self.say = say
        self.solver: Any = None
        self.fresh = True      # the solver is to start anew
        self.broken: Exception | None = None   # what a call from within CVODE has raised

    def __call__(self, _handle: object, time: c_double, step: c_double, _no_set_before: object) -> int:
        instance = self.instance
        now, end = time.value, time.value + step.value
        self.broken = None
        try:
            following = self.events()
            while end - now > ENDED * step.value:
                found, _, now = self.solver_at(now).step(now, min(end, max(following, now + ENDED * step.value)))
                if self.broken is not None:
                    raise self.broken
                instance.setTime(now)
                asked = ended = False
                if self.description.modelExchange.needsCompletedIntegratorStep:
                    asked, ended = instance.completedIntegratorStep()
                if ended:
                    raise RuntimeError(ENDS)
                at_end = end - now <= ENDED * step.value
                if found or asked or at_end or following - now <= ENDED * step.value:
                    instance.enterEventMode()
                    if not at_end:
                        following = self.events()
            self.settled()
        except FMICallException as error:
            return int(error.status)
        except RuntimeError as error:   # also of CVODE, which has given up
            self.say(str(error))
            return FAILED
        return 0

    def settled(self) -> float:
        """Take in the event at which the instance is; when the next one is due, s, if the instance knows."""
        for _ in range(MOST_EVENTS):
            more, ended, _, _, defined, next_time = self.update()
            if ended:
                raise RuntimeError(ENDS)
            if not more:
                return next_time if defined else float("inf")
        raise RuntimeError(f"after {MOST_EVENTS} events at one instant the FMU asks for another")

    def events(self) -> float:
        """The same, and go on between events; the solver starts anew."""
        due = self.settled()
        self.instance.enterContinuousTimeMode()
        self.fresh = True
        return due

    def solver_at(self, time: float) -> Any:
        """The solver, which starts anew after an event at a time (s)."""
        if self.solver is None:
            count, instance = self.description.numberOfContinuousStates, self.instance
            rates = getattr(instance, "getContinuousStateDerivatives", None) or instance.getDerivatives
            self.solver = CVodeSolver(
                nx=count, nz=self.description.numberOfEventIndicators, get_x=instance.getContinuousStates,
                set_x=self.kept(instance.setContinuousStates), get_dx=self.kept(rates),
                get_z=self.kept(instance.getEventIndicators), get_nominals=instance.getNominalsOfContinuousStates,
                set_time=self.kept(instance.setTime), input=NoInput(), startTime=time, relativeTolerance=TOLERANCE,
                maxNumSteps=100000)
        elif self.fresh:
            self.solver.reset(time)
        self.fresh = False
        return self.solver

    def kept(self, call: Callable[..., Any]) -> Callable[..., None]:
        """A call that CVODE makes: what it raises is raised after it."""
        def made(*arguments: Any) -> None:
            try:
                call(*arguments)
            except FMICallException as error:
                self.broken = error
        return made

"""FMUs for model exchange alone in a co-simulation: SUNDIALS' CVODE, as fmpy brings it along, makes their steps."""

from collections.abc import Callable
from ctypes import c_double
from math import inf, isnan
from types import SimpleNamespace
from typing import Any

from fmpy.fmi1 import FMICallException
from fmpy.model_description import CoSimulation, ModelDescription
from fmpy.sundials import CVodeSolver

from maglev.files.errors import FmuError

TOLERANCE = 1e-8   # relative, and of the nominal value of each state
ENDED = 1e-9       # of a step, by which rounding may miss its end
FAILED = 3         # fmi2Error, fmi3Error
MOST_EVENTS = 1000   # at one instant, after which an FMU is not believed to come to an end
PAST = 1e-9          # of a time, by which rounding may put an event before it
LEAST_NOMINAL, MOST_NOMINAL = 1e-60, 1e60   # of a state in SI: beyond these a tolerance makes no sense

ENDS = "the FMU asks for the end of the simulation"
AGAIN = f"after {MOST_EVENTS} events at one instant the FMU asks for another"


def settled(update: Callable[[], tuple[Any, ...]], now: float) -> float:
    """Take in the event at which an instance is, at a time (s); when the next one is due, s, infinite if none is.

    RuntimeError where it asks for the end, comes to none, or gives a time that is past.
    """
    for _ in range(MOST_EVENTS):
        more, ended, _, _, defined, next_time = update()
        if ended:
            raise RuntimeError(ENDS)
        if not more:
            if defined and not next_time >= now - PAST * max(1.0, abs(now)):
                raise RuntimeError(f"next event time = {next_time:.9g} s, expected one that is not before {now:.9g} s")
            return float(next_time) if defined else inf
    raise RuntimeError(AGAIN)


class SolverInterface(CoSimulation):  # type: ignore[misc]   # fmpy has no types
    """Co-simulation interface of an FMU for model exchange: any step size, since a solver makes the steps."""


def with_solver(description: ModelDescription) -> None:
    """Give the description of an FMU for model exchange alone what one for co-simulation has."""
    exchange = description.modelExchange
    description.coSimulation = SolverInterface(
        modelIdentifier=exchange.modelIdentifier, canHandleVariableCommunicationStepSize=True,
        canGetAndSetFMUstate=exchange.canGetAndSetFMUstate)


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
        self.fresh = True      # the solver is to start again
        self.broken: Exception | None = None   # error of a call from within CVODE

    def __call__(self, _handle: object, time: c_double, step: c_double, _no_set_before: object) -> int:
        instance = self.instance
        now, end = time.value, time.value + step.value
        self.broken, instants = None, 0
        try:
            following = self.events(now)
            while end - now > ENDED * step.value:
                instants = instants + 1 if following - now <= ENDED * step.value else 0
                if instants > MOST_EVENTS:
                    raise RuntimeError(AGAIN)
                event, _, now = self.solver_at(now).step(now, min(end, max(following, now + ENDED * step.value)))
                if self.broken is not None:
                    raise self.broken
                instance.setTime(now)
                asked = ended = False
                if self.description.modelExchange.needsCompletedIntegratorStep:
                    asked, ended = instance.completedIntegratorStep()
                if ended:
                    raise RuntimeError(ENDS)
                at_end = end - now <= ENDED * step.value
                if event or asked or at_end or following - now <= ENDED * step.value:
                    instance.enterEventMode()
                    if not at_end:
                        following = self.events(now)
            settled(self.update, now)
        except FMICallException as error:
            return int(error.status)
        except RuntimeError as error:   # also of CVODE, which has given up
            self.say(str(error))
            return FAILED
        return 0

    def events(self, now: float) -> float:
        """Take in the event at a time (s), and return the time of the next one, s; the solver starts again."""
        due = settled(self.update, now)
        self.instance.enterContinuousTimeMode()
        self.fresh = True
        return due

    def solver_at(self, time: float) -> Any:
        """The solver, which starts again after an event at a time (s)."""
        if self.solver is None:
            instance, states = self.instance, self.description.numberOfContinuousStates
            # An instance of FMI 3.0 tells them, too.
            for what, described in (("ContinuousStates", states),
                                    ("EventIndicators", self.description.numberOfEventIndicators)):
                count = getattr(instance, f"getNumberOf{what}", None)
                if count is not None and (given := count()) != described:
                    raise RuntimeError(f"fmi3GetNumberOf{what} gives {given}, expected {described}, as in its "
                                       "description")
            nominals = self.checked(
                instance.getNominalsOfContinuousStates, "nominal value", lambda value: "" if LEAST_NOMINAL < value
                < MOST_NOMINAL else f"one between {LEAST_NOMINAL:g} and {MOST_NOMINAL:g}")
            indicators = self.checked(
                instance.getEventIndicators, "event indicator", lambda value: "a number" if isnan(value) else "")
            if states:   # a solver that is not made to its end writes a traceback
                nominals((c_double * states)(), states)
            rates = getattr(instance, "getContinuousStateDerivatives", None) or instance.getDerivatives
            self.solver = CVodeSolver(
                nx=states, nz=self.description.numberOfEventIndicators, get_x=instance.getContinuousStates,
                set_x=self.kept(instance.setContinuousStates),
                get_dx=self.kept(rates),   # of a state that it tries; it takes a smaller step from one without a rate
                get_z=self.kept(indicators), get_nominals=nominals, set_time=self.kept(instance.setTime),
                input=SimpleNamespace(apply=lambda *_: None),   # inputs are held over a step
                startTime=time, relativeTolerance=TOLERANCE, maxNumSteps=100000)
        elif self.fresh:
            self.solver.reset(time)
        self.fresh = False
        return self.solver

    def checked(self, call: Callable[..., Any], what: str,
                expected: Callable[[float], str]) -> Callable[[Any, int], None]:
        """A call that gets numbers; RuntimeError if one is not as expected."""
        def made(values: Any, count: int) -> None:
            call(values, count)
            for k in range(count):
                if wrong := expected(values[k]):
                    raise RuntimeError(f"{what} {k + 1} = {values[k]:.9g}{self.state(what, k)}, expected {wrong}")
        return made

    def state(self, what: str, number: int) -> str:
        """Name the state that a message is about, if the description tells."""
        unknowns = self.description.derivatives
        if "event" in what or number >= len(unknowns) or unknowns[number].variable.derivative is None:
            return ""
        return f" of {unknowns[number].variable.derivative.name}"

    def kept(self, call: Callable[..., Any]) -> Callable[..., None]:
        """Wrap a call that CVODE makes: its errors are raised after it."""
        def made(*arguments: Any) -> None:
            try:
                call(*arguments)
            except (FMICallException, FmuError, RuntimeError) as error:
                self.broken = self.broken or error
        return made

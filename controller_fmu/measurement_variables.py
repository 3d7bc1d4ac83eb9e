"""Variables of a measurement, between encoders and controller, encoder by encoder."""

from collections.abc import Iterator
from dataclasses import replace

from controller_fmu.sampling_instant import LATEST, NO_SEED, STEP_MISFIT, TOO_LATE
from controller_fmu.variables import gap_inputs, measured_axis
from maglev.fmi.definition import Variable, parameter, real_output, switch
from pmlsm.stage_description import StageDescription

NONE = "assumed: none"

REFUSALS = {
    STEP_MISFIT: "communication step = {step} s, expected one that divides the measurement's sample_time = "
                 "{sample_time} s into a whole number of steps and does not step over a sample",
    TOO_LATE: f"delay = {{delay}} s, jitter = {{jitter}} s, expected at most {LATEST} samples of {{sample_time}} s "
              "together",
    NO_SEED: "seed = {seed}, expected a whole number"}


def encoders(stage: StageDescription) -> Iterator[tuple[str, str, Variable]]:
    """Yield for each encoder its owner, its name in the plant, and the controller's input that it feeds."""
    for axis in stage.measured:
        yield axis.name, f"{axis.name}.encoder", measured_axis(axis)
    for motor, gap in zip(stage.motor_names, gap_inputs(stage), strict=False):
        yield motor, f"{motor}.gap_encoder", gap


def measurement_variables(stage: StageDescription) -> tuple[Variable, ...]:
    """Variables of a measurement: inputs, outputs, then parameters."""
    measured = list(encoders(stage))
    inputs = [replace(of, name=encoder, path=f"encoders[{number}].encoder",
                      description=f"{of.description.replace('measured ', '', 1)}, as the encoder reads it")
              for number, (_, encoder, of) in enumerate(measured)]
    outputs = [replace(real_output(of.name, of.unit, f"{of.description}, as the controller receives it",
                                   of.nominal or 1.0, discrete=True, depends_on=(encoder,), starts_from=(encoder,)),
                       path=f"encoders[{number}].measured") for number, (_, encoder, of) in enumerate(measured)]
    return (*inputs, *outputs,
            parameter("seed", "", "seed of the random noise, a whole number", "assumed", 0.0, 4294967295.0, 1.0,
                      fixed=True),
            parameter("sample_time", "s", "sample time of the controller; the communication step must divide it",
                      stage.source("sample_time"), 1e-6, 1.0, 1e-3, fixed=True),
            *(replace(parameter(name, "s", f"{text}; delay + jitter at most {LATEST} samples", NONE, 0.0, 1.0, 1e-3,
                                fixed=True), path=f"instant.{name}")
              for name, text in (("delay", "age of a measurement when the controller receives it"),
                                 ("jitter", "random extra age, uniform between 0 and jitter"))),
            *(replace(v, path=v.name.replace(owner, f"encoders[{number}]", 1))
              for number, (owner, _, _) in enumerate(measured) for v in encoder_parameters(owner)))


def encoder_parameters(owner: str) -> tuple[Variable, ...]:
    """Parameters of the errors of one encoder."""
    return (parameter(f"{owner}.noise", "m", "standard deviation of white Gaussian noise", NONE, 0.0, 1.0, 1e-6),
            parameter(f"{owner}.interpolation.amplitude", "m", "amplitude of the position-periodic interpolation error",
                      NONE, 0.0, 1.0, 1e-6),
            parameter(f"{owner}.interpolation.period", "m", "period of the interpolation error; 0 = no error", NONE,
                      0.0, 1.0, 1e-5),
            parameter(f"{owner}.offset", "m", "constant error; a change during a run is a jump", NONE, -1.0, 1.0, 1e-5),
            parameter(f"{owner}.drift", "m/s", "rate at which the error grows", NONE, -1.0, 1.0, 1e-6),
            parameter(f"{owner}.lost", "", "probability that a sample is lost and the last measurement stays", NONE,
                      0.0, 1.0, 0.01),
            switch(f"{owner}.frozen", "true to keep the measurement constant", "off"))

"""The names that other people's files depend on: SSP files, baselines, controllers and plants with the same ports."""

import pytest

from maglev.descriptions.own_fmus import DEFINITIONS, definition

STAGES = {"2DOF": (("v", "h"), ("motor",), 4), "3DOF": (("y", "x", "z"), ("alpha", "beta"), 5)}
# With those that have other ports: a platform that tilts, whose gap and tilts are measured at its motors.
CONTROLLED = {**STAGES, "5DOF": (("y", "x", "z", "roll", "pitch"), ("alpha1", "alpha2", "beta1", "beta2"), 5)}
PLANT_AXIS = ("mass", "bias", "friction.coulomb", "friction.presliding", "friction.viscous",
              "friction.variation", "friction.correlation", "stop.lower", "stop.upper", "stop.stiffness",
              "stop.damping", "ripple.amplitude", "ripple.period",
              "roughness.rms", "roughness.correlation",
              "position_start", "locked", "mode.frequency", "mode.damping", "mode.mass_share", "mode.encoder_share")
SUPPLIED = ("i_a", "i_b", "i_c", "i_d", "i_q", "voltage", "winding.rise", "saturated")


def each(owners: tuple[str, ...], *names: str) -> set[str]:
    """Every name of every owner."""
    return {f"{owner}.{name}" for owner in owners for name in names}


def ports(fmu: str, causality: str) -> set[str]:
    """Names of variables; the geometry of the motors, which all have, is not among them."""
    return {v.name for v in definition(fmu).variables if v.causality == causality
            and not v.name.startswith("geometry.")}


def measured(stage: str) -> set[str]:
    """Measurements of all axes."""
    axes, motors, _ = CONTROLLED[stage]
    return each(motors, "gap_measured") | {"x.measured", "z.measured"} if "roll" in axes else each(axes, "measured")


def model(stage: str, inertias: bool) -> set[str]:
    """Parameters of a controller's platform, if it tilts."""
    axes, motors, _ = CONTROLLED[stage]
    if "roll" not in axes:
        return set()
    of_axes = each(axes[:3], "mass") | each(axes[3:], "inertia") | {"trip_tilt"} if inertias else set()
    return of_axes | each(motors, "x", "z") | {"height"}


def supplies(motors: tuple[str, ...]) -> set[str]:
    """Parameters of amplifiers, windings and magnets."""
    return ({"bus_voltage", "magnet_rise"} | each(motors, "phase_a.open", "phase_b.open", "phase_c.open")
            | each(tuple(f"{m}.amplifier" for m in motors), "peak", "continuous", "thermal_time", "lag", "off", "stuck")
            | each(tuple(f"{m}.winding" for m in motors), "resistance", "inductance", "thermal_resistance",
                   "thermal_time"))


@pytest.mark.parametrize("stage", STAGES)
def test_plant_ports(stage: str) -> None:
    axes, motors, constants = STAGES[stage]
    name = f"Plant{stage}"
    assert ports(name, "input") == (each(motors, "i_a_cmd", "i_b_cmd", "i_c_cmd")
                                    | each(axes, "force", "floor_acceleration"))
    assert ports(name, "output") == (each(axes, "encoder", "position", "velocity") | {"at_stop"}
                                     | each(motors, *SUPPLIED))
    assert ports(name, "parameter") == (
        {f"C{i}" for i in range(1, constants + 1)} | {"attraction_modulation", "guide_seed", "encoder.resolution"}
        | each(axes, *PLANT_AXIS)
        | supplies(motors))


def test_ports_of_a_stage_that_tilts() -> None:
    axes, motors, name = ("y", "x", "z", "roll", "pitch"), ("alpha1", "alpha2", "beta1", "beta2"), "Plant5DOF"
    assert ports(name, "input") == (each(motors, "i_a_cmd", "i_b_cmd", "i_c_cmd") | each(axes[3:], "torque")
                                    | each(axes[:3], "force", "floor_acceleration"))
    assert ports(name, "output") == (
        each(axes, "position", "velocity") | {"x.encoder", "z.encoder", "yaw_moment", "at_stop"}
        | each(motors, "gap", "gap_encoder", *SUPPLIED))
    of_stops = ("stop.lower", "stop.upper", "stop.stiffness", "stop.damping")
    assert ports(name, "parameter") == (
        {f"C{i}" for i in range(1, 6)} | {"attraction_modulation", "guide_seed", "encoder.resolution", "height"}
        | each(("payload",), "mass", "x", "z") | each(axes[3:], "inertia", "guide.stiffness", "guide.play")
        | each(axes[:3], "mass") | each(axes, *(set(PLANT_AXIS) - {"mass", *of_stops})) | each(("x", "z"), *of_stops)
        | each(motors, "x", "z", *of_stops)
        | supplies(motors))


@pytest.mark.parametrize("name", [name for name in DEFINITIONS
                                  if not name.startswith(("Plant", "Estimator", "Measurement", "Commutation",
                                                           "ClosedLoop", "Adaptive"))])
def test_controller_ports(name: str) -> None:
    stage = name[-4:]
    axes, motors, constants = CONTROLLED[stage]
    assert ports(name, "input") == each(axes, "reference", "reference_rate") | measured(stage)
    assert ports(name, "output") == (each(motors, "i_a_cmd", "i_b_cmd", "i_c_cmd", "i_d_cmd", "i_q_cmd")
                                     | each(axes, "error") | {"saturated", "feasible", "tripped"})
    of_all = ({f"C{i}" for i in range(1, constants + 1)} | {"sample_time", "current_limit", "antiwindup", "trip_error"}
              | {"observer.time1", "observer.time2"})
    if name.startswith("PID"):
        own = {"setpoint"} | each(axes, "kp", "ki", "kd", "prefilter", "pole", "pair_real", "pair_imaginary")
    else:
        own = {"omega0"} | each(axes, "k1", "k2", "k3", "k4", "k5", "ec1", "ec2", "ec3", "friction_compensation")
        own |= {"setpoint", "bumpless"} if name.startswith("Linear") else set()
    assert ports(name, "parameter") == of_all | own | model(stage, True)


@pytest.mark.parametrize("stage", CONTROLLED)
def test_commutation_ports(stage: str) -> None:
    axes, motors, _ = CONTROLLED[stage]
    name = f"Commutation{stage}"
    assert ports(name, "input") == (measured(stage) - {f"{axes[0]}.measured"}
                                    | each(motors, "i_d_reference", "i_q_reference"))
    assert ports(name, "output") == each(motors, "i_a_cmd", "i_b_cmd", "i_c_cmd", "i_d_cmd", "i_q_cmd") | {"saturated"}
    assert ports(name, "parameter") == {"sample_time", "current_limit"} | model(stage, False)


@pytest.mark.parametrize("stage", CONTROLLED)
def test_estimator_ports(stage: str) -> None:
    axes, motors, constants = CONTROLLED[stage]
    name, estimates = f"Estimator{stage}", tuple(f"C{i}" for i in range(1, constants + 1))
    assert ports(name, "input") == measured(stage) | each(motors, "i_d", "i_q")
    assert ports(name, "output") == ({*estimates} | {f"{c}_converged" for c in estimates}
                                     | each(axes[:3], "velocity", "residual"))
    assert ports(name, "parameter") == (
        {f"{c}_{what}" for c in estimates for what in ("start", "weight")}
        | {"epsilon", "gamma", "forgetting", "matched_filter", "held", "sample_time"}
        | each(("observer",), "time1", "time2") | each(("convergence",), "tolerance", "time")
        | model(stage, False) - {"height"})


@pytest.mark.parametrize("stage", CONTROLLED)
def test_adaptive_ports(stage: str) -> None:
    """Those of the regulator, whose constants are fixed here, and what is adapted: all but the last constant."""
    name, constants = f"AdaptiveRegulator{stage}", tuple(f"C{i}" for i in range(1, CONTROLLED[stage][2] + 1))
    adapted = constants[:-1]
    assert ports(name, "input") == ports(f"Regulator{stage}", "input")
    assert ports(name, "output") == ports(f"Regulator{stage}", "output") | {"adaptation.frozen"} | {
        f"{what}.{each}" for what in ("adapted", "estimated") for each in adapted} | {
        f"{each}_converged" for each in adapted}
    stops = {"2DOF": ("v", "h"), "3DOF": ("y", "x", "z"), "5DOF": ("gap", "x", "z")}[stage]
    assert ports(name, "parameter") == (
        ports(f"Regulator{stage}", "parameter") | {f"{each}_weight" for each in adapted}
        | {"epsilon", "gamma", "forgetting", "matched_filter", "convergence.tolerance", "convergence.time"}
        | each(("adaptation",), "active", "range", "time", "pause") | each(stops, "travel.lower", "travel.upper"))
    assert {v.variability for v in definition(name).variables if v.name in constants} == {"fixed"}


@pytest.mark.parametrize("stage", CONTROLLED)
def test_measurement_ports(stage: str) -> None:
    """Outputs of a plant for inputs of a controller."""
    outputs = measured(stage)
    encoders = {name.replace("measured", "encoder") for name in outputs}
    assert ports(f"Measurement{stage}", "input") == encoders < ports(f"Plant{stage}", "output")
    assert ports(f"Measurement{stage}", "output") == outputs < ports(f"Regulator{stage}", "input")
    assert ports(f"Measurement{stage}", "parameter") == {"seed", "sample_time", "delay", "jitter"} | each(
        tuple(name.partition(".")[0] for name in outputs), "noise", "offset", "drift", "lost", "frozen",
        "interpolation.amplitude", "interpolation.period")


@pytest.mark.parametrize("name", [name for name in DEFINITIONS if not name.startswith(("ClosedLoop", "Measurement"))])
def test_geometry_ports(name: str) -> None:
    found = {v.name for v in definition(name).variables if v.name.startswith("geometry.")}
    assert found == ({f"geometry.{length}" for length in ("slot_width", "slot_pitch", "pole_pitch", "magnet_height")}
                     | {f"geometry.field.{value}" for value in ("lower", "upper", "centre", "scale")}
                     | {f"geometry.field.B{k}" for k in range(13)} | {"geometry.recoil_permeability"})


def test_inputs_start_at_mid_range() -> None:
    """An importer that sets nothing sees a quiet stage."""
    for name in DEFINITIONS:
        gap, start = {"2DOF": ("v", 20e-3), "3DOF": ("y", 25e-3), "5DOF": ("y", 25e-3)}[name[-4:]]
        found = definition(name)
        for v in found.variables:
            if v.causality == "input":
                at_gap = (v.name in (f"{gap}.reference", f"{gap}.measured", f"{gap}.encoder")
                          or v.name.endswith((".gap_measured", ".gap_encoder")))
                assert found.start_value(v) == (start if at_gap else 0.0), v.name

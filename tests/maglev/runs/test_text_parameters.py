"""Set String and Enumeration parameters of third-party FMUs, of FMI 2.0 and 3.0: by --set, by a file, by a scenario."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from example_builds import EXAMPLES, require_compiler, script
from facts import raises
from small_fmus import small_fmu

from maglev.cosim.fmu import Fmu, checked_description, read_description
from maglev.cosim.port_map import read_port_maps
from maglev.files.errors import FmuError, ScenarioError
from maglev.fmi.parameter_set import SSV
from maglev.runs.carried_experiments import File, given_starts
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.runs.starts import of_type, parameter_values
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import StartValue
from maglev.scenario.settings import Settings, start_values
from maglev.user.source import FmuFile, source_of

C_CONTROLLER = EXAMPLES / "pd_controller_c"
# The bandwidth is the number in a text, the damping ratio a tenth of the item of an enumeration.
FUNCTIONS = """
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String text[]) {
    if (n != 1 || vr[0] != 9 || strncmp(text[0], "bandwidth ", 10) != 0) return fmi2Error;
    ((Controller *)c)->value[BANDWIDTH] = atof(text[0] + 10);
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]) {
    if (n != 1 || vr[0] != 10) return fmi2Error;
    ((Controller *)c)->value[DAMPING] = 0.1 * value[0];
    return fmi2OK;
}
"""
TYPES = """<TypeDefinitions><SimpleType name="Law"><Enumeration>
<Item name="soft" value="7"/><Item name="firm" value="9"/></Enumeration></SimpleType></TypeDefinitions>
<DefaultExperiment"""
VARIABLES = """<ScalarVariable name="tuning" valueReference="9" causality="parameter" variability="fixed">
<String start="bandwidth 60"/></ScalarVariable>
<ScalarVariable name="law" valueReference="10" causality="parameter" variability="fixed">
<Enumeration declaredType="Law" start="9"/></ScalarVariable>
</ModelVariables>"""


@pytest.fixture(scope="module")
def controller(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The PD controller in C, with a String and an Enumeration parameter."""
    require_compiler()
    folder = tmp_path_factory.mktemp("texts")
    changes = {"pd_controller.c": [('#include "fmi2_unused.h"', f'{FUNCTIONS}#include "fmi2_unused.h"')],
               "fmi2_unused.h": [("fmi2SetString", "other_set_string"), ("fmi2SetInteger", "other_set_integer")],
               "modelDescription.xml": [("</ModelVariables>", VARIABLES), ("<DefaultExperiment", TYPES)]}
    for file, replacements in changes.items():
        text = (C_CONTROLLER / file).read_text()
        for old, new in replacements:
            assert old in text, "the example has changed"
            text = text.replace(old, new)
        (folder / file).write_text(text)
    built: Path = script(C_CONTROLLER / "build.py").build(folder, folder)
    return built


def parameter_set(**texts: str) -> str:
    """A parameter set (SSV) of a String and an Enumeration."""
    parameters = "".join(f'<v:Parameter name="{name}"><v:{kind} value="{text}"/></v:Parameter>'
                         for (name, text), kind in zip(texts.items(), ("String", "Enumeration"), strict=True))
    return (f'<v:ParameterSet xmlns:v="{SSV}" version="1.0" name="m"><v:Parameters>{parameters}</v:Parameters>'
            "</v:ParameterSet>")


def controlled(fmus: Path, controller: Path, settings: Settings = None) -> Experiment:
    """A short run of the 2-DOF stage under that controller."""
    ports = read_port_maps(C_CONTROLLER / "ports.toml")["controller"]
    plan = load_plan("2dof-step-1-nonlinear").model_copy(update={"stop_time": 0.05})
    return prepare(plan, fmus, {"controller": Replacement(source_of(controller), ports)}, start_values(settings))


def gap(experiment: Experiment) -> np.ndarray:
    return experiment.run().columns["plant.v.position"]


def given(experiment: Experiment) -> Mapping[str, object]:
    """Start values of the controller."""
    return next(setup.start for setup in experiment.setups() if setup.name == "controller")


def test_texts_and_items_reach_an_fmu(fmus: Path, controller: Path, tmp_path: Path) -> None:
    """A text and an item of an enumeration give the run that the number gives to which the FMU turns them."""
    soft = gap(controlled(fmus, controller, ["controller.damping=0.7000000000000001", "controller.bandwidth=45"]))
    assert np.any(soft != gap(controlled(fmus, controller)))
    (tmp_path / "a.ssv").write_text(parameter_set(tuning="bandwidth 45", law="soft"))
    for settings in (["controller.tuning=bandwidth 45", "controller.law=soft"],
                     {"controller.tuning": "bandwidth 45", "controller.law": 7},
                     parameter_values({"controller": tmp_path / "a.ssv"}, ("controller", "plant"))):
        experiment = controlled(fmus, controller, settings)
        assert np.array_equal(gap(experiment), soft)
        assert given(experiment) == {"tuning": "bandwidth 45", "law": 7}
        assert [fmu.start for fmu in experiment.provenance().fmus if fmu.name == "controller"] == [given(experiment)]
    assert experiment.changes == ("controller.law = soft instead of 9.0", "controller.tuning = bandwidth 45")


def test_a_scenario_sets_texts(fmus: Path, controller: Path, tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(f"""extends = "2dof-setpoints.toml"
title = "Mine"
stop_time = "0.05 s"
[fmus.controller]
file = {str(controller)!r}
start = {{ tuning = "bandwidth 45", law = "soft" }}
""")
    ports = read_port_maps(C_CONTROLLER / "ports.toml")["controller"]
    experiment = prepare(load_plan(str(tmp_path / "mine.toml")), fmus,
                         {"controller": Replacement(source_of(controller), ports, keep_settings=True)}, {})
    assert given(experiment) == {"tuning": "bandwidth 45", "law": 7}


@pytest.mark.parametrize(("name", "value", "facts"), [
    ("law", "hard", ["soft", "firm"]), ("law", "frim", ["soft", "'firm'"]), ("law", "7.5", ["Enumeration", "whole"]),
    ("bandwidth", "fast", ["'fast'", "'25 mm'"]), ("bandwidth", "7,5", ["'7.5'"]), ("tunin", "fast", ["'tuning'"])])
def test_other_texts_are_refused(fmus: Path, controller: Path, name: str, value: str, facts: list[str]) -> None:
    with raises(ScenarioError, f"controller.{name}", value, *facts):
        controlled(fmus, controller, [f"controller.{name}={value}"]).check()


def test_a_number_is_no_text(fmus: Path, controller: Path) -> None:
    with raises(ScenarioError, "controller.tuning", 45, "String"):
        controlled(fmus, controller, {"controller.tuning": 45}).check()
    assert given(controlled(fmus, controller, ["controller.tuning=45"])) == {"tuning": "45"}


def test_what_an_fmu_says_of_a_text_is_said(fmus: Path, controller: Path) -> None:
    with raises(FmuError, "pd_controller.fmu", "fmi2SetString", "tuning"):
        controlled(fmus, controller, ["controller.tuning=as you like"]).run()


def test_texts_and_items_reach_an_fmu_of_fmi3(tmp_path: Path) -> None:
    path = small_fmu(tmp_path, {})
    description = read_description("theirs", path)
    variables = {variable.name: variable for variable in description.modelVariables}
    item = of_type(variables["level"], StartValue(float("nan"), None, "high", text="high"), "level")
    for start, expected in (({"text": "7.5"}, 7.5), ({"level": item.given}, 4.0)):
        with Fmu("theirs", FmuFile(path), description) as fmu:
            fmu.initialise(start, 0.0, 1.0)
            buffer, = fmu.buffers([fmu.variable("y")])
            fmu.get(buffer)
            assert buffer.values[0] == expected


@pytest.mark.parametrize("item", ["high", "4"])
def test_check_takes_texts_and_items(tmp_path: Path, item: str) -> None:
    description = checked_description("theirs", small_fmu(tmp_path, {}))
    given = File("a.ssv", parameter_set(text=" a b", level=item).encode())
    assert given_starts(given, description) == {"text": " a b", "level": "4"}
    with raises(ScenarioError, "a.ssv", "level", "low", "high"):
        given_starts(File("a.ssv", parameter_set(text="a", level="higher").encode()), description)
    with raises(ScenarioError, "a.ssv", "x", "'a'", "'25 mm'"):
        given_starts(File("a.ssv", parameter_set(x="a", level="low").encode()), description)

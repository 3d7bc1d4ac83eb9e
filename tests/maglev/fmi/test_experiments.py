"""What FMUs carry of their own: experiments and a manifest that lists exactly the files that are there."""

import zipfile
from pathlib import Path
from xml.etree.ElementTree import fromstring

import pytest

from maglev.cosim.master import FmuSetup, Master
from maglev.descriptions.own_fmus import DEFINITIONS, built_here, definition
from maglev.fmi.experiment_files import (
    FOLDER,
    MANIFEST,
    NAMESPACE,
    SMOKE_TEST,
    STEPS,
    ExperimentFiles,
    experiments_files,
    response,
    smoke_test,
)
from maglev.fmi.parameter_set import Value


@pytest.mark.parametrize("name", DEFINITIONS)
def test_every_input_steps_and_is_answered(name: str) -> None:
    """The results at the end are not those of a block whose inputs stay as they start."""
    own = definition(name)
    experiment = response(own)
    block = own.new_block()
    inputs = [v for v in own.variables if v.causality == "input"]
    assert list(experiment.inputs) == ["time", *(v.name for v in inputs)]
    for variable in inputs:
        first, *others = dict.fromkeys(experiment.inputs[variable.name])
        assert first == variable.read(block) and len(others) == 1 and variable.low <= others[0] <= variable.high
    last = {name: values[-1] for name, values in experiment.results.items()}
    step = own.experiment.step
    assert block.start() == 0
    assert all(block.step(k * step, step) == 0 for k in range(round(last["time"] / step)))
    assert any(abs(float(v.read(block)) - last[v.name]) > 1e-6 * (v.nominal or 1.0)
               for v in own.variables if v.causality == "output")


@pytest.mark.parametrize("name", ["Plant3DOF", "Estimator3DOF"])
def test_the_manifest_lists_what_is_there(name: str, either_kind: Path) -> None:
    with zipfile.ZipFile(either_kind / f"{name}.fmu") as archive:
        files = {file.removeprefix(FOLDER) for file in archive.namelist() if file.startswith(FOLDER)}
        root = fromstring(archive.read(MANIFEST))
        sizes = sum(archive.getinfo(f"{FOLDER}{file}").file_size for file in files)
    assert root.get(f"{{{NAMESPACE}}}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    listed = [related.get("source") for related in root.findall("Related")]
    assert sorted(map(str, listed)) == sorted(files - {"fmi-ls-manifest.xml"})
    roles = {related.get("role") for related in root.findall("Related")}
    assert {"experiment/smoke-test", "experiment/validation", "result"} <= roles
    assert sizes < 60_000
    assert built_here(either_kind / f"{name}.fmu")


def test_a_smoke_test_is_what_the_fmu_does(fmus: Path) -> None:
    """Under another master than that which runs it in a check."""
    expected = smoke_test(definition("Plant2DOF")).results
    step = expected["time"][1]
    with Master([FmuSetup("plant", fmus / "Plant2DOF.fmu")], [], step) as master:
        simulated = master.run(STEPS * step)
    assert expected["time"] == pytest.approx(simulated.time)
    for name, values in expected.items():
        assert name == "time" or values == pytest.approx(simulated.columns[f"plant.{name}"], rel=1e-8)
    assert len(set(expected["v.position"])) == STEPS + 1


def test_a_manifest_keeps_what_it_lists() -> None:
    def files(value: float) -> dict[str, bytes]:
        return ExperimentFiles("a", SMOKE_TEST, "an experiment", 0.5, {"time": [0.0, 0.5], "y": [value, 2.0]},
                               {"y": (0.1, 0.0)}, {"time": [0.0], "u": [1.0]}, [Value("p", "Real", 3.0)]).files()

    first = experiments_files({"a": (SMOKE_TEST, files(1.0))})
    other = first[MANIFEST].replace(b"</fmiReferences>", b'<Related type="text/plain" source="x.txt" role="document"/>'
                                                         b"<Annotations/></fmiReferences>")
    second = experiments_files({"a": (SMOKE_TEST, files(7.0))}, {MANIFEST: other})
    tags = [(child.tag, child.get("source")) for child in fromstring(second[MANIFEST])]
    assert tags == [("Related", "x.txt"), *(("Related", f"a{end}") for end in
                    (".exp", ".ssv", "_in.csv", "_ref.csv", "_ref.opt")), ("Annotations", None)]
    assert second[f"{FOLDER}a_ref.csv"] == b"time,y\n0,7\n0.5,2\n"
    assert b'value="3.0" />' in second[f"{FOLDER}a.ssv"]

"""Which runs are the thesis's: packaged scenarios with FMUs that this installation built."""

import json
import shutil
import zipfile
from pathlib import Path

import pytest
from command_line import maglev as command

from maglev.runs.preparation import Experiment, prepare
from maglev.scenario.layers import packaged_files
from maglev.scenario.loading import load_plan, load_plans

RUN = "2dof-setpoints"


@pytest.fixture
def folder(fmus: Path, tmp_path: Path) -> Path:
    """A folder with the FMUs of the run."""
    found = tmp_path / "fmus"
    found.mkdir()
    for name in ("Regulator2DOF", "Plant2DOF", "LinearRegulator2DOF"):
        shutil.copy(fmus / f"{name}.fmu", found)
    return found


def ready(fmus: Path, name: str | Path = RUN) -> Experiment:
    return prepare(load_plan(name), fmus, {}, {})


def test_the_packages_run_with_our_fmus_is_the_thesiss(folder: Path) -> None:
    experiment = ready(folder)
    assert experiment.departures == ()
    found = experiment.provenance()
    assert not found.modified
    assert all(fmu.built_here for fmu in found.fmus)


def test_an_fmu_that_only_has_our_name_is_not_ours(folder: Path) -> None:
    with zipfile.ZipFile(folder / "Regulator2DOF.fmu", "a") as archive:
        archive.writestr("resources/theirs.txt", "theirs")
    experiment = ready(folder)
    found = experiment.provenance()
    assert found.modified
    assert found.differences == ("controller is a Regulator2DOF.fmu that this installation did not build",)
    assert [fmu.built_here for fmu in found.fmus] == [False, True]
    assert [fmu.kind for fmu in found.fmus] == ["foreign", "Python"]


def test_another_of_our_fmus_under_the_name_is_another_run(folder: Path) -> None:
    shutil.copy(folder / "LinearRegulator2DOF.fmu", folder / "Regulator2DOF.fmu")
    assert [fmu.built_here for fmu in ready(folder).provenance().fmus] == [True, True]
    assert ready(folder).provenance().modified


@pytest.mark.thorough
def test_its_claims_have_no_verdict(folder: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(folder / "Plant2DOF.fmu", "a") as archive:
        archive.writestr("resources/theirs.txt", "theirs")
    done = command("run", "2dof-step-1-nonlinear", "--fmus", folder, "--out", tmp_path, "--json",
                   "--claims", "thesis")
    run = json.loads(done.stdout)["runs"]["2dof-step-1-nonlinear"]
    assert run["provenance"]["departures"] == ["plant is a Plant2DOF.fmu that this installation did not build"]
    assert run["claims"]
    assert {claim["verdict"] for claim in run["claims"]} == {"modified run"}


def test_a_scenario_under_a_packaged_name_is_not_the_packages(folder: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copy(packaged_files()[RUN], tmp_path))
    with copy.open("a") as file:
        file.write('\n[fmus.plant.start]\n"v.mass" = 8\n')
    experiment = ready(folder, copy)
    assert experiment.departures == (f"the scenario is {copy}, not the package's {RUN}",)
    record = experiment.provenance().as_data()
    assert record["modified"]
    assert len(record["scenario"]) == 64
    assert record["scenario"] != ready(folder).provenance().scenario == load_plan(RUN).sha256


def test_the_digest_is_of_what_it_extends_too(tmp_path: Path) -> None:
    """The file is the same, byte for byte; the references that it extends are not."""
    for name, more in (("a", ""), ("b", '\n"v.mass" = 8')):
        folder = tmp_path / name / "references"
        folder.mkdir(parents=True)
        shutil.copy(packaged_files()[RUN], folder.parent)
        text = (packaged_files()[RUN].parents[1] / "references" / "2dof-setpoints.toml").read_text()
        (folder / "2dof-setpoints.toml").write_text(text.replace("[fmus.plant.start]", f"[fmus.plant.start]{more}"))
    a, b = (load_plan(tmp_path / name / f"{RUN}.toml") for name in "ab")
    assert b.fmus["plant"].start["v.mass"].value == 8
    assert a.sha256 != b.sha256


def test_a_scenario_of_ones_own_is_no_modified_one(folder: Path, tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    own.write_text(f'extends = "{RUN}.toml"\nname = "own"\n')
    assert ready(folder, own).departures == ()


def test_digests_tell_variants_apart() -> None:
    plans = load_plans("2dof-step-1")
    assert len({plan.sha256 for plan in plans}) == len(plans)

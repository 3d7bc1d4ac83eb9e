"""A study's worst samples in the live page: exactly these runs, or a word why not."""

from pathlib import Path
from typing import Any
from urllib.parse import parse_qsl

import pytest
from tiny_study import planned, simulate_samples

from maglev.api.studying import file_or_name
from maglev.files.errors import shortened
from maglev.many.dataset import samples_schema, samples_table
from maglev.pages.live_content import NAME, live_address
from maglev.pages.sample_commands import row_link, why_no_replay
from maglev.pages.study_page import study_page, write_page
from maglev.scenario.layers import PACKAGED

RUN = "3dof-setpoints-improved"
MASS = 0.1 + 6.6   # kg, which needs all its digits


def about(options: dict[str, Any] | None = None, given: dict[str, Any] | None = None,
          targets: tuple[str, ...] = ("plant.y.mass",), scenario: str = RUN) -> dict[str, Any]:
    run = {"scenario": scenario, "options": options or {}, "set": given or {}}
    return {"scenario": scenario, "run": run, "targets": list(targets),
            "vary": [{"name": "payload", "set": [target]} for target in targets]}


def test_a_link_has_the_bits_of_the_sample() -> None:
    said = about({"kind": "native"}, {"plant.x.mass": 11.0, "controller.antiwindup": False})
    assert why_no_replay(said) == ""
    address = row_link(said, {"payload": MASS})
    file, _, fragment = address.partition("#")
    assert file == NAME
    assert dict(parse_qsl(fragment, strict_parsing=True)) == {
        "run": RUN, "plant.x.mass": "11.0", "controller.antiwindup": "false", "plant.y.mass": repr(MASS)}
    assert float(dict(parse_qsl(fragment))["plant.y.mass"]) == MASS


def test_a_setting_of_the_sample_goes_over_that_of_the_command() -> None:
    assert row_link(about(given={"plant.y.mass": 7.0}), {"payload": 8.0}) == live_address(RUN, {"plant.y.mass": 8.0})


def test_a_command_names_the_scenario_without_a_way_round(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert file_or_name(PACKAGED / "studies" / ".." / "3dof" / f"{RUN}.toml") == RUN
    assert file_or_name(tmp_path / "studies" / ".." / "mine" / "run.toml") == "mine/run.toml"
    assert file_or_name(PACKAGED / "studies" / ".." / "landing" / "3dof-nonlinear.toml") == str(
        (PACKAGED / "landing" / "3dof-nonlinear.toml").resolve())


@pytest.mark.parametrize(("said", "why"), [
    (about(targets=("reference.y.amplitude",)), "the samples differ in reference.y.amplitude"),
    (about(targets=("plant.y.force",)), "the samples differ in plant.y.force"),
    (about({"step": "0.1ms"}), "this study ran with --step"),
    (about({"kind": "native", "controller": "mine.fmu"}), "this study ran with --controller"),
    (about(given={"reference.y.amplitude": 1.0}), "the samples differ in reference.y.amplitude"),
    (about(scenario="2dof-identification-rig"), "it does not have 2dof-identification-rig"),
    (about(scenario="mine.toml"), "not mine.toml")])
def test_what_the_live_page_cannot_run(said: dict[str, Any], why: str) -> None:
    assert why in why_no_replay(said)


def test_links_stand_where_the_live_page_lies(fastest_fmus: Path, tmp_path: Path) -> None:
    study = planned(tmp_path, fastest_fmus, vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0, 4.35]}])
    made = samples_table(study, simulate_samples(study.job, 0, study.values), samples_schema(study))
    own = study_page(made, study.about, live=True)
    assert "The live page cannot run these: it has the packaged runs only" in own, shortened(own)
    name = "2dof-setpoints"
    packaged = {**study.about, "scenario": name, "run": {**study.about["run"], "scenario": name}}
    for there in (False, True):
        if there:
            (tmp_path / NAME).touch()
        write_page(tmp_path / "study.html", made, packaged)
        text = (tmp_path / "study.html").read_text(encoding="utf-8")
        assert (f'href="{NAME}#run={name}&amp;plant.v.mass=4.35"' in text) is there
        assert ("maglev live" in text) is not there

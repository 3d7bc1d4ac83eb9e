"""The live page: one file with everything in it, of the packaged runs and the modules as they are built."""

import base64
import gzip
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from motor import MOTOR

from maglev.errors import FmuError
from maglev.live.content import CONTROLLERS, FLOWN, PLANTS, flies_live, gap_table, live_runs, page_data
from maglev.live.page import FOLDER, SCRIPTS, WORKER, live_page
from maglev.schema.layers import packaged_files
from maglev.schema.loading import load_plan, load_plans
from pmlsm.gap_functions import gap_functions

LARGEST = 600_000   # bytes of the page


def element(page: str, name: str) -> bytes:
    """What an element of the page holds, unpacked."""
    found = re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', page)
    assert found is not None, name
    return gzip.decompress(base64.b64decode(found[1]))


@pytest.fixture(scope="module")
def page(wasm_fmus: Path) -> str:
    return live_page(wasm_fmus)


@pytest.fixture(scope="module")
def data(page: str) -> Any:
    return json.loads(element(page, "data"))


def test_the_page_is_small_and_the_same_again(page: str, wasm_fmus: Path) -> None:
    assert len(page.encode()) < LARGEST
    assert live_page(wasm_fmus) == page


def test_the_page_needs_nothing_else(page: str) -> None:
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!#)|https?://(?!www\.w3\.org)|@import|url\(""", page) == []
    assert "default-src 'none'" in page


def test_the_modules_are_those_that_were_built(page: str, wasm_fmus: Path) -> None:
    for name in FLOWN:
        assert element(page, f"fmu-{name}") == (wasm_fmus / f"{name}.wasm").read_bytes()


def test_every_script_is_in_it_once(page: str) -> None:
    scripts = sorted(path.name for path in FOLDER.glob("*.js"))
    assert sorted((*WORKER, *SCRIPTS)) == scripts
    for name in scripts:
        text = (FOLDER / name).read_text(encoding="utf-8")
        assert page.count(text) == 1
        assert len(text.splitlines()) < 300, name


def test_plans_are_those_of_the_scenarios(data: Any) -> None:
    """Start values and references, looked up in the scenario files' plans."""
    run = data["runs"]["3dof-tracking-nonlinear"]
    plan = load_plan("3dof-tracking-nonlinear")
    assert run["fmus"]["plant"]["start"]["y.stop.lower"] == 0.015
    assert run["fmus"]["controller"]["start"] == {key: start.value for key, start in
                                                  plan.fmus["controller"].start.items()}
    assert list(run["fmus"]) == ["controller", "plant"]
    assert [tuple(wire) for wire in run["wires"]] == list(plan.wires.values())
    vertical = next(signal for signal in run["signals"] if signal["to"] == "controller.y.reference")
    assert vertical["rate_to"] == "controller.y.reference_rate"
    assert vertical["terms"] == [{"amplitude": 0.005, "omega": 1.5 * np.pi, "phase": 0.0}]
    assert (vertical["offset"], vertical["ramp"]) == (0.025, 2.0)


def test_every_experiment_with_one_controller_is_in_it(data: Any) -> None:
    """Those of figures, but for identification, which flies estimators or starts from other runs."""
    shown = {plan.name for name in packaged_files() for plan in load_plans(name)
             if plan.figures and plan.procedure is None and not plan.needs
             and set(plan.fmus) == {"controller", "plant"}}
    assert shown and shown <= set(data["runs"])
    assert {run["fmus"]["controller"]["model"] for run in data["runs"].values()} == {
        name for rig in CONTROLLERS.values() for name in rig}


def test_runs_that_it_cannot_fly_are_not_in_it() -> None:
    assert not flies_live(load_plan("2dof-identification-rig"))   # estimators
    assert not flies_live(load_plan("3dof-laws-nonlinear"))       # for the check alone
    assert all(plan.fmus["plant"].model in PLANTS.values() for plan in live_runs())


def test_descriptions_are_those_of_the_model_description(data: Any) -> None:
    variables = {variable["name"]: variable for variable in data["fmus"]["Plant3DOF"]["variables"]}
    assert [variable["reference"] for variable in variables.values()] == list(range(len(variables)))
    assert variables["y.mass"] | {"reference": 0, "description": ""} == {
        "name": "y.mass", "reference": 0, "causality": "parameter", "boolean": False, "start": 6.9, "fixed": False,
        "unit": "kg", "description": "", "min": 1e-3, "max": 1e6}
    assert variables["y.position_start"]["fixed"] is True
    controller = {variable["name"]: variable for variable in data["fmus"]["Regulator3DOF"]["variables"]}
    assert controller["antiwindup"]["start"] is True and "min" not in controller["antiwindup"]


def test_forces_are_drawn_from_the_shape_functions() -> None:
    table = gap_table(MOTOR)
    for k in (0, 17, len(table["values"]) - 1):
        expected = gap_functions(MOTOR, table["first"] + k * table["step"])
        np.testing.assert_allclose(table["values"][k], expected, rtol=1e-5)


def test_a_missing_module_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FmuError, match=r"Plant2DOF\.wasm: there is no such file, expected the modules"):
        page_data(tmp_path)
    said = error_line(maglev("live", "--fmus", tmp_path, "--out", tmp_path))
    assert "maglev build --native --target wasm" in said
    assert not (tmp_path / "live.html").exists()

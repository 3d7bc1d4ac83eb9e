"""Measurements in a loop: nothing at their defaults, the same in both kinds, faults in the middle of a run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from maglev.cosim.master import Recording
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.runs.preparation import Experiment, prepare
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

EXTENDS = 'extends = [{files}]\nname = "{name}"\ntitle = "A short trial"\nstop_time = "{seconds} s"\nclaims = []\n'


def experiment(fmus: Path, folder: Path, *files: str, seconds: float = 0.3) -> Experiment:
    """A short run of what files have."""
    path = folder / f"{len(files)}.toml"
    listed = ", ".join(f'"{file}"' for file in files)
    path.write_text(EXTENDS.format(files=listed, name=path.stem, seconds=seconds), encoding="utf-8")
    return prepare(load_plan(path), fmus, {}, {})


@pytest.mark.parametrize("stage", PACKAGED_STAGES)
def test_at_its_defaults_the_loop_is_that_without_it(fastest_fmus: Path, tmp_path: Path, stage: str) -> None:
    """From the first sample on, in all that both record."""
    plain = experiment(fastest_fmus, tmp_path, f"{stage}-setpoints.toml").run()
    wired = experiment(fastest_fmus, tmp_path, f"{stage}-setpoints.toml", f"loops/{stage}-measurement.toml").run()
    added = {name for name in wired.columns if name.startswith("measurement.")}
    assert wired.columns.keys() - added == plain.columns.keys() and added
    for name, values in plain.columns.items():
        assert np.array_equal(wired.columns[name], values), name
    for name in added:
        encoder = plain.columns[name.replace("measurement.", "plant.").replace("measured", "encoder")]
        assert np.array_equal(wired.columns[name][1:], encoder[:-1]), "what a sample gives is held until the next"
        assert len(set(encoder)) > 1


def same(one: Recording, other: Recording) -> bool:
    """Whether two recordings agree, bit for bit."""
    return one.columns.keys() == other.columns.keys() and all(
        one.columns[name].tobytes() == values.tobytes() for name, values in other.columns.items())


@pytest.mark.parametrize("run", ["2dof-measurement", "5dof-measurement"])
def test_both_kinds_have_the_same_errors(fmus: Path, native_fmus: Path, run: str) -> None:
    """With noise, jitter, losses, drift and all else at once, in a loop that runs by them."""
    native = prepare(load_plan(run), native_fmus, {}, {})
    name = str(native.plan.fmus["measurement"].model)
    python = replace(native, sources={**native.sources, "measurement": FmuFile(fmus / f"{name}.fmu")})
    assert same(native.run(), python.run())


def test_an_encoder_jumps_in_mid_run_and_another_one_is_stuck(fastest_fmus: Path) -> None:
    found = prepare(load_plan("3dof-measurement-faults"), fastest_fmus, {}, {}).run()
    error = found.columns["measurement.y.measured"][1:] - found.columns["plant.y.position"][:-1]
    jump = 200   # samples
    assert not error[:jump].any() and np.allclose(error[jump:], 80e-6, rtol=0, atol=1e-15)
    assert not found.columns["measurement.z.measured"].any() and found.columns["plant.z.position"].any()

"""Batches on a graphics processor, without one: its code is made and read, and run here by a stand-in for CuPy.

A run has the bits of other processors where each operation rounds once, to the nearest, and none becomes part of
another: what is marked so (`.rn`) the driver leaves as it is.
"""

import sys
from collections.abc import Iterator, Mapping
from functools import cache
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from graphics_stand_in import stand_in
from native_builds import require_native_tools
from ptx_instructions import of_numbers, require_exact
from tiny_study import scenario

import maglev
from fmi_export.target import graphics
from maglev.api.many.studying import plain
from maglev.arrays import Array
from maglev.cosim.blocks import block_loop
from maglev.cosim.blocks.block_loop import Common, words_of
from maglev.cosim.blocks.graphics_processor import kernels, require_device
from maglev.errors import Interrupted
from maglev.experiment.preparation import prepare
from maglev.schema.loading import load_plan
from maglev.studies.batch import graphics_processor
from maglev.studies.batch.graphics_processor import FUNCTION, kernel_code
from maglev.studies.batch.measuring import Found, Measuring
from maglev.studies.batch.repeated_run import RepeatedRun
from maglev.studies.batch.samples import Job, Sample, run_samples

RUNS = ("2dof-push", *(pytest.param(name, marks=pytest.mark.thorough) for name in ("3dof-push", "5dof-setpoints")))

# What is recorded of the tiny scenario, and judged: all that samples have memory of their own for.
JUDGED = """
[[events]]
name = "the step"
time = "0.05 s"

[metrics]
tracking_from = "0.1 s"
"""
VALUES = {"plant.v.mass": [4.0, 4.35, 9.0, 4.1, 4.2], "controller.sample_time": [5e-4, 5e-4, 5e-4, 7e-4, 5e-4],
          "plant.v.position_start": [0.02, 0.021, 0.0195, 0.02, 0.02]}


def ptx_of(files: Mapping[str, str]) -> str:
    """What the driver gets of C files by name, compiled if it was not before."""
    kernel, = kernels(SimpleNamespace(RawModule=lambda path: SimpleNamespace(get_function=lambda _: path)), files,
                      FUNCTION)
    return Path(kernel).read_text(encoding="utf-8")


@cache
def code(fmus: Path, name: str) -> str:
    """PTX of a run, with its metrics."""
    experiment = prepare(load_plan(name), fmus, {}, {})
    taken: list[Mapping[str, str]] = []
    with pytest.MonkeyPatch.context() as patch, RepeatedRun(
            experiment, measuring=Measuring(experiment.plan, experiment.times)) as trial:
        patch.setattr(block_loop, "loop_of", lambda sources, _: taken.append(sources))
        trial.load()
    return ptx_of(kernel_code(taken[0]))


@pytest.mark.parametrize("name", RUNS)
def test_it_rounds_as_other_processors_do(native_fmus: Path, name: str) -> None:
    """Nothing is contracted, approximate, flushed to zero or in single precision; nothing is called."""
    require_exact(code(native_fmus, name), FUNCTION)


def test_what_is_common_is_left_out_and_the_rest_rounds_as_before(native_fmus: Path) -> None:
    experiment = prepare(load_plan("2dof-push"), native_fmus, {}, {})
    with RepeatedRun(experiment, measuring=Measuring(experiment.plan, experiment.times)) as trial:
        trial.load(build=True)
        assert trial.loop is not None
        masses = [trial.beginning({"plant.v.mass": mass}) for mass in (4.0, 5.0)]
        common = Common.of(words_of(masses))
        sources = trial.loop.sources
        made = ptx_of(kernel_code(sources, common.code(trial.loop.moved)))
        assert common.holds(words_of(masses)) and 0 < len(common.places) < 5
        assert not common.holds(words_of([trial.beginning({"plant.h.mass": 4.0})]))
    require_exact(made, FUNCTION)
    assert len(made) < 0.6 * len(code(native_fmus, "2dof-push"))


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("contraction", ["off", "fast"])
def test_contraction_would_be_seen(monkeypatch: pytest.MonkeyPatch, contraction: str) -> None:
    require_native_tools()
    monkeypatch.setattr(graphics, "FLAGS", [each.replace("=off", f"={contraction}") for each in graphics.FLAGS])
    files = graphics.in_one_rounding({"it.c": "double it(double a, double b, double c) { return a * b + c; }\n"})
    made = graphics.ptx(files, "it").decode()
    assert of_numbers(made) == ({"fma.rn.f64": 1} if contraction == "fast" else {"mul.rn.f64": 1, "add.rn.f64": 1})


def judged(folder: Path, fmus: Path, device: str) -> maglev.Batch:
    """Samples of the tiny scenario, judged."""
    path = scenario(folder)
    path.write_text(path.read_text(encoding="utf-8") + JUDGED, encoding="utf-8")
    return maglev.batch(path, VALUES, keep=["plant.v.position", "controller.h.reference"], keep_interval=5e-3,
                        device=device, fmus=fmus)


@pytest.mark.parametrize("special", [False, True])
def test_samples_have_the_bits_of_this_processor(native_fmus: Path, tmp_path: Path, special: bool,
                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    """In whatever chunks there is memory for; a sample that fails is a row with the same reason."""
    monkeypatch.setattr(graphics_processor, "WORTH_SPECIALISING", 1 if special else inf)
    cupy = stand_in(monkeypatch, memory=80_000)
    left: list[float] = []   # masses of the samples that are run here after all

    def simulated_here(job: Job, values: Array) -> Iterator[Sample | Found]:
        left.extend(values[:, 0])
        return run_samples(job, values)

    monkeypatch.setattr(graphics_processor, "run_samples", simulated_here)
    there, here = (judged(tmp_path, native_fmus, device) for device in ("gpu", "cpu"))
    assert len(cupy.launches) == 3 and {threads for _, threads in cupy.launches} == {(32,)}
    assert left == VALUES["plant.v.mass"][3:4]
    assert there.failures == here.failures and there.failures[3] is not None
    assert there.columns.keys() == here.columns.keys() and len(there.columns) > 20
    for name in there.columns:
        assert there[name].tobytes() == here[name].tobytes(), name
    for name in there.signals:
        assert there.signals[name].tobytes() == here.signals[name].tobytes(), name
    metrics = there.run(2).metrics
    assert metrics is not None and metrics.rms_errors["v"] == there["rms error of v"][2]
    assert len({*there["rms error of v"].tolist()}) == 5


def test_memory_that_others_take_is_said(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there is too little to begin with, or when samples go there."""
    for memory, taken, words in ((100, 0, "a sample takes"), (1e9, 9.9e8, "expected a batch of at most")):
        stand_in(monkeypatch, memory=memory).taken = int(taken)
        with pytest.raises(maglev.MaglevError, match=f"device='gpu': .*{words}"):
            judged(tmp_path, native_fmus, "gpu")


def test_a_study_has_the_bytes_of_this_processor(native_fmus: Path, tmp_path: Path,
                                                 monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where references vary, and where it goes on after an interruption."""
    vary = {"reference.v.end": [0.02, 0.021, 0.0205], "plant.v.mass": [4.0, 4.35, 4.1]}
    cupy = stand_in(monkeypatch)

    def study(folder: str, device: str, **options: Any) -> bytes:
        return maglev.study(scenario(tmp_path), vary=vary, fmus=native_fmus, out=tmp_path / folder, device=device,
                            **options).path.read_bytes()

    here = study("here", "cpu")
    assert study("there", "gpu") == here and len(cupy.launches) == 1

    def interrupted(*_: Any) -> Any:
        raise KeyboardInterrupt

    monkeypatch.setattr(graphics_processor, "MOST", 1)   # batches are stored one by one
    with monkeypatch.context() as patch:
        finish, left = graphics_processor.run_together, iter(range(3))
        patch.setattr(graphics_processor, "run_together",
                      lambda *given: finish(*given) if next(left, None) is not None else interrupted())
        with pytest.raises(Interrupted, match="6 of 9 samples are kept"):
            study("resumed", "gpu")
    assert study("resumed", "gpu", resume=True) == here


PUSHED = """
[[signals]]
to = "plant.h.force"
kind = "steps"
unit = "N"
times = [0, 0.1]
values = [0, 5]
"""


@pytest.mark.parametrize(("memory", "launches"), [(1e9, 1), (60_000, 3)])
def test_samples_with_pushes_of_their_own_run_together(native_fmus: Path, tmp_path: Path, memory: float, launches: int,
                                                       monkeypatch: pytest.MonkeyPatch) -> None:
    """Signals that several have are there once, and take their part of the memory."""
    cupy = stand_in(monkeypatch, memory=memory)
    sent: list[Any] = []
    monkeypatch.setattr(graphics_processor.Device, "given", counted(graphics_processor.Device.given, sent))
    there, here = (maglev.batch(scenario(tmp_path, PUSHED), {
        "reference.plant.h.force.end": [5.0, -4.0, 5.0, 0.0, -4.0], "plant.h.mass": [4.0, 4.0, 4.1, 4.2, 4.3]},
        device=device, fmus=native_fmus) for device in ("gpu", "cpu"))
    assert len(cupy.launches) == launches and len(sent) == 3
    assert there["rms error of h"].tobytes() == here["rms error of h"].tobytes()
    assert len({*here["rms error of h"].tolist()}) == 5


def test_samples_with_references_of_their_own_run_together(native_fmus: Path, tmp_path: Path,
                                                           monkeypatch: pytest.MonkeyPatch) -> None:
    """Each with as many windows as it has steps, none of two of them."""
    path = scenario(tmp_path, JUDGED)
    cupy = stand_in(monkeypatch)
    there, here = (maglev.batch(path, {"reference.v.end": [0.02, 0.021, 0.02, 0.0205, 0.021],
                                       "reference.h.end": [0.0, 1e-3, 0.0, 0.0, 1e-3],
                                       "plant.v.mass": [4.0, 4.0, 4.2, 4.0, 4.1]},
                                device=device, fmus=native_fmus)
                   for device in ("gpu", "cpu"))
    assert len(cupy.launches) == 1
    assert there.failures == here.failures
    for name in here.columns:
        assert there[name].tobytes() == here[name].tobytes(), name
    assert np.isnan(here["overshoot of v"]).tolist() == [True, False, True, False, False]


def counted(function: Any, calls: list[Any]) -> Any:
    """A method that counts its calls."""
    def called(*given: Any) -> Any:
        calls.append(given)
        return function(*given)

    return called


def test_references_that_cannot_be_are_rows_with_the_reason(native_fmus: Path, tmp_path: Path,
                                                            monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(monkeypatch)
    there, here = (maglev.batch(scenario(tmp_path), {"reference.v.amplitude": [1.0, 1e300, 1.1]}, device=device,
                                fmus=native_fmus) for device in ("gpu", "cpu"))
    assert there.failures == here.failures and there.failures[1] is not None
    assert there["rms error of v"].tobytes() == here["rms error of v"].tobytes()


def test_what_a_study_cannot_be_is_refused(native_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stand_in(monkeypatch)
    refused: tuple[tuple[dict[str, Any], str], ...] = (
        ({"sample_timeout": "1 s"}, "sample_timeout='1 s': .*expected none with device='gpu'"),
        ({"scheduler": "tcp://host:8786"}, "device='gpu': expected no scheduler with it"))
    for options, words in refused:
        with pytest.raises(maglev.ScenarioError, match=words):
            maglev.study(scenario(tmp_path), vary={"plant.v.mass": [4.0]}, fmus=native_fmus, out=tmp_path, device="gpu",
                         **options)


def test_what_is_not_there_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cupy", None)
    with pytest.raises(maglev.MaglevError, match="device='gpu' needs cupy, expected it to be installed: .*gpu"):
        require_device("gpu")
    with pytest.raises(maglev.ScenarioError, match="device='gppu': expected one of cpu, gpu; nearest is 'gpu'"):
        require_device("gppu")
    for options, words in (({"found": 0}, "cudaErrorNoDevice: .*, expected a graphics processor of NVIDIA"),
                           ({"capability": "75"}, "compute capability 7.5, expected at least 8.0, or device='cpu'")):
        stand_in(monkeypatch, **options)
        with pytest.raises(maglev.MaglevError, match=f"device='gpu': .*{words}"):
            require_device("gpu")


def test_arrays_come_by_dlpack(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of this machine's memory and of a graphics processor's; what comes out speaks it, too."""
    assert plain(np.array([4.0, 5.0], np.float32)) == [4.0, 5.0]
    cupy = stand_in(monkeypatch)
    monkeypatch.setattr("maglev.api.many.studying.extra", lambda *_: cupy)
    assert plain(cupy.asarray([4.0, 5.0])) == [4.0, 5.0]

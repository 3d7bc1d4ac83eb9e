"""FMUs run their own code, whatever else the process has imported, and survive being freed after a refusal."""

import subprocess
import sys
from pathlib import Path

import pytest

import maglev.fmi.build
import pmlsm.gap_functions
from maglev.cosim.fmu import Fmu, read_description
from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.files.packages import IN_FMUS
from maglev.fmi.build import Maker, build_fmu
from maglev.language.sources import carried_modules
from maglev.user.source import FmuFile


def falling(path: Path) -> float:
    """Air gap after 20 ms of fall."""
    with Fmu(path.stem, FmuFile(path), read_description(path.stem, path)) as fmu:
        fmu.initialise({}, 0.0, 1.0)
        for k in range(100):
            fmu.instance.doStep(k * 2e-4, 2e-4)
        reference = fmu.variable("y.position").valueReference
        return float(fmu.instance.getReal([reference])[0])


def other_version(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Plant3DOF of another version, on which gravity is that of the moon."""
    def altered(entry: str, packages: tuple[str, ...]) -> dict[str, str]:
        texts = carried_modules(entry, packages)
        if "pmlsm.velocity_rows" in texts:
            changed = texts["pmlsm.velocity_rows"].replace("GRAVITY = 9.81", "GRAVITY = 1.62")
            assert changed != texts["pmlsm.velocity_rows"]
            texts["pmlsm.velocity_rows"] = changed
        return texts

    monkeypatch.setattr(maglev.fmi.build, "carried_modules", altered)
    maker = Maker("9.9.9", "licence", IN_FMUS)
    return build_fmu(definition("Plant3DOF"), DEFINITIONS["Plant3DOF"].text(), maker, folder)


def test_two_versions_in_one_process(fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    moon = other_version(tmp_path, monkeypatch)
    first = falling(fmus / "Plant3DOF.fmu")
    on_moon = falling(moon)
    assert on_moon < 0.025 < first, "the stage falls on earth, and is pulled up on the moon"
    assert falling(fmus / "Plant3DOF.fmu") == first


def test_host_packages_are_not_used(fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    undisturbed = falling(fmus / "Plant3DOF.fmu")
    # A host that has our packages imported, and broken.
    monkeypatch.setattr(pmlsm.gap_functions, "slot_permeance", None)
    monkeypatch.setattr("plant_fmu.stage.Stage.step", None)
    monkeypatch.setattr("pythonfmu.fmi2slave.Fmi2Slave.__init__", None)
    assert falling(fmus / "Plant3DOF.fmu") == undisturbed


def test_no_module_of_an_fmu_has_a_common_name(fmus: Path) -> None:
    script = f"""
import sys
from pathlib import Path
sys.path.insert(0, {str(Path(__file__).parents[2])!r})
before = set(sys.modules)
import fmpy
fmpy.simulate_fmu({str(fmus / "Plant2DOF.fmu")!r})
own = [name for name in set(sys.modules) - before
       if any(word in name for word in ("pmlsm", "plant_fmu", "maglev", "pythonfmu"))]
assert own and all(name.startswith("plant2dof_") for name in own), own
"""
    subprocess.run([sys.executable, "-c", script], check=True)


def test_freeing_after_a_refusal_does_not_crash(fmus: Path) -> None:
    """FMI forbids it, but masters do it; pythonfmu's binary drops its references twice."""
    script = f"""
import gc
import fmpy
from fmpy.fmi2 import FMU2Slave
path = {str(fmus / "Regulator2DOF.fmu")!r}
description, folder = fmpy.read_model_description(path), fmpy.extract(path)
for _ in range(20):
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="r",
                    modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate()
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    for _ in range(3):
        try:
            fmu.doStep(0.0, 1.0)
        except Exception as error:
            refused = error
    fmu.fmi2FreeInstance(fmu.component)
    gc.collect()
assert refused
"""
    subprocess.run([sys.executable, "-c", script], check=True)

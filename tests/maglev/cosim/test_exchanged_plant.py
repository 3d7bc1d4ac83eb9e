"""The master with a plant for model exchange alone, which CVODE integrates, against the plant's own steps."""

from ctypes import c_double
from pathlib import Path

import numpy as np
import pytest
from exchange_alone import for_exchange_alone
from fmpy.model_description import ModelDescription

from maglev.cosim.master import FmuSetup, Master
from maglev.cosim.model_exchange import FAILED, Integration

STEP = 2e-4   # s
CONNECTIONS = [*((f"controller.{motor}.i_{phase}_cmd", f"plant.{motor}.i_{phase}_cmd")
                 for motor in ("alpha", "beta") for phase in "abc"),
               *((f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in "yxz")]


def largest_differences(folder: Path, scratch: Path, stop_time: float) -> tuple[float, float]:
    """Of positions (m) and of velocities (m/s), in closed loop with steps of the references."""
    plants = folder / "Plant3DOF.fmu", for_exchange_alone(folder / "Plant3DOF.fmu", scratch / "exchanged.fmu")
    time = STEP * np.arange(round(stop_time / STEP) + 1)
    drives = {"controller.y.reference": 0.025 + 0.001 * (time >= 0.02).astype(float),
              "controller.x.reference": 0.005 * np.sin(3.0 * time),
              "controller.x.reference_rate": 0.015 * np.cos(3.0 * time)}
    simulated = []
    for plant in plants:
        setups = [FmuSetup("controller", folder / "Regulator3DOF.fmu"), FmuSetup("plant", plant)]
        with Master(setups, CONNECTIONS, STEP) as master:
            simulated.append(master.run(stop_time, drives).columns)
    assert np.ptp(simulated[0]["plant.y.position"]) > 1e-4
    position, velocity = (max(np.abs(simulated[0][f"plant.{axis}.{what}"] - simulated[1][f"plant.{axis}.{what}"]).max()
                              for axis in "yxz") for what in ("position", "velocity"))
    return position, velocity


@pytest.mark.parametrize("version", [2, 3])
def test_closed_loop(native_fmus: Path, fmi3_fmus: Path, tmp_path: Path, version: int) -> None:
    position, velocity = largest_differences(native_fmus if version == 2 else fmi3_fmus, tmp_path, 0.1)
    assert position < 1e-8 and velocity < 1e-6


@pytest.mark.parametrize(("update", "said"), [
    ((True, False, False, False, False, 0.0), "after 1000 events at one instant the FMU asks for another"),
    ((False, True, False, False, False, 0.0), "the FMU asks for the end of the simulation")])
def test_reports_endless_events_and_an_early_end(update: tuple[object, ...], said: str) -> None:
    heard: list[str] = []
    step = Integration(None, ModelDescription(), lambda: update, heard.append)
    assert step(None, c_double(0.0), c_double(STEP), 1) == FAILED
    assert heard == [said]


@pytest.mark.thorough
def test_closed_loop_over_five_seconds(native_fmus: Path, tmp_path: Path) -> None:
    """A count of an encoder that one of both sees first sets them apart, by less than one count."""
    position, velocity = largest_differences(native_fmus, tmp_path, 5.0)
    assert position < 1e-5 and velocity < 1e-3

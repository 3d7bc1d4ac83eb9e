"""FMUs that several threads load: fmpy changes the working directory of the process while it loads a library."""

import os
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from fmpy import fmi1

from maglev.cosim.fmu import Fmu, read_description
from maglev.user.source import FmuFile


def test_threads_that_load_fmus_leave_the_working_directory(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each thread would else take the folder of the other's library, which is removed, for the one to go back to."""
    path = native_fmus / "Commutation2DOF.fmu"
    load = fmi1.cdll.LoadLibrary

    def slowly(name: str) -> Any:
        time.sleep(0.05)
        return load(name)

    monkeypatch.setattr(fmi1.cdll, "LoadLibrary", slowly)
    description, before = read_description("commutation", path), os.getcwd()
    try:
        with ThreadPoolExecutor(2) as pool:
            for fmu in pool.map(lambda _: Fmu("commutation", FmuFile(path), description), range(4)):
                fmu.close()
        assert os.getcwd() == before
    finally:
        os.chdir(before)

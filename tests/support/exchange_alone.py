"""FMUs for model exchange alone, which the master integrates."""

import re
import zipfile
from pathlib import Path

from maglev.cosim.fmu import read_description


def for_exchange_alone(fmu: Path, copy: Path) -> Path:
    """A copy of an FMU without its co-simulation."""
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(copy, "w") as written:
        for name in archive.namelist():
            data = archive.read(name)
            if name == "modelDescription.xml":
                data = re.sub(rb"<CoSimulation[^>]*/>|<CoSimulation.*?</CoSimulation>", b"", data, flags=re.DOTALL)
            written.writestr(name, data)
    assert read_description("plant", copy).modelExchange is not None
    return copy

"""Build pd_controller.fmu beside this file, or into the folder that is named: compile, and zip.

The FMI headers are those that fmpy ships. The compiler is the system's cc, or that of the package ziglang.
"""

import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy

HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
# Names of the FMI standard: the folder in the FMU, and the ending of a shared library.
FOLDERS = {"Linux": ("linux64", ".so"), "Darwin": ("darwin64", ".dylib"), "Windows": ("win64", ".dll")}


def build(folder: Path = HERE) -> Path:
    """Build the FMU into a folder; returns its path."""
    compiler = [found] if (found := shutil.which("cc")) else [sys.executable, "-m", "ziglang", "cc"]
    place, ending = FOLDERS[platform.system()]
    library = folder / f"pd_controller{ending}"
    position = [] if ending == ".dll" else ["-fPIC", "-lm"]
    subprocess.run([*compiler, "-O2", "-shared", "-I", HEADERS, HERE / "pd_controller.c", "-o", library, *position],
                   check=True)
    fmu = folder / "pd_controller.fmu"
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(HERE / "modelDescription.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{place}/{library.name}")
        archive.write(HERE / "pd_controller.c", "sources/pd_controller.c")
    library.unlink()
    return fmu


if __name__ == "__main__":
    print(build(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE))

"""Build pd_controller.fmu next to this file, or the FMU of the C file in a folder that is given as argument.

The FMI headers come with fmpy. The compiler is cc of the system, or that of the package ziglang.
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


def build(folder: Path = HERE, sources: Path = HERE) -> Path:
    """Build into a folder the FMU of the C file and the modelDescription.xml in another; returns its path."""
    compiler = [cc] if (cc := shutil.which("cc")) else [sys.executable, "-m", "ziglang", "cc"]
    place, ending = FOLDERS[platform.system()]
    source, = sources.glob("*.c")
    library = folder / f"{source.stem}{ending}"
    position = [] if ending == ".dll" else ["-fPIC", "-lm"]
    subprocess.run([*compiler, "-O2", "-ffp-contract=off", "-shared", "-I", HEADERS, "-I", HERE, source, "-o", library,
                    *position], check=True)
    fmu = library.with_suffix(".fmu")
    with zipfile.ZipFile(fmu, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(sources / "modelDescription.xml", "modelDescription.xml")
        archive.write(library, f"binaries/{place}/{library.name}")
        for text in (source, HERE / "fmi2_unused.h"):
            archive.write(text, f"sources/{text.name}")
    library.unlink()
    return fmu


if __name__ == "__main__":
    named = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    print(build(named, named))

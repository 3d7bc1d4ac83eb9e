"""Small FMUs of FMI 3.0 in C, x' = u - x, with statements in them that no FMU should have."""

import re
import subprocess
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import fmpy
from example_builds import require_compiler
from native_builds import FMI_HEADERS

SOURCE = Path(__file__).with_name("small_fmu.c")

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Small" instantiationToken="small">
<{kind} modelIdentifier="small"{attributes}/>
<TypeDefinitions><EnumerationType name="Level"><Item name="low" value="2"/><Item name="high" value="4"/>
</EnumerationType></TypeDefinitions>
<ModelVariables>
<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
<Float64 name="u" valueReference="1" causality="input" start="0"/>
<Float64 name="x" valueReference="2" causality="local" start="1" initial="exact"/>
<Float64 name="rate" valueReference="3" causality="local" derivative="2"/>
<Float64 name="y" valueReference="4" causality="output"/>
<Boolean name="b" valueReference="5" causality="output"/>
<Float64 name="above" valueReference="6" causality="local"/>
<String name="text" valueReference="7" causality="parameter" variability="fixed"><Start value="1"/></String>
<Enumeration name="level" valueReference="8" causality="parameter" variability="fixed" declaredType="Level" start="2"/>
</ModelVariables>
<ModelStructure>
<Output valueReference="4"/><Output valueReference="5"/><ContinuousStateDerivative valueReference="3"/>
<EventIndicator valueReference="6"/>
</ModelStructure>
</fmiModelDescription>
"""


def small_fmu(folder: Path, holes: Mapping[str, str], exchange: bool = False) -> Path:
    """Build the FMU into a folder, with C statements in its holes, such as IN_STEP; returns its path."""
    return built_fmu(folder, SOURCE, DESCRIPTION.format(
        kind="ModelExchange" if exchange else "CoSimulation",
        attributes="" if exchange else ' canHandleVariableCommunicationStepSize="true"'),
        [f"-D{name}={statement}" for name, statement in holes.items()])


def built_fmu(folder: Path, source: Path, description: str, defines: Sequence[str] = ()) -> Path:
    """Build an FMU of FMI 3.0, `small.fmu`, of a C source and a model description into a folder; returns its path."""
    library = folder / f"small{fmpy.sharedLibraryExtension}"
    (folder / "absent.c").write_text(absent_functions(source.read_text()))
    subprocess.run([*require_compiler(), "-shared", "-fPIC", *FMI_HEADERS, *defines, source, folder / "absent.c", "-o",
                    library, "-lm"], check=True)
    with zipfile.ZipFile(folder / "small.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.write(library, f"binaries/{fmpy.platform_tuple}/{library.name}")
    return folder / "small.fmu"


def absent_functions(source: str) -> str:
    """C text of the functions of FMI 3.0 that a source lacks; they fail."""
    header = Path(FMI_HEADERS[1], "fmi3Functions.h").read_text()
    absent = set(re.findall(r"^FMI3_Export +fmi3\w+TYPE +(fmi3\w+);", header, re.MULTILINE)) - set(
        re.findall(r"\bfmi3\w+", source))
    return "".join(f"int {name}(void) {{ return 3; }}\n" for name in sorted(absent))

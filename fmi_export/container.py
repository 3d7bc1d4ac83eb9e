"""FMUs and their connections as one FMU, a container, stepped one after the other as our master does.

The container is made by fmu-manipulation-toolbox, which brings the library that steps the FMUs inside. The description
of the container is written here: the toolbox's has neither units nor ranges, but clock, user and a random GUID.
"""

import hashlib
import logging
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from importlib.metadata import distribution
from importlib.util import find_spec
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring, indent, tostring

from fmi_export.build import build_date, digest, write_archive
from fmi_export.documentation import STYLE
from fmi_export.errors import ExportError
from fmi_export.model_description import AUTHOR, LICENCE

TOOLBOX = "fmu-manipulation-toolbox"
ELF_MACHINE = slice(18, 20)   # of a Linux library: the processor that it is for


@dataclass(frozen=True)
class Container:
    """What a container is.

    Attributes
    ----------
    name, description : str
    components : mapping of str to str
        FMU of each component by its name in the container, in the order in which they step.
    connections : tuple of (str, str)
        From an output to an input, both `component.variable`.
    step : float
        Internal step, s: every component does it.
    stop_time : float
        Of the default experiment, s.
    """

    name: str
    description: str
    components: Mapping[str, str]
    connections: tuple[tuple[str, str], ...]
    step: float
    stop_time: float


@dataclass(frozen=True)
class Exposed:
    """A variable of the container: its name, the component's and the name there, and what the component says of it."""

    name: str
    component: str
    variable: str
    element: Element


def require_toolbox() -> None:
    """Raise ExportError if fmu-manipulation-toolbox, an extra of this project, is not installed."""
    if find_spec("fmu_manipulation_toolbox") is None:
        raise ExportError(f"a container needs {TOOLBOX}, expected it to be installed: "
                          "pip install 'maglev-fmus[native]'")


def build_container(container: Container, natives: Path, version: str, licence: str, destination: Path) -> Path:
    """Write `destination/NAME.fmu` of the FMUs in the folder `natives`, and return its path.

    Exposed are all parameters and outputs as `component.variable`, and all inputs that nothing feeds, under the names
    that they have in their component.

    Raises
    ------
    ExportError
        If the toolbox is not installed, or if two components have an open input of the same name, or if the toolbox
        has no library for the processor of the FMUs' Linux binaries.
    """
    require_toolbox()
    described = {name: described_in(natives / f"{model}.fmu") for name, model in container.components.items()}
    exposed = exposed_variables(container, described)
    contents = toolbox_contents(container, exposed, natives)
    check_processor(container, contents)
    references = {v.get("name", ""): v.get("valueReference", "")
                  for v in fromstring(contents.pop("modelDescription.xml")).iter("ScalarVariable")}
    contents["model.png"] = contents["resources/00/model.png"]
    contents["documentation/index.html"] = documentation(container, exposed, version).encode("utf-8")
    licences = "documentation/licenses/"
    contents |= {name.removeprefix("resources/00/"): text for name, text in contents.items()
                 if name.startswith(f"resources/00/{licences}")}
    contents[f"{licences}license.txt"] = licence.encode("utf-8")
    contents[f"{licences}{TOOLBOX}.txt"] = toolbox_licence().encode("utf-8")
    without_guid = container_description(container, described, exposed, references, "", version)
    hashes = [part for name in sorted(contents) for part in (name, hashlib.sha256(contents[name]).hexdigest())]
    guid = f"{{{digest([without_guid.decode('utf-8'), *hashes])[:32]}}}"
    contents["modelDescription.xml"] = container_description(container, described, exposed, references, guid, version)
    return write_archive(destination / f"{container.name}.fmu", contents)


def described_in(path: Path) -> Element:
    """Model description of an FMU."""
    with zipfile.ZipFile(path) as archive:
        return fromstring(archive.read("modelDescription.xml"))


def exposed_variables(container: Container, described: Mapping[str, Element]) -> list[Exposed]:
    """Variables of the container: inputs, outputs, parameters; ExportError if two have the same name."""
    fed = {target for _, target in container.connections}
    found: dict[str, Exposed] = {}
    for causality in ("input", "output", "parameter"):
        for component, description in described.items():
            for element in description.iter("ScalarVariable"):
                full = f"{component}.{element.get('name')}"
                if element.get("causality") != causality or full in fed:
                    continue
                name = element.get("name", "") if causality == "input" else full
                if name in found:
                    raise ExportError(f"{container.name}: {found[name].component} and {component} both have an input "
                                      f"{name} that nothing feeds, expected different names")
                found[name] = Exposed(name, component, element.get("name", ""), element)
    return list(found.values())


def toolbox_contents(container: Container, exposed: list[Exposed], natives: Path) -> dict[str, bytes]:
    """Files of the container as the toolbox writes it, by their names in the archive."""
    from fmu_manipulation_toolbox.container import FMUContainer

    file_of = {name: f"{model}.fmu" for name, model in container.components.items()}
    with tempfile.TemporaryDirectory(prefix="maglev_container_") as folder, quiet_toolbox():
        made = FMUContainer(container.name, natives.resolve(), fmi_version=2)
        for file in file_of.values():
            made.get_fmu(file)
        for source, target in container.connections:
            (source_component, _, output), (target_component, _, input_) = source.partition("."), target.partition(".")
            made.add_link(file_of[source_component], output, file_of[target_component], input_)
        for each in exposed:
            if each.element.get("causality") == "output":
                made.add_output(file_of[each.component], each.variable, each.name)
            else:
                made.add_input(each.name, file_of[each.component], each.variable)
        path = Path(folder).resolve() / f"{container.name}.fmu"
        # Sequential: the toolbox's default steps all components in parallel, which delays the loop by a step.
        made.make_fmu(path, step_size=container.step, sequential=True)
        with zipfile.ZipFile(path) as archive:
            return {name: archive.read(name) for name in archive.namelist()}


@contextmanager
def quiet_toolbox() -> Iterator[None]:
    """Keep the toolbox from warning of the loop, which every closed loop has: its first component starts with its own
    start values, and gets the others' outputs before its first step."""
    logger = logging.getLogger("fmu_manipulation_toolbox")
    level = logger.level
    logger.setLevel(logging.ERROR)
    try:
        yield
    finally:
        logger.setLevel(level)


def check_processor(container: Container, contents: Mapping[str, bytes]) -> None:
    """Refuse FMUs whose Linux binaries are for another processor than the toolbox's; it has one for x86-64."""
    libraries = [data for name, data in sorted(contents.items()) if "binaries/linux64/" in name]
    if len({data[ELF_MACHINE] for data in libraries}) > 1:
        raise ExportError(f"{container.name}: the toolbox has no container for the processor of the FMUs' Linux "
                          "binaries, expected x86-64")


def container_description(container: Container, described: Mapping[str, Element], exposed: list[Exposed],
                          references: Mapping[str, str], guid: str, version: str) -> bytes:
    """Model description of the container, with what the components say of their variables."""
    root = Element("fmiModelDescription", {
        "fmiVersion": "2.0",
        "modelName": container.name,
        "guid": guid,
        "description": container.description,
        "author": AUTHOR,
        "version": version,
        "copyright": f"Copyright (c) {AUTHOR}; see documentation/licenses",
        "license": f"{LICENCE}; the container's binaries BSD-2-Clause",
        "generationTool": f"Maglev FMUs {version}, {TOOLBOX} {distribution(TOOLBOX).version}",
        "generationDateAndTime": datetime.fromtimestamp(build_date(), UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        "variableNamingConvention": "structured",
    })
    SubElement(root, "CoSimulation", {
        "modelIdentifier": container.name,
        "needsExecutionTool": "true" if any(
            element.get("needsExecutionTool") == "true" for each in described.values()
            for element in each.iter("CoSimulation")) else "false",
        # The container does whole internal steps only: of another step it leaves out what is no whole step.
        "canHandleVariableCommunicationStepSize": "false",
        "canInterpolateInputs": "false",
        "maxOutputDerivativeOrder": "0",
        "canRunAsynchronuously": "false",
        "canBeInstantiatedOnlyOncePerProcess": "false",
        "canNotUseMemoryManagementFunctions": "true",
        "canGetAndSetFMUstate": "false",
        "canSerializeFMUstate": "false",
        "providesDirectionalDerivative": "false",
    })
    units = {unit.get("name", ""): unit for description in described.values() for unit in description.iter("Unit")}
    SubElement(root, "UnitDefinitions").extend(units[name] for name in sorted(units))
    categories = SubElement(root, "LogCategories")
    SubElement(categories, "Category", {"name": "Info", "description": "Info log messages."})
    SubElement(categories, "Category", {"name": "Error", "description": "Error log messages."})
    SubElement(root, "DefaultExperiment", {"startTime": "0.0", "stopTime": repr(container.stop_time),
                                           "stepSize": repr(container.step)})
    sampled = {name for name, description in described.items() if fixed_step(description)}
    variables = SubElement(root, "ModelVariables")
    for each in exposed:
        attributes = dict(each.element.attrib)
        if attributes["causality"] == "input" and each.component in sampled:
            # Read at samples, and so held by an importer between two rows of an input file. fmpy interpolates a
            # continuous input even between equal values, which rounds 15 % of them to a neighbouring number.
            attributes["variability"] = "discrete"
        attributes |= {"name": each.name, "valueReference": references[each.name]}
        SubElement(variables, "ScalarVariable", attributes).extend(each.element)
    structure = SubElement(root, "ModelStructure")
    outputs = [str(i) for i, each in enumerate(exposed, start=1) if each.element.get("causality") == "output"]
    for name in ("Outputs", "InitialUnknowns"):
        # Without dependencies, which means on everything: what the controller samples it puts out in the same step.
        SubElement(structure, name).extend(Element("Unknown", {"index": index}) for index in outputs)
    indent(root)
    text: str = tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'.encode()


def fixed_step(description: Element) -> bool:
    """Whether an FMU wants the same communication step throughout."""
    simulation = description.find("CoSimulation")
    return simulation is not None and simulation.get("canHandleVariableCommunicationStepSize", "false") == "false"


def documentation(container: Container, exposed: list[Exposed], version: str) -> str:
    """HTML page: how the container steps, its components and their pages, its variables."""
    components = "\n".join(
        f'<li><code>{escape(name)}</code>: <a href="../resources/{i:02x}/documentation/index.html">{escape(model)}</a>'
        "</li>" for i, (name, model) in enumerate(container.components.items()))
    connections = "\n".join(f"<tr><td>{escape(source)}</td><td>{escape(target)}</td></tr>"
                            for source, target in container.connections)
    rows = []
    for each in exposed:
        typed = each.element[0]
        bounds = f"{float(typed.get('min', '')):g} … {float(typed.get('max', '')):g}" if typed.get("min") else ""
        cells = (each.name, each.element.get("causality", ""), typed.get("start", ""), typed.get("unit", ""), bounds,
                 each.element.get("description", ""))
        rows.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    head = "".join(f"<th>{title}</th>" for title in ("name", "causality", "start", "unit", "range", "meaning"))
    name = escape(container.name)
    return f"""<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{name}</title><style>{STYLE}</style></head>
<body>
<h1>{name} {escape(version)}</h1>
<p>{escape(container.description)}</p>
<p>The components step one after the other, each with the outputs that those before it have just computed, every
{container.step:g} s. The communication step must be a multiple of that: inputs are held over it. Of any other step the
container does the whole internal steps and falls behind, without a word. Its state can be neither saved nor
restored.</p>
<ol>
{components}
</ol>
<h2>Connections</h2>
<table><tr><th>from</th><th>to</th></tr>
{connections}
</table>
<h2>Variables</h2>
<div class="wide"><table><tr>{head}</tr>
{chr(10).join(rows)}
</table></div>
</body>
</html>
"""


def toolbox_licence() -> str:
    """Licence text of the toolbox, whose library is in the container."""
    metadata = distribution(TOOLBOX)
    for path in metadata.files or []:
        if path.name == "LICENSE.txt" and "dist-info" in str(path):
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{TOOLBOX} {metadata.version} is installed without its LICENSE.txt, expected one to ship")

"""The experiments that an FMU carries: by the layered standard FMI-LS-REF, or in files next to it.

The drafts FMI-LS-REF 1.0.0-beta.1 and MA-HS-Experiments are read as they stand, also in the form with the times in the
element `Experiment` itself. A result that no experiment refers to is that of the default experiment.
"""

import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from posixpath import normpath
from typing import NamedTuple
from urllib.parse import unquote, urlsplit
from xml.etree.ElementTree import Element, ParseError, fromstring
from zipfile import BadZipFile, ZipFile

from maglev.files.errors import FmuError, nearest, nearest_file, shortened
from maglev.files.regular_file import regular
from maglev.files.units import is_finite
from maglev.fmi.experiment_files import CSV_TYPE, FOLDER, MANIFEST, SSV_TYPE

MOST = 50_000_000   # bytes of a file

EXPERIMENT_TYPES = ("application/x-ma-hs-experiments", "application/x-ma-ls-experiments")   # the latter in older drafts


class File(NamedTuple):
    """A file of an experiment: its name for messages, and its bytes."""

    place: str
    data: bytes


@dataclass(frozen=True)
class CarriedExperiment:
    """An experiment in an FMU: its inputs and expected results; None for each part that is missing."""

    name: str
    start_time: float | None = None   # s
    stop_time: float | None = None    # s
    step: float | None = None         # s
    tolerance: float | None = None    # relative, of a solver
    parameters: File | None = None    # SSV
    inputs: File | None = None        # CSV
    results: File | None = None       # CSV
    options: File | None = None       # the tolerances of the results
    problem: str = ""                 # why it cannot be run; empty if it can


def carried_experiments(path: Path) -> list[CarriedExperiment]:
    """Experiments of an FMU, also with a `problem`; FmuError if it carries none, or cannot be read."""
    try:
        with ZipFile(regular(path)) as archive:
            sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
            if "modelDescription.xml" not in sizes:
                raise FmuError(f"{path}: has no modelDescription.xml, expected an FMU")
            wanted = [name for name in sizes if name.startswith("extra/") or name == MANIFEST]
            for name in wanted:
                if sizes[name] > MOST:
                    raise FmuError(f"{path}: {name} has {sizes[name]} bytes, expected at most {MOST}")
            files = {name: archive.read(name) for name in wanted}
    except FileNotFoundError:
        raise FmuError(f"{path}: there is no such file{nearest_file(path)}, expected an FMU") from None
    except (OSError, BadZipFile, zlib.error, NotImplementedError, RuntimeError) as error:
        raise FmuError(f"{path}: cannot be read as an FMU: {error}") from error
    carried = [*(in_manifest(path, files) if MANIFEST in files else ()), *beside(path)]
    if not carried:
        raise FmuError(f"{path}: contains no experiments, expected {MANIFEST} with some in it, or {path.stem}_ref.csv "
                       "next to it")
    return carried


def beside(path: Path) -> Iterator[CarriedExperiment]:
    """The experiment in files next to an FMU, as in the FMI cross-check: NAME_ref.csv, NAME_in.csv and NAME_ref.opt."""
    results = path.with_name(f"{path.stem}_ref.csv")
    if not results.is_file():
        return
    def file(*names: str) -> File | None:
        places = [path.with_name(name) for name in names]
        return next((File(str(place), place.read_bytes()) for place in places if place.is_file()), None)

    yield CarriedExperiment(results.name, inputs=file(f"{path.stem}_in.csv"), results=file(results.name),
                            options=file(f"{path.stem}_ref.opt", f"{path.stem}.opt"))


def in_manifest(path: Path, files: Mapping[str, bytes]) -> Iterator[CarriedExperiment]:
    """Experiments that the manifest lists, and the default experiment for results that none of them refers to."""
    root = parsed_xml(File(f"{path}: {MANIFEST}", files[MANIFEST]), "fmiReferences")
    listed: dict[str, list[tuple[str, Element]]] = {"experiment": [], "result": []}
    for related in root.iter("Related"):
        role = related.get("role", "")
        kind = related.get("type", "application/octet-stream")
        source = related.get("source")
        if source is None:
            raise FmuError(f"{path}: {MANIFEST}: an element Related has no source, expected the name of a file")
        fits = kind == CSV_TYPE if role == "result" else kind in EXPERIMENT_TYPES or source.endswith(".exp")
        if fits and role.partition("/")[0] in listed and role != "experiment/uncertainty-analysis":
            listed[role.partition("/")[0]].append((source, related))
    used: set[str | None] = set()
    for source, _ in listed["experiment"]:
        try:
            elements = list(parsed_xml(carried_file(path, source, MANIFEST, files), "Experiments").iter("Experiment"))
        except FmuError as error:
            yield CarriedExperiment(source, problem=str(error).removeprefix(f"{path}: "))
            continue
        place = str(place_of(source, MANIFEST))
        for element in elements:
            references = element.find("References")   # of this experiment, also where it cannot be run
            used.add(None if references is None else place_of(references.get("source", ""), place))
            try:
                found = experiment(path, place, element, files)
            except FmuError as error:
                found = CarriedExperiment(element.get("name", ""), problem=str(error))
            yield found
    for source, related in listed["result"]:
        if place_of(source, MANIFEST) in used - {None}:
            continue
        label = related.get("description") or source
        try:
            results = carried_file(path, source, MANIFEST, files)
        except FmuError as error:
            yield CarriedExperiment(label, problem=str(error))
        else:
            yield CarriedExperiment(label, results=results, options=options_beside(path, results, files))


def experiment(path: Path, place: str, element: Element, files: Mapping[str, bytes]) -> CarriedExperiment:
    """An experiment of an experiments file; FmuError where it cannot be run."""
    label = element.get("name", "")
    kinds = [child.tag for child in element if child.tag[0].isupper()]
    transient = element.find("TransientSimulation")
    analyses = [kind for kind in kinds if kind not in ("TransientSimulation", "Parameters", "Stimuli", "References",
                                                       "Annotations")]
    if analyses:
        raise FmuError(f"{place}: {analyses[0]}, expected TransientSimulation: no other kind of experiment is run")
    times = {**element.attrib, **(transient.attrib if transient is not None else {})}
    by_tag: dict[str, File] = {}
    for tag, kind in (("Parameters", SSV_TYPE), ("Stimuli", CSV_TYPE), ("References", CSV_TYPE)):
        child = element.find(tag)
        if child is None:
            continue
        if (given := child.get("type", kind)) != kind:
            raise FmuError(f"{place}: {tag} are of type {given}, expected {kind}")
        by_tag[tag] = carried_file(path, child.get("source", ""), place, files)
    if "References" not in by_tag:
        raise FmuError(f"{place}: experiment {label} has no References, expected some to compare with")
    numbers = {key: finite_number(place, key, times[key]) for key in ("startTime", "stopTime", "stepSize", "tolerance")
               if key in times}
    return CarriedExperiment(label, numbers.get("startTime"), numbers.get("stopTime"), numbers.get("stepSize"),
                             numbers.get("tolerance"), by_tag.get("Parameters"), by_tag.get("Stimuli"),
                             by_tag["References"], options_beside(path, by_tag["References"], files))


def finite_number(place: str, key: str, text: str) -> float:
    """A number of an experiments file: finite, and positive except for times."""
    positive = key in ("stepSize", "tolerance")
    if not is_finite(text) or (positive and float(text) <= 0.0):
        raise FmuError(f"{place}: {key} = {shortened(text)}, expected a finite number"
                       f"{', more than zero' if positive else ''}")
    return float(text)


def options_beside(path: Path, results: File, files: Mapping[str, bytes]) -> File | None:
    """Tolerances next to results, NAME_ref.opt next to NAME_ref.csv, if there are any."""
    name = f"{results.place.removeprefix(f'{path}: ').removesuffix('.csv')}.opt"
    return File(f"{path}: {name}", files[name]) if name in files else None


def place_of(source: str, base: str) -> str | None:
    """Return the name in the archive for a URI of the file `base`; None if there is none."""
    parts = urlsplit(source)
    if parts.scheme or parts.netloc or not parts.path:
        return None
    name = normpath(f"{base.rpartition('/')[0]}/{unquote(parts.path)}")
    return None if name.startswith(("..", "/")) else name


def carried_file(path: Path, source: str, base: str, files: Mapping[str, bytes]) -> File:
    """File of an FMU that a URI in the file `base` means; FmuError if there is none."""
    name = place_of(source, base)
    if name is not None and name in files:
        return File(f"{path}: {name}", files[name])
    others = [name.removeprefix(FOLDER) for name in files if name != MANIFEST]
    hint = f"; {nearest(source, others)}" if others else ""
    raise FmuError(f"{base}: names the file {shortened(source)}, which is not in the FMU{hint}")


def parsed_xml(file: File, tag: str | None = None) -> Element:
    """Root of an XML file, which may have to be a certain element."""
    try:
        root = fromstring(file.data)
    except (ParseError, ValueError, LookupError) as error:
        raise FmuError(f"{file.place}: {error}, expected XML") from None
    if tag not in (None, root.tag):
        raise FmuError(f"{file.place}: the root element is {root.tag}, expected {tag}")
    return root

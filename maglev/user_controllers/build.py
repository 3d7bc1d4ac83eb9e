"""FMUs of a user's class: the file and the modules beside it, under names of their own, and what goes around them."""

import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module, invalidate_caches
from operator import attrgetter
from pathlib import Path
from typing import Any

from fmi_export.definition import FmuDefinition
from fmi_export.errors import ExportError
from fmi_export.native.build import layer_names
from fmi_export.sources import carried_modules, defined_names
from fmi_export.user_classes.declaration import WrittenDefinition
from fmi_export.user_classes.sampled_block import FIRST_PORT, STEP_MISFIT, STEPPED
from fmi_export.user_classes.trouble import OWN
from maglev.errors import BuildError
from maglev.rig.writer import environment
from maglev.user_controllers.own_modules import OwnModules, own_name
from maglev.user_controllers.source import file_of, load, read_modules
from maglev.user_controllers.subset import always_ends, misfits, without_tables
from maglev_files.scratch import scratch

FMU = OWN + "fmu"       # module that has the definition in an FMU
BLOCK = OWN + "block"   # module that has the block in a native one

# A message of pyccel's: severity, stage, file, line, and what is wrong.
PYCCEL = re.compile(r"\|\s*\w+ \[\w+\]: (\w+)\.py(?: \[(\d+)(?:,\d+)?\])?\| ?"
                    r"(.*?)(?= Pyccel has| Traceback| \||$)")
UNUSED_PARTS = re.compile(r"^ +\w+__del__\(\w+\);\n", re.MULTILINE)


@dataclass(frozen=True)
class Buildable:
    """A user's class ready to be built, for as long as its modules can be imported; or an FMU of this project."""

    definition: FmuDefinition   # with a block in pyccel's subset, if it is to be native
    packages: tuple[str, ...]   # the user's modules, and what was written around them, by their names in the FMU
    files: dict[str, str]       # names of the user's files by those of the modules
    ends: bool = False          # whether every step ends, whatever the values: known of native ones


@contextmanager
def buildable(path: Path, parts: tuple[str, ...], native: bool) -> Iterator[Buildable]:
    """Make the class that a path names ready to be built, as C if `native`.

    The path is that of a Python file, perhaps with the name of a class in it; `parts` are the packages of this project
    that an FMU carries. ControllerError if there is no such file or class, or it does not fit; BuildError if an FMU
    cannot have what is in it; with file and line.
    """
    file, definition = file_of(path)[0], load(path).definition
    name, modules = definition.name, read_modules(file)
    for problem in modules.problems:
        raise BuildError(problem)
    texts = {module: own.renamed for module, own in modules.modules.items()}
    files = {module: own.file.name for module, own in modules.modules.items()}
    main = own_name(file.stem)
    if native:
        require_subset(modules, name)
        require_floats(definition, file)
        texts[main] = without_tables(texts[main], name)
    else:
        texts[FMU] = environment().get_template("written/definition.py.j2").render(
            name=name, module=main, requires=modules.requires)
    with importable(texts) as folder:
        if not native:
            yield Buildable(replace(definition, requires=modules.requires), tuple(texts), files)
            return
        (folder / f"{BLOCK}.py").write_text(native_block(definition, getattr(import_module(main), name)()),
                                            encoding="utf-8", newline="\n")
        invalidate_caches()
        require_own_names(modules, carried_modules(BLOCK, (*parts, *texts, BLOCK)))
        block = getattr(import_module(BLOCK), f"{name}Block")
        yield Buildable(replace(definition, block=block, arguments=()), (*texts, BLOCK), files,
                        always_ends(texts.values()))


@contextmanager
def importable(texts: Mapping[str, str]) -> Iterator[Path]:
    with scratch() as folder:
        for module, text in texts.items():
            (folder / f"{module}.py").write_text(text, encoding="utf-8", newline="\n")
        sys.path.insert(0, str(folder))
        invalidate_caches()
        try:
            yield folder
        finally:
            sys.path.remove(str(folder))
            for module in (*texts, BLOCK):
                sys.modules.pop(module, None)


def require_subset(modules: OwnModules, name: str) -> None:
    """Refuse the first line that a native FMU cannot have."""
    for module in modules.modules.values():
        if misfit := min(misfits(module.renamed, name), default=None):
            line, what = misfit
            raise BuildError(f"{module.file.name}, line {line}: a native FMU cannot have {what}; one that "
                             "runs Python can")


def require_floats(definition: WrittenDefinition, file: Path) -> None:
    """Refuse whole numbers where an FMU has Reals: C keeps the type that an attribute begins with."""
    law = definition.new_block()
    for v in definition.variables:
        value = v.read(law)
        if not v.boolean and type(value) is not float:
            raise BuildError(f"{file.name}: {v.name} starts as {value!r}, a native FMU needs a float: expected "
                             f"{float(value)!r}")


def require_own_names(modules: OwnModules, carried: Mapping[str, str]) -> None:
    """Refuse names that two modules define: in C there is but one of each."""
    places = dict.fromkeys(layer_names(), "the C around it")
    for module, text in carried.items():
        file = modules.modules[module].file.name if module in modules.modules else module
        for name, line in defined_names(text).items():
            place = f"{file}, line {line}"
            if places.setdefault(name, place) != place:
                mine, other = sorted((place, places[name]), key=lambda place: ".py" not in place)
                raise BuildError(f"{mine}: {name} is also defined in {other}, a native FMU needs names of their own: "
                                 "expected another one")


@contextmanager
def named_lines(modules: Mapping[str, str]) -> Iterator[None]:
    """Say what pyccel refuses with the user's file and line; names of files by the modules in the FMU."""
    try:
        yield
    except ExportError as error:
        for module, line, what in PYCCEL.findall(str(error)):
            if module in modules:
                place = f"{modules[module]}, line {line}" if line else modules[module]
                words = ("pyccel fails on it; a simpler line or another name may help" if "INTERNAL" in what else
                         f"pyccel says: {what.strip()}")
                raise BuildError(f"{place}: a native FMU cannot have this, {words}; one that runs Python "
                                 "can") from error
        raise


def finished(translation: Mapping[str, str], own: tuple[str, ...]) -> dict[str, str]:
    """C files, with those of the user's modules rid of pyccel's calls at the end of a name for a part.

    They only mark the part, which lives on; and if the name was given in an if that was not taken, they mark anything.
    """
    return {name: UNUSED_PARTS.sub("", text) if name.removesuffix(".c") in own else text
            for name, text in translation.items()}


def native_block(definition: WrittenDefinition, law: Any) -> str:
    """Text of a module with the block NAMEBlock; the law is one of the class, of a module with its name in the FMU."""
    ports = [v.place.removeprefix("law.") for v in definition.variables if v.causality == "output" and not v.boolean]
    return environment().get_template("written/block.py.j2").render(
        name=definition.name, imports=own_imports(law, ports), each_step=definition.variable_step,
        starts=hasattr(type(law), "start"), ports=ports, first=FIRST_PORT, misfit=STEP_MISFIT, stepped=STEPPED)


def own_imports(law: Any, ports: Iterable[str]) -> list[str]:
    """Imports of the class and of those of its parts that have outputs, which pyccel has to know."""
    parts = {type(attrgetter(".".join(parts[:depth]))(law)) for port in ports for parts in [port.split(".")]
             for depth in range(1, len(parts))}
    return sorted({f"from {part.__module__} import {part.__name__}" for part in (type(law), *parts)})

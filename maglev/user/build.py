"""FMUs of a user's class: the file and the modules next to it, under names of their own, and the files around them."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import invalidate_caches
from pathlib import Path

from maglev.descriptions.writer import environment
from maglev.files.errors import BuildError
from maglev.files.packages import IN_FMUS
from maglev.files.scratch import scratch
from maglev.fmi.declaration import WrittenDefinition
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.native_build import own_code
from maglev.fmi.trouble import OWN
from maglev.language.layout import Layout
from maglev.language.program import Untranslatable
from maglev.language.texts import place_of_attribute
from maglev.user.own_modules import own_name
from maglev.user.source import PythonFile

FMU = OWN + "fmu"       # module that has the definition in an FMU

@dataclass(frozen=True)
class Buildable:
    """A user's class ready to be built, for as long as its modules can be imported; or an FMU of this project."""

    definition: FmuDefinition   # with a block in the language of blocks, if it is to be native
    texts: Mapping[str, str]    # of the user's modules, and of the files around them, by their names in the FMU


@contextmanager
def buildable(source: PythonFile, native: bool) -> Iterator[Buildable]:
    """Make a class in a Python file ready to be built, as C if `native`.

    ControllerError if there is no such file or class, or it does not fit; BuildError if an FMU cannot have what is in
    it; with file and line.
    """
    file, definition, modules = source.path, source.load().definition, source.modules()
    name = definition.name
    for problem in modules.problems:
        raise BuildError(problem)
    texts = {module: own.renamed for module, own in modules.modules.items()}
    if native:
        require_language(definition, file)
        yield Buildable(definition, texts)
        return
    texts[FMU] = environment().get_template("written/definition.py.j2").render(
        name=name, module=own_name(file.stem), requires=modules.requires)
    with importable(texts):
        yield Buildable(replace(definition, requires=modules.requires), texts)


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
            for module in texts:
                sys.modules.pop(module, None)


def require_language(definition: WrittenDefinition, file: Path) -> None:
    """Raise BuildError, with the line, for a class that is not of the language of blocks."""
    with language_errors():
        require_types(definition, file)
        own_code(definition, IN_FMUS)


@contextmanager
def language_errors() -> Iterator[None]:
    """Add to errors about the language of blocks that an FMU that runs Python has no such limit."""
    try:
        yield
    except Untranslatable as error:
        raise BuildError(f"{error}; native FMUs need this") from error


def require_types(definition: WrittenDefinition, file: Path) -> None:
    """Raise for attributes that C cannot have, and for whole numbers where an FMU has Reals, with their line."""
    block = definition.new_block()
    Layout(block.law, str)
    for v in definition.variables:
        value = v.read(block)
        if not v.boolean and type(value) is not float:
            place = place_of_attribute(type(block.law), v.place.replace("law", "self", 1)) or f"{file.name}: "
            raise Untranslatable(f"{place}{v.name} starts as {value!r}: expected {float(value)!r}")

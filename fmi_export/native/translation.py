"""Blocks as C: pyccel translates their modules, and what it leaves to be done at run time is done here.

pyccel keeps the constants of a module in global variables that a function of the module fills. Here they become
constants, with the values that Python has computed, and the functions go: nothing is left that instances could share.
"""

import os
import re
import shutil
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from importlib.metadata import version
from math import isinf
from pathlib import Path

from fmi_export.errors import ExportError
from fmi_export.sources import imported_modules
from maglev_files.cache import TRANSLATIONS, keep, kept, key_of
from maglev_files.extras import lacking
from maglev_files.programs import output_of
from maglev_files.scratch import scratch

# One process for all modules: starting pyccel takes longer than a translation, and a quarter of that were grammars of
# pragmas, which wait until there is one. What they import is parsed once, for all of them; the C printer renames its
# methods, by whose names the next module looks for them. Half of the time would go to looking for trees that nothing
# holds any more, and to types in the stubs of imported modules, where quoted ones are parsed apart.
TRANSLATE = r"""
import gc, os, re, sys
from functools import cache
from importlib import import_module
from pathlib import Path
from types import SimpleNamespace

@cache
def grammar(name):
    del sys.modules[name]
    return import_module(name)

for name in ("pyccel.parser.syntax.openmp", "pyccel.parser.syntax.openacc"):
    sys.modules[name] = SimpleNamespace(parse=lambda stmts, name=name: grammar(name).parse(stmts=stmts))

from pyccel.codegen.pipeline import execute_pyccel
from pyccel.codegen.printing.ccode import CCodePrinter
from pyccel.parser.parser import Parser

parse, rename = Parser.parse, CCodePrinter.rename_imported_methods
imported, before = {}, []

def rename_for_now(printer, classes):
    for one in classes:
        scopes = [each.scope for each in (one, *one.methods) if each.scope is not None]
        tables = [table for scope in scopes for table in (scope.python_names, scope.local_used_symbols)]
        before.append(([(table, dict(table)) for table in tables], [(method, method.name) for method in one.methods]))
    rename(printer, classes)

Parser.parse = lambda parser, *, verbose, d_parsers_by_filename=imported: parse(
    parser, verbose=verbose, d_parsers_by_filename=d_parsers_by_filename)
CCodePrinter.rename_imported_methods = rename_for_now
gc.disable()
root = os.getcwd()
for path in map(Path, sys.argv[1:]):
    os.chdir(root)
    execute_pyccel(os.path.join(root, path), convert_only=True, language="c")
    while before:
        tables, methods = before.pop()
        for table, names in tables:
            table.clear()
            table.update(names)
        for method, name in methods:
            method.rename(name)
    stub = Path(root, path.parent, "__pyccel__", f"{path.stem}.pyi")
    stub.write_text(re.sub(r"'(\w+)'", r"\1", stub.read_text(encoding="utf-8")), encoding="utf-8")
"""

DECLARED = re.compile(r"^extern (double|int64_t|bool) (\w+);$", re.MULTILINE)
INITIALISER = re.compile(r"^/\*\.+\*/\nvoid \w+__init\(void\)\n\{\n.*?^\}\n/\*\.+\*/\n", re.MULTILINE | re.DOTALL)
FUNCTION = re.compile(r"^(\w[\w *]*)\(([^()\n]*)\)\n\{\n(.*?)^\}$", re.MULTILINE | re.DOTALL)
LOCAL = re.compile(r"^    (?:double|int64_t|bool) (\w+);\n", re.MULTILINE)

# A function of a block, at the beginning of a line.
HEAD = re.compile(r"^(?=(?:double|int64_t|bool|void) \w+\()", re.MULTILINE)

# A method of a part that most stages have off: as part of its callers it keeps these from becoming part of theirs.
SELDOM = re.compile(r"^BLOCK_FUNCTION (?=double Roughness__acceleration\()", re.MULTILINE)

TEMPLATES = Path(__file__).with_name("templates")   # C files with places for what follows from a block, or with none

PRELUDE_FILE = "block_math.h"   # of the translated blocks
ENDINGS = (".c", ".h", ".pyi")   # of what pyccel makes of a module


def translate_modules(texts: Mapping[str, str]) -> dict[str, str]:
    """C files, by name, of Python modules in pyccel's subset.

    `texts` has, by dotted name, every module that one of them imports, but `math`. Those with constants can be imported
    as well. ExportError if pyccel is not installed, refuses a module, or writes something that is not known here.
    """
    if missing := lacking("pyccel", "native", "a native FMU"):
        raise ExportError(missing)
    files = {PRELUDE_FILE: (TEMPLATES / PRELUDE_FILE).read_text(encoding="utf-8")}
    with scratch() as root:
        names = imported_first({name: [other for other in imported_modules(name, text) if other in texts]
                                for name, text in texts.items()})
        for name in names:
            path = root / f"{name.replace('.', '/')}.py"
            path.parent.mkdir(parents=True, exist_ok=True)
            (path.parent / "__init__.py").touch()
            path.write_text(texts[name], encoding="utf-8")
        translate(root, [f"{name.replace('.', '/')}.py" for name in names])
        for name in names:
            package, _, stem = name.rpartition(".")
            generated = root / package.replace(".", "/") / "__pyccel__" / stem
            header = generated.with_suffix(".h").read_text(encoding="utf-8")
            source = generated.with_suffix(".c").read_text(encoding="utf-8")
            constants = [constant for _, constant in DECLARED.findall(header)]
            files[f"{stem}.h"] = finished_header(header, name)
            files[f"{stem}.c"] = finished_source(name, source, constants)
    return files


def module_files(modules: Iterable[str], translation: Mapping[str, str]) -> dict[str, str]:
    """Those of the translated files, by name, that belong to modules by dotted name."""
    names = [f"{module.rpartition('.')[2]}{ending}" for module in modules for ending in (".h", ".c")]
    return {name: translation[name] for name in (PRELUDE_FILE, *names)}


def imported_first(imports: Mapping[str, Iterable[str]]) -> list[str]:
    """Names of modules or headers, each after those that it imports."""
    sorter = TopologicalSorter(imports)
    try:
        sorter.prepare()
    except CycleError as error:
        raise ExportError(f"modules {', '.join(error.args[1])} import each other, expected an order") from None
    ordered: list[str] = []
    while sorter.is_active():
        ready = sorted(sorter.get_ready())   # the order of a set would depend on the hash seed
        ordered += ready
        sorter.done(*ready)
    return ordered


def translate(root: Path, paths: Iterable[str]) -> None:
    """Translate files below a folder, each after those that it imports; what was before is in the user's cache.

    A module is known by its text, by those of all that it imports, and by what translates it.
    """
    keys: dict[str, str] = {}   # by module
    new = []
    for path in map(Path, paths):
        name = ".".join(path.with_suffix("").parts)
        text = (root / path).read_text(encoding="utf-8")
        below = [keys[module] for module in imported_modules(name, text) if module in keys]
        keys[name] = key_of(TRANSLATIONS, version("pyccel"), TRANSLATE, sys.version_info[:2], name, text, below)
        found = {ending: kept(keys[name], path.stem + ending) for ending in ENDINGS}
        if not all(found.values()):
            new.append(path)
            continue
        place = root / path.parent / "__pyccel__"
        place.mkdir(exist_ok=True)
        for ending, file in found.items():
            if file is not None:
                shutil.copyfile(file.path, place / f"{path.stem}{ending}")   # as of now
    if new:
        run_pyccel(root, map(str, new))
    with suppress(OSError):   # they are translated again, then
        for path in new:
            for ending in ENDINGS:
                made = root / path.parent / "__pyccel__" / f"{path.stem}{ending}"
                keep(keys[".".join(path.with_suffix("").parts)], made.name, made.read_bytes())


def run_pyccel(root: Path, paths: Iterable[str]) -> None:
    # pyccel names its output folder after the worker of a parallel test run, and writes some things in the order of a
    # set, which depends on the hash seed.
    environment = {name: value for name, value in os.environ.items() if name != "PYTEST_XDIST_WORKER"}
    code, printed = output_of([sys.executable, "-c", TRANSLATE, *paths], root,
                              {**environment, "PYTHONPATH": str(root), "PYTHONHASHSEED": "0"})
    if code != 0:
        raise ExportError(f"pyccel cannot translate: {' '.join(printed.split())[-1000:]}")


def finished_header(header: str, module: str) -> str:
    """Header with constants of a module for variables, without the function that fills them, with the FMU's prefix."""
    header = DECLARED.sub(lambda match: f"static const {match[1]} {match[2]} = "
                                        f"{c_literal(getattr(import_module(module), match[2]))};", header)
    header = re.sub(r"^void \w+__init\(void\);\n", "", header, flags=re.MULTILINE)
    included = f'\n#include "prefix.h"\n#include "{PRELUDE_FILE}"'
    header = re.sub(r"^#define \w+_H\n", lambda match: match[0] + included, header, count=1, flags=re.MULTILINE)
    return marked(header.replace("#include <math.h>\n", ""))


def c_literal(value: float | int | bool) -> str:
    """C literal of a number, with the same value."""
    if isinstance(value, float):
        if isinf(value):
            return "INFINITY" if value > 0.0 else "-INFINITY"
        return repr(value)
    return str(int(value)) if isinstance(value, bool) else f"INT64_C({value})"


def finished_source(name: str, source: str, constants: Iterable[str]) -> str:
    """Source without global variables, without the function that fills them, and without unused locals."""
    for constant in constants:
        source = re.sub(rf"^\w+ {constant};\n", "", source, flags=re.MULTILINE)
    source = INITIALISER.sub("", source.replace("bool initialised = 0;\n", ""))
    source = FUNCTION.sub(used_names_only, source)
    if re.search(r"initialised|__init\(|(?m:^(double|int64_t|bool) \w+( =.*)?;)", source):
        raise ExportError(f"{name}: the C that pyccel has made of it has global variables, expected none to be left")
    return marked(source)


def marked(text: str) -> str:
    """Text whose functions say, before their types, that they are a block's, and which of them are called seldom."""
    return SELDOM.sub("SELDOM_CALLED ", HEAD.sub("BLOCK_FUNCTION ", text))


def used_names_only(function: re.Match[str]) -> str:
    """A function without the local variables that nothing uses; parameters that nothing uses are marked."""
    head, parameters, body = function.groups()

    def uses(name: str) -> int:
        return len(re.findall(rf"\b{name}\b", body))

    for local in LOCAL.findall(body):
        if uses(local) == 1:
            body = re.sub(rf"^    \w+ {local};\n", "", body, flags=re.MULTILINE)
    names = [] if parameters == "void" else [parameter.split()[-1].lstrip("*") for parameter in parameters.split(",")]
    unused = "".join(f"    (void){name};\n" for name in names if not uses(name))
    return f"{head}({parameters})\n{{\n{unused}{body}}}"

"""Errors that users can correct, as opposed to bugs: one root class, and the words that all messages share.

    MaglevError
    ├── ScenarioError          a scenario file, a port map or an option cannot be used
    ├── StageError               a description of a stage cannot be used
    ├── QuantityError          a number, a unit or a dimension (also a ValueError: so that pydantic reports it)
    ├── UnknownName            a column or entry that does not exist (also a KeyError)
    ├── FmuError               an FMU cannot be loaded, or refused a call
    ├── RunFailed              a co-simulation ended early; the recording until then is in `cosim.master`
    ├── MeasurementError       a recording on which nothing can be measured or judged
    ├── CsvError               a CSV file that cannot be read, or has no numbers where it should
    ├── BaselineError          a baseline that is missing or cannot be used
    ├── IdentificationError    data, settings or a model file of an identification
    ├── ControllerError        a Python file or class that cannot be run
    ├── LinearModelError       an operating point, a parameter or a signal at which nothing can be linearised
    ├── StabilityError         a loop whose region of stability cannot be computed
    └── BuildError             an FMU cannot be built

    KeyboardInterrupt
    └── Interrupted            Ctrl-C or SIGTERM ended the work
        ├── RunInterrupted     the same in a co-simulation; the recording until then is in `cosim.master`
        └── BatchInterrupted   the same in `maglev.batch`; the finished samples are in its `batch`

Code that catches `MaglevError` catches all mistakes of users. Any other exception except OSError is a bug of this
package.
"""

import copyreg
import json
import re
import signal
from collections.abc import Collection, Iterable, Sequence
from difflib import get_close_matches
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from unicodedata import category

LONGEST_VALUE = 80   # characters of an offending value in a message
MOST_NAMED = 3       # names in a row, where there are many

HIDDEN = ("Cc", "Cf", "Cs")   # categories of control characters, such that reorder or join others, and surrogates


def option(name: str, value: object = None) -> str:
    """Return an option as messages write it, in Python and on the command line alike: step = -1."""
    if isinstance(value, dict):
        return f"{name}: {', '.join(f'{key} = {entry}' for key, entry in value.items())}"
    return name if value is None or isinstance(value, bool) else f"{name} = {value}"


def or_of_own_stage() -> str:
    """Return the alternative to the name of an FMU of this project, for a message."""
    return f"or one of your own stage, with {option('stage', 'mine.toml')}"


class Sendable:
    """An error that can be pickled whatever it is made of, because it may end the work of another process."""

    def __reduce__(self) -> tuple[Any, ...]:   # an exception would be made again of its message alone
        return copyreg.__newobj__, (type(self), *self.args), vars(self)   # type: ignore[attr-defined]


class MaglevError(Sendable, Exception):
    """A mistake that the user of this package can correct; one line with the name, its value and the expected value."""


class ScenarioError(MaglevError):
    """A scenario, port map or option that cannot be used; one line with file, key, value and expected value."""


class QuantityError(MaglevError, ValueError):
    """A quantity that is no finite number, has no known unit, or is of another dimension than needed."""


class UnknownName(MaglevError, KeyError):
    """A name that does not exist where it was looked up; the message has the nearest one that does."""

    __str__ = Exception.__str__   # a KeyError puts its message in quotes


class FmuError(MaglevError):
    """An FMU that cannot be loaded, or that failed in a call; the message has the FMU's own words."""


class MeasurementError(MaglevError):
    """A recording on which nothing can be measured or judged."""


class CsvError(MaglevError):
    """A CSV file that cannot be read: `problem` is the message without the file, which goes before it."""

    def __init__(self, path: Path, problem: str):
        super().__init__(f"{path}: {problem}")
        self.problem = problem


class BaselineError(MaglevError):
    """A baseline that cannot be used; one line with file, line, value and expected value."""


class IdentificationError(MaglevError):
    """Data, settings or a model file that cannot be used; one line with file, key or column, value and expectation."""


class LinearModelError(MaglevError):
    """An operating point that cannot be linearised: no equilibrium, an unknown axis, parameter or signal."""


class ControllerError(MaglevError):
    """A Python file or class that cannot be run; one line with file, line and the expected code."""


class StabilityError(MaglevError):
    """A loop whose region of stability cannot be computed: unstable, without a limit, or without a solver."""


class BuildError(MaglevError):
    """An FMU that cannot be built."""


class Interrupted(Sendable, KeyboardInterrupt):
    """Ctrl-C or SIGTERM ended the work; one line that names the finished part.

    It is no MaglevError: a program that continues after a mistake should not continue after Ctrl-C.
    """

    def __init__(self, message: str = "interrupted", number: int = signal.SIGINT):
        super().__init__(message)
        self.number = number


def signal_of(error: KeyboardInterrupt) -> int:
    return error.number if isinstance(error, Interrupted) else signal.SIGINT


def ended_by(error: KeyboardInterrupt) -> str:
    """Return the words for the effect of the signal behind an error."""
    return "terminated" if signal_of(error) == signal.SIGTERM else "interrupted"


FAILURES = (MaglevError, OSError)   # mistakes that users can correct; all others are bugs


def nearest(name: object, valid: Iterable[str], *endings: str) -> str:
    """Return "nearest is 'y.mass'": the file that has this name and one of the endings, or the most similar valid name.

    If none is similar, return the valid names: "there are 'y.mass', 'y.bias', 'y.start' and 9 others".
    """
    names = [*valid]
    if like := most_like(name, names, *endings):
        return f"nearest is {like[0]!r}"
    return f"there {'are' if len(names) > 1 else 'is'} {few([*map(repr, names)]) or 'none'}"


def most_like(name: object, valid: Iterable[str], *endings: str) -> list[str]:
    """Return files that have this name and one of the endings, then the most similar valid name, if one is similar."""
    known = {each.casefold(): each for each in valid}   # 0.52: for slots it is slot_width
    return [*[f"{name}{ending}" for ending in endings if Path(f"{name}{ending}").is_file()],
            *[known[like] for like in get_close_matches(str(name).casefold(), known, n=1, cutoff=0.52)]]


def one_of(name: object, valid: Collection[str], otherwise: str = "", *endings: str) -> str:
    """Return the valid names, and those similar to a wrong one: "one of a, b; nearest is 'a'"."""
    return f"one of {', '.join([*valid, *filter(None, [otherwise])])}{similar(name, valid, *endings)}"


def similar(name: object, valid: Iterable[str], *endings: str) -> str:
    """Return "; nearest is 'a'" after a list of valid names; an empty text if none is similar."""
    return "".join(f"; nearest is {known!r}" for known in most_like(name, valid, *endings)[:1])


def require_table(given: Any, place: str, error: type[MaglevError], like: str) -> None:
    """Raise if a value given from Python has no values by name where a table is expected."""
    if not hasattr(given, "items") or not all(isinstance(name, str) for name, _ in given.items()):
        raise error(f"{place} = {shortened(given)}, expected a table, values by name, such as {like}")


def nearest_file(path: Path, ending: str = "") -> str:
    """Name the file next to a missing one with the most similar name and, if it has one, the same ending."""
    if path.exists() or not path.parent.is_dir():
        return ""
    ending = path.suffix or ending
    files = sorted(entry.name for entry in path.parent.iterdir() if entry.is_file() and entry.suffix == ending)
    return f", {nearest(path.name, files)}" if files else ""


def few(names: Sequence[str]) -> str:
    """Names in a row, not too many."""
    shown = ", ".join(names[:MOST_NAMED])
    more = len(names) - MOST_NAMED
    return shown if more <= 0 else f"{shown} and {more} other{'s' * (more > 1)}"


def visible(text: str) -> str:
    """Return the text with escapes instead of control characters other than line ends and tabs.

    A terminal would obey them, others hide or reorder what a person reads, and half of a surrogate pair is no text.
    """
    if text.isprintable():
        return text
    return "".join(letter.encode("unicode_escape").decode() if letter not in "\n\t" and category(letter) in HIDDEN
                   else letter for letter in text)


def in_one_line(text: object) -> str:
    """Message of an error, or another text, in one line without control characters; of a file its name goes before."""
    if isinstance(text, OSError) and text.filename is not None and text.strerror:
        wanted = ", expected a folder" if isinstance(text, FileExistsError) else ""   # raised if a file has this name
        text = f"{text.filename}: {text.strerror}{wanted}"
    return visible(" ".join(str(text).split()))


def shortened(value: object) -> str:
    """Return the value as it would be written, in one line and cut to a readable length."""
    text = repr(value)
    text = in_one_line(text) if "\n" in text else text   # of an array
    return text if len(text) <= LONGEST_VALUE else text[:LONGEST_VALUE] + "…"


def size_text(size: float) -> str:
    """Return a number of bytes as people say it, such as "23 kB"."""
    for power, unit in ((9, "GB"), (6, "MB"), (3, "kB")):
        if size >= 0.9995 * 10.0**power:
            return f"{size / 10.0**power:.3g} {unit}"
    return f"{size:.0f} bytes"


def key_path(keys: Sequence[str | int]) -> str:
    """Write keys as TOML does, list entries in brackets."""
    path = ""
    for key in keys:
        name = f"[{key}]" if isinstance(key, int) else key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else quoted(key)
        path += name if isinstance(key, int) or not path else f".{name}"
    return path


def quoted(key: str) -> str:
    """Write a key in quotes as TOML does, in one line and without invisible characters."""
    return "".join(letter if letter.isprintable() else f"\\U{ord(letter):08x}"
                   for letter in json.dumps(key, ensure_ascii=False))


class StageError(MaglevError):
    """A description of a stage that cannot be used; one line with file, key, value and expected value."""


def installing(extra: str) -> str:
    """Return the command that installs an extra where this package is installed; pip then looks on no index."""
    return f"python -m pip install 'maglev-fmus[{extra}]'"


def lacking(module: str, extra: str, user: str) -> str:
    """Return the message that a needed module of an extra is missing, and the remedy; empty if it is installed."""
    package = module.partition(".")[0]
    if find_spec(package) is not None:
        return ""
    return f"{user} needs {package}; install it with the Python that runs maglev: {installing(extra)}"


def extra(module: str, name: str, user: str = "this", error: type[MaglevError] = MaglevError) -> Any:
    """Import a module of an extra of this package; without it an error names the need for it, and the remedy."""
    if missing := lacking(module, name, user):
        raise error(missing)
    return import_module(module)

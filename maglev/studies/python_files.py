"""Python files of a study's scenario for its workers: they have none of the user's files, but take any FMU."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from maglev.catalogue import HOST, Kind, build_written
from maglev.errors import BuildError
from maglev.schema.run_plan import RunPlan
from maglev.user_controllers.source import is_written
from maglev_files.scratch import scratch

Given = str | Path | None


@contextmanager
def built(plan: RunPlan, put_in: dict[str, Given], native: bool, everywhere: bool,
          say: Callable[[str], None]) -> Iterator[tuple[RunPlan, dict[str, Given]]]:
    """FMUs in place of Python files, while the block lasts: those of a plan, and those that are put in by name.

    With `native` they are that, too, where they can be, and `say` is told why one cannot; with `everywhere` such a one
    has binaries for all platforms, not only for this machine. ControllerError or BuildError if there is no such file or
    class, or no FMU of it.
    """
    named = {name: fmu.file for name, fmu in plan.fmus.items() if put_in.get(name) is None and fmu.file is not None}
    written = {str(path) for path in (*named.values(), *put_in.values()) if is_written(Path(str(path)))}
    with scratch() as folder:
        made = {path: fmu_of(path, folder / str(number), native, everywhere, say)
                for number, path in enumerate(sorted(written))}
        fmus = {name: fmu.model_copy(update={"file": str(made[named[name]])}) if named.get(name) in made else fmu
                for name, fmu in plan.fmus.items()}
        yield (plan.model_copy(update={"fmus": fmus}),
               {name: made.get(str(given), given) for name, given in put_in.items()})


def fmu_of(path: str, folder: Path, native: bool, everywhere: bool, say: Callable[[str], None]) -> Path:
    """Build the FMU of a Python file into a folder of its own: several files can have classes of one name."""
    folder.mkdir()
    if native:
        try:
            return build_written(Path(path), folder, Kind(native=True) if everywhere else HOST)
        except BuildError as error:
            say(f"{path} runs in Python, which takes its time, for it cannot be native: {error}")
    return build_written(Path(path), folder)

"""What there is to build and to run."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from maglev.catalogue import DEFINITIONS, SYSTEMS, build_native, definition
from maglev.catalogue import build as build_in_python
from maglev.errors import ScenarioError
from maglev.schema.layers import merged, packaged_files, run_layers


@dataclass(frozen=True)
class FmuEntry:
    """An FMU, or a system of FMUs, that this package builds: name, ending of its file, and what it is."""

    name: str
    ending: str
    description: str

    def file(self, fmus: str | Path = "fmus") -> Path:
        """Its file in the folder of the FMUs."""
        return Path(fmus) / f"{self.name}.{self.ending}"


def fmus() -> list[FmuEntry]:
    """FMUs and systems that `build` makes.

    Examples
    --------
    >>> import maglev
    >>> [entry.name for entry in maglev.fmus()][:2]
    ['Plant2DOF', 'Plant3DOF']
    """
    found = [FmuEntry(name, "fmu", definition(name).description) for name in DEFINITIONS]
    return found + [FmuEntry(name, "ssp", f"plant and controller of {scenario}, connected (SSP)")
                    for name, scenario in SYSTEMS.items()]


@dataclass(frozen=True)
class RunEntry:
    """A run that comes with the package: its name, the scenario that it is of, its title, the thesis's figures."""

    name: str
    scenario: str
    title: str
    figures: tuple[str, ...]


def scenarios() -> list[RunEntry]:
    """Runs that come with the package, in the order of their scenarios.

    Examples
    --------
    >>> import maglev
    >>> [run.name for run in maglev.scenarios() if run.scenario == "2dof-step-4"]
    ['2dof-step-4-nonlinear', '2dof-step-4-linear']
    """
    return [RunEntry(run["name"], scenario, run["title"], tuple(run.get("figures", ())))
            for scenario, path in packaged_files().items() for run in map(merged, run_layers(path))]


def build(names: Iterable[str] = (), *, fmus: str | Path = "fmus", native: bool = False,
          target: str = "all") -> list[Path]:
    """Build FMUs from the blocks; the same sources give the same bytes.

    Parameters
    ----------
    names : iterable of str, optional
        Names of `fmus()`; all if not given.
    fmus : path
        Folder for the files, made if it is not there.
    native : bool
        FMUs that need no Python, into the folder's folder `native`; needs the extra `native`.
    target : "all" or "host"
        With `native`: binaries for Linux, Windows and macOS, or one for this machine.

    Returns
    -------
    list of Path
        The files.

    Raises
    ------
    MaglevError
        If a name does not exist, or something is missing that is needed to build.

    Examples
    --------
    >>> import maglev
    >>> [path.name for path in maglev.build(["PID3DOF"])]
    ['PID3DOF.fmu']
    """
    if target not in ("all", "host") or (target == "host" and not native):
        raise ScenarioError(f"--target {target}: expected all or host, and --native with it")
    chosen = list(names) or [*DEFINITIONS, *SYSTEMS]
    if native:
        return build_native(chosen, Path(fmus) / "native", target == "host")
    return build_in_python(chosen, Path(fmus))

"""FMUs for the tests, built once."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from native_builds import built_once, require_native_tools

from maglev.catalogue import DEFINITIONS, build, build_native
from maglev.cosim.fmu import Fmu, read_description

NAMES = tuple(DEFINITIONS)

# No deadline: a loaded machine is no failure. In CI always the same examples, so that a failure is the change's.
settings.register_profile("anywhere", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "anywhere")


@pytest.fixture(scope="session")
def fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with every FMU."""
    folder = tmp_path_factory.mktemp("fmus")
    build(NAMES, folder)
    return folder


@pytest.fixture(scope="session")
def native_fmus(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with every FMU as C, for this machine alone."""
    require_native_tools()
    return built_once(tmp_path_factory, "native_fmus", lambda folder: build_native(NAMES, folder, host_only=True))


Load = Callable[[str], Fmu]


def loader(folder: Path) -> Iterator[Load]:
    """Function that instantiates an FMU of a folder by its name; instances are freed after the test."""
    fmus: list[Fmu] = []

    def instantiate(name: str) -> Fmu:
        path = folder / f"{name}.fmu"
        fmus.append(Fmu(name, path, read_description(name, path)))
        return fmus[-1]

    yield instantiate
    for fmu in fmus:
        fmu.close()


@pytest.fixture
def load(fmus: Path) -> Iterator[Load]:
    """Function that instantiates an FMU by its name."""
    yield from loader(fmus)


@pytest.fixture
def load_native(native_fmus: Path) -> Iterator[Load]:
    """The same for a native FMU."""
    yield from loader(native_fmus)


@pytest.fixture(params=["load", "load_native"], ids=["python", "native"])
def load_either(request: pytest.FixtureRequest) -> Load:
    """The same, once for each kind of FMU."""
    function: Load = request.getfixturevalue(request.param)
    return function

"""FMUs for the tests, built once."""

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from scenarios.catalogue import DEFINITIONS, build
from scenarios.component import Component, read_description

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


@pytest.fixture
def load(fmus: Path) -> Iterator[Callable[[str], Component]]:
    """Function that instantiates an FMU by its name; instances are freed after the test."""
    components: list[Component] = []

    def instantiate(name: str) -> Component:
        path = fmus / f"{name}.fmu"
        components.append(Component(name, path, read_description(name, path)))
        return components[-1]

    yield instantiate
    for component in components:
        component.close()

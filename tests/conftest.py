"""FMUs for the tests, built once."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from scenarios.catalogue import DEFINITIONS, build
from scenarios.component import Component, read_description

NAMES = tuple(DEFINITIONS)


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

"""Environments on the native FMUs of the tests."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from environments import environment


@pytest.fixture(scope="session")
def folder(native_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder that has the native FMUs where environments look for them."""
    found = tmp_path_factory.mktemp("environments")
    (found / "native").symlink_to(native_fmus)
    return found


@pytest.fixture
def make(folder: Path) -> Iterator[Any]:
    """Function that makes an environment of a stage with options; they are closed after the test."""
    made = []

    def function(stage: str, **options: Any) -> Any:
        made.append(environment(stage, folder, **options).unwrapped)
        return made[-1]

    yield function
    for each in made:
        each.close()

"""The PD controller of the 2-DOF stage, as a class that runs in this process."""

from collections.abc import Callable
from pathlib import Path

import pytest
from written_controllers import controller

from maglev.user.source import PythonFile

MakePD = Callable[..., type]



@pytest.fixture(scope="session")
def pd_class(tmp_path_factory: pytest.TempPathFactory) -> MakePD:
    """Function that makes the class with changes of its text."""
    folder = tmp_path_factory.mktemp("pd")
    made: list[Path] = []

    def make(*changes: tuple[str, str]) -> type:
        made.append(controller(folder, *changes, name=f"pd{len(made)}.py"))
        found: type = PythonFile(made[-1]).load().definition.arguments[0]
        return found
    return make

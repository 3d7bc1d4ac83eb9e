"""What is committed of a rig is what its description writes."""

from pathlib import Path

import pytest

from maglev.rig.description import PACKAGED, read_rig
from maglev.rig.modules import TILTING, WRITERS, writers, written
from pmlsm.rigs import DESCRIBED

ROOT = PACKAGED.parent


@pytest.mark.parametrize("name", DESCRIBED)
def test_modules_are_as_written(name: str) -> None:
    different = {path for path, text in written(read_rig(PACKAGED / f"{name}.toml")).items()
                 if (ROOT / path).read_text(encoding="utf-8") != text}
    assert not different, "run make generate"


def test_every_description_is_a_rig_of_this_project() -> None:
    assert {path.stem for path in PACKAGED.glob("*.toml")} == set(DESCRIBED)


@pytest.mark.parametrize("path", {**WRITERS, **TILTING})
def test_no_module_of_a_rig_is_left_over(path: str) -> None:
    """A rig that is gone, or a writer that has another name now, leaves no module behind."""
    folder, stem = Path(path).parent, Path(path).name.partition("{}")
    found = {file.name for file in (ROOT / folder).glob(f"{stem[0]}[0-9]dof{stem[2]}")}
    assert found == {f"{stem[0]}{name}{stem[2]}" for name, rig in DESCRIBED.items() if path in writers(rig)}

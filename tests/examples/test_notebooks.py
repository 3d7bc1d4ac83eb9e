"""Notebooks, each in a kernel of its own, as a reader runs them: their pictures show, their numbers are right."""

from pathlib import Path
from typing import Any

import pytest
from example_builds import EXAMPLES

from maglev.scenario.layers import PACKAGED


@pytest.fixture(scope="session")
def nbclient() -> Any:
    pytest.importorskip("ipykernel")
    pytest.importorskip("matplotlib")
    return pytest.importorskip("nbclient")


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("name", "check"), [
    # The site runs it as well; what it calls has tests of its own.
    pytest.param("front_door", "assert all(without < with_friction for with_friction, without in errors.values())",
                 marks=pytest.mark.thorough),
    ("plant_with_plain_fmpy", """
for k, expected in ((1400, (25e-3, 0, 0)), (2900, (26e-3, 0, 0)), (-1, (26e-3, 5e-3, 0))):
    assert all(abs(found - place) < 0.2e-3 for found, place in zip(recorded[k], expected, strict=True)), recorded[k]
"""),
])
def test_notebooks_show_their_pictures(nbclient: Any, request: pytest.FixtureRequest, tmp_path: Path,
                                       monkeypatch: pytest.MonkeyPatch, name: str, check: str) -> None:
    import nbformat

    if name != "front_door":   # which needs no build
        monkeypatch.setenv("FMUS", str(request.getfixturevalue("fmus")))
    monkeypatch.setenv("PYTHONPATH", str(PACKAGED.parent))
    monkeypatch.delenv("MPLBACKEND", raising=False)   # of whoever runs the tests
    notebook: Any = nbformat.read(EXAMPLES / f"{name}.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    notebook.cells.append(nbformat.v4.new_code_cell(check))
    nbclient.execute(notebook, cwd=tmp_path, timeout=600, kernel_name="python3")
    drawn = [cell for cell in notebook.cells if "plot" in cell.source and cell.cell_type == "code"
             and "import" not in cell.source]
    assert drawn
    for cell in drawn:
        pictures = [output.data["image/png"] for output in cell.outputs if "image/png" in output.get("data", {})]
        assert len(pictures) == 1, cell.source

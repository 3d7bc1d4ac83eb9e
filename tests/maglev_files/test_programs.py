"""Programs that are started."""

import sys
from pathlib import Path

import pytest

from maglev_files.programs import output_of, python_environment


def test_another_python_imports_what_this_one_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Packages of `pip --target`, as machines for computing have them, are in `sys.path` alone."""
    (tmp_path / "packages").mkdir()
    (tmp_path / "packages" / "of_mine.py").write_text("print('here')")
    monkeypatch.syspath_prepend(str(tmp_path / "packages"))
    code, printed = output_of([sys.executable, "-c", "import of_mine, fmi_export"], tmp_path, python_environment())
    assert (code, printed.strip()) == (0, "here")

"""Runs to identify the stages from, made once."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from identification_data import excitation

Trial = dict[str, np.ndarray]


@pytest.fixture(scope="session")
def trial(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Trial]:
    """Function `excitation`, which keeps what it has made for all processes of a test run."""
    folder = tmp_path_factory.getbasetemp()
    shared = folder.parent if folder.name.startswith("popen-") else folder

    def kept(stage: int, **arguments: Any) -> Trial:
        name = "_".join(f"{key}{value}" for key, value in sorted(arguments.items()))
        path: Path = shared / f"trial{stage}_{name}.npz"
        if not path.exists():
            part = folder / "trial.npz"
            columns: dict[str, Any] = excitation(stage, **arguments)
            np.savez(part, **columns)
            part.replace(path)   # complete when it appears
        with np.load(path) as found:
            return dict(found)

    return kept

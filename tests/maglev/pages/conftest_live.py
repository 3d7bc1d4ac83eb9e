"""One live page of three stages for the tests that look at it in a browser."""

from pathlib import Path

import pytest
from live_homes import HOMES
from report_runs import packaged

from maglev.pages.live_page import live_page


@pytest.fixture(scope="package")
def page(wasm_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("live") / "live.html"
    path.write_text(live_page(wasm_fmus, [packaged(name) for name in HOMES]), encoding="utf-8")
    return path

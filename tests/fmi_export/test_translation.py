"""Translations are kept for the next time, by what they are made of."""

from collections.abc import Iterable
from pathlib import Path

import pytest
from native_builds import require_native_tools

from fmi_export.native import translation
from maglev_files.cache import PLACE, cache_folder, sizes

pytestmark = pytest.mark.usefixtures("slow")

ONE = "def twice(x: float) -> float:\n    return {} * x\n"
TEXTS = {"tiny.one": ONE.format("2.0"),
         "tiny.two": "from tiny.one import twice\n\n\ndef four_times(x: float) -> float:\n    return twice(twice(x))\n",
         "tiny.other": "def half(x: float) -> float:\n    return 0.5 * x\n"}


@pytest.fixture
def asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[set[str]]:
    """Modules that pyccel was asked for, call by call; nothing is kept yet."""
    require_native_tools()
    monkeypatch.setenv(PLACE, str(tmp_path / "cache"))
    calls, run = [], translation.run_pyccel

    def noted(root: Path, paths: Iterable[str]) -> None:
        given = list(paths)
        calls.append({Path(path).stem for path in given})
        run(root, given)

    monkeypatch.setattr(translation, "run_pyccel", noted)
    return calls


def test_what_was_translated_before_is_not_again(asked: list[set[str]]) -> None:
    """Nor what a change does not reach: a module is known by its text and those of all that it imports."""
    made = translation.translate_modules(TEXTS)
    assert translation.translate_modules(TEXTS) == made and len(asked) == 1
    changed = translation.translate_modules(TEXTS | {"tiny.one": ONE.format("3.0")})
    assert asked[1:] == [{"one", "two"}]
    assert changed["one.c"] != made["one.c"] and changed["other.c"] == made["other.c"]
    assert translation.translate_modules(TEXTS) == made and len(asked) == 2
    assert len(sizes()) == 3 * 5


def test_a_file_that_was_changed_is_made_again(asked: list[set[str]]) -> None:
    made = translation.translate_modules(TEXTS)
    next(cache_folder().rglob("*-two.c")).write_text("double four_times(double x) { return x; }\n", encoding="utf-8")
    assert translation.translate_modules(TEXTS) == made
    assert asked[1:] == [{"two"}]


def test_where_nothing_can_be_kept_it_goes_on(asked: list[set[str]], tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("no folder", encoding="utf-8")
    assert translation.translate_modules(TEXTS) == translation.translate_modules(TEXTS)
    assert len(asked) == 2

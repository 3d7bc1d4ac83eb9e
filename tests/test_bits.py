"""The same runs have the same bits in every environment that is here, and those of docs/accuracy.md."""

import importlib.util
import re
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from native_builds import require_native_tools

ROOT = Path(__file__).parents[1]


@cache
def tool() -> ModuleType:
    """The script, which is not in a package."""
    spec = importlib.util.spec_from_file_location("bits", ROOT / "tools" / "bits.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["bits"] = module   # dataclasses look there
    spec.loader.exec_module(module)
    return module


def of_page() -> tuple[str, ...]:
    """The digests of the page, which are one for each run."""
    rows: set[tuple[str, ...]] = tool().of_page()
    assert len(rows) == 1
    return rows.pop()


# What makes references, disturbances, noise and metrics of a run; blocks are looked at by tests/test_pyccel_subset.py.
RECORDED = ("waves.py", "schema", "cosim", "experiment", "judging", "gym", "studies/flying")
OF_A_LIBRARY = re.compile(r"\b(?:np|math)\.(?:sinh?|cosh?|tanh?|exp\w*|log\w*|arc\w+|power|hypot|pow|cbrt)\b|np\.fft|"
                          r"from (?:math|scipy)[\w.]* import .*\b(?:sin|cos|exp|log|tan|atan)")


def test_what_is_recorded_calls_no_mathematical_library() -> None:
    """A library's functions are another machine's others."""
    files = [file for place in RECORDED for path in [ROOT / "maglev" / place]
             for file in ([path] if path.is_file() else path.rglob("*.py"))]
    assert len(files) > 40
    assert [file for file in files if OF_A_LIBRARY.search(file.read_text(encoding="utf-8"))] == []


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("number", range(len(tool().QUICK)))
def test_bits_of_one_run(number: int) -> None:
    """Of the 3-DOF loop, in what the gate can afford."""
    require_native_tools()
    environment = tool().QUICK[number]
    try:
        assert environment.digest(tool().runs()[1]) == of_page()[1]
    except tool().Absent as absent:
        pytest.skip(f"{environment.name}: {absent}")


@pytest.mark.thorough
@pytest.mark.parametrize("number", range(len(tool().QUICK + tool().THOROUGH)))
def test_bits_of_all_runs(number: int) -> None:
    require_native_tools()
    environment = (tool().QUICK + tool().THOROUGH)[number]
    found = environment.digests()
    if isinstance(found, str):
        pytest.skip(f"{environment.name}: {found}")
    assert found == of_page()

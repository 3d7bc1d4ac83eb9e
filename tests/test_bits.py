"""The same runs have the same bits in every environment that is here, and those of docs/accuracy.md."""

import importlib.util
import sys
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from mathematical_library import inexact
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


# Where the package calls a mathematical library, and for what: for no number of a run, or one with the digits that all
# machines have. The rest of it may not; blocks are looked at by tests/maglev/fmi/test_native_sources.py.
ELSEWHERE = {
    "maglev/analysis": "figures of a run, by Fourier transforms, and certified regions",
    "maglev/analysis/response.py": "phases of an excitation are rounded, and its sines are of maglev.scenario.waves",
    "maglev/files/errors.py": "sizes in messages",
    "maglev/runs/experiment_check.py": "an FMU against its carried solution, within a tolerance",
    "maglev/identification": "estimates from a recording",
    "maglev/linear": "linear models and margins",
    "maglev/descriptions/data_sheet.py": "constants of a stage, kept to twelve digits or a field of 1e-10 T",
    "maglev/user/consequences.py": "what `maglev stage` prints, which is in no stage",
    "maglev/user/gain_design.py": "gains of a stage, kept to twelve digits",
    # Values of what varies: docs/accuracy.md says that their last digits are a machine's.
    "maglev/many/study_design.py": "quantiles of normal distributions, and powers between the ends of wide ranges",
    "maglev/pages/frequency.py": "sensitivities and spectra, on a page",
    "maglev/pages/study_verdict.py": "intervals of shares that pass, and tests of influence, on a page",
    "maglev/files/table_times.py": "columns of a recording with uneven times, of which something is estimated",
    "maglev/many/tuning_search.py": "candidates of a search",
    "maglev/files/units.py": "powers of decimal numbers, which are exact",
    "maglev/fmi/icon.py": "pictures"}


def place_of(file: Path) -> str | None:
    """The closest of these places in which a file lies."""
    name = file.relative_to(ROOT).as_posix()
    return max((place for place in ELSEWHERE if f"{name}/".startswith(f"{place}/")), key=len, default=None)


@pytest.mark.usefixtures("slow")
def test_what_is_recorded_calls_no_mathematical_library() -> None:
    """A library's functions are another machine's others: references, disturbances, noise and metrics have our own."""
    files = [*(ROOT / "maglev").rglob("*.py")]
    found = {file: inexact(file.read_text(encoding="utf-8")) for file in files}
    assert len(files) > 250
    assert {file.relative_to(ROOT).as_posix(): names for file, names in found.items()
            if names and place_of(file) is None} == {}
    assert {place_of(file) for file, names in found.items() if names} == {*ELSEWHERE}   # none has lost its reason


@pytest.mark.parametrize("text", [
    "from math import sqrt, sin", "from math import *", "import math as m", "import math\nmath.pow(2.0, x)",
    "import numpy as np\nnp.sin(x)", "import numpy\nnumpy.sin(x)", "import numpy as np\nnp.fft.rfft(x)",
    "from numpy import tanh", "from numpy.fft import rfft", "import numpy.fft", "from scipy.special import ndtri",
    "import scipy.stats", "import cmath", "x ** 0.5", "x ** y", "pow(x, 0.5)", "np.linalg.inv(a)", "np.arctan2(y, x)",
    "def f():\n    from math import expm1"])
def test_such_a_call_is_found(text: str) -> None:
    assert inexact(text) != []


@pytest.mark.parametrize("text", [
    "from math import sqrt, inf, isfinite", "import math\nmath.isclose(x, y)", "from random import random",
    "import numpy as np\nnp.sqrt(np.abs(x)) + np.maximum(x, y)", "import numpy.typing as npt", "x ** 2", "2.0 ** -53",
    "from pmlsm.exponential import exponential", "from maglev.scenario.waves import sines_cosines"])
def test_what_is_exact_is_not(text: str) -> None:
    assert inexact(text) == []


@pytest.mark.few(2)
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

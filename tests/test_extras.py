"""What is said to install a module that is missing does install it."""

import ast
import tomllib
from pathlib import Path

import pytest

from maglev.files.errors import lacking
from maglev.files.packages import PACKAGES

ROOT = Path(__file__).parents[1]
EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
ASKS = ("extra", "lacking")


def asked() -> set[tuple[str, str]]:
    """Modules and extras that the sources name when they ask whether one is installed."""
    texts = [path.read_text(encoding="utf-8") for package in PACKAGES for path in (ROOT / package).rglob("*.py")]
    calls = [node for text in texts if any(f"{name}(" in text for name in ASKS)
             for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call)]
    return {(str(call.args[0].value), str(call.args[1].value)) for call in calls
            if isinstance(call.func, ast.Name) and call.func.id in ASKS
            and isinstance(call.args[0], ast.Constant) and isinstance(call.args[1], ast.Constant)}


@pytest.mark.usefixtures("slow")
def test_modules_are_in_the_extras_that_messages_name() -> None:
    found = asked()
    assert {("pyarrow", "study"), ("matplotlib", "report"), ("ziglang", "native")} <= found
    for module, extra in found:
        assert any(module.partition(".")[0].lower() in requirement.lower() for requirement in EXTRAS[extra]), module


def test_a_module_that_is_missing_and_one_that_is_there() -> None:
    assert lacking("numpy.linalg", "study", "anybody") == ""
    assert lacking("not_a_module.part", "study", "a study") == (
        "a study needs not_a_module; install it with the Python that runs maglev: python -m pip install "
        "'maglev-fmus[study]'")

"""The mutations of tools/mutants.toml apply; `make mutants` shows that each is noticed."""

import ast
import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from maglev.descriptions.own_fmus import DEFINITIONS
from maglev.runs.check_outcome import CheckResult
from maglev.runs.preparation import Experiment

pytestmark = pytest.mark.usefixtures("slow")

ROOT = Path(__file__).parents[1]


def tool() -> ModuleType:
    """The script, which is not in a package."""
    spec = importlib.util.spec_from_file_location("mutants", ROOT / "tools" / "mutants.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


TOOL = tool()
MUTATIONS = TOOL.read_mutations()
named_plans = cache(TOOL.named_plans)


@pytest.mark.few(70)
@pytest.mark.parametrize("mutation", MUTATIONS, ids=str)
def test_a_mutation_changes_one_place_of_a_block_of_its_runs(mutation: Any) -> None:
    changed = mutation.source()
    if mutation.tests:   # a template
        assert changed != (ROOT / mutation.file).read_text(encoding="utf-8")
        assert all((ROOT / test).is_file() for test in mutation.tests)
        return
    assert ast.dump(ast.parse(changed)) != ast.dump(ast.parse((ROOT / mutation.file).read_text(encoding="utf-8")))
    assert set(mutation.fmus) <= set(DEFINITIONS)
    simulated = {fmu.model for plan in named_plans(mutation.runs) for fmu in plan.fmus.values()}
    assert set(mutation.fmus) <= simulated


def test_no_mutation_is_there_twice() -> None:
    assert len({(each.file, each.old, each.new, each.fmus) for each in MUTATIONS}) == len(MUTATIONS) >= 40


def test_fmus_of_changed_sources_are_run_and_not_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Or every mutation would seem to be noticed, whatever the runs show."""
    monkeypatch.setattr(TOOL, "prepare", lambda plan, *_: Experiment(plan, {}, plan.step, stale=("an old one",)))

    def check_run(_baselines: Path, experiment: Experiment, *_: object) -> CheckResult:
        experiment.require_current()
        return CheckResult(experiment.plan.name, "passed", "", None, {}, 0.0)

    monkeypatch.setattr(TOOL, "check_run", check_run)
    assert TOOL.noticed(named_plans(("3dof-effects-ripple",)), Path()) == ""

"""What a scenario file says about its procedure, and what it cannot say."""

from pathlib import Path
from typing import Any

import pytest
from facts import raises, require_facts
from pydantic import ValidationError

from maglev.files.errors import ScenarioError
from maglev.runs.chain import select
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan, load_plans
from maglev.scenario.procedure import ProcedureSettings

PARTS = {"currents": "a", "excitation": "b"}


def settings(**table: Any) -> ProcedureSettings:
    return ProcedureSettings.model_validate({"kind": "equilibrium", "name": "mine", "title": "Mine", "runs": PARTS,
                                             **table})


@pytest.mark.parametrize(("table", "facts"), [
    ({"kind": "equilibria"}, ["kind", "'equilibrium'"]),
    ({"runs": {"currents": "a"}}, ["runs", "run for excitation"]),
    ({"runs": {}}, ["runs", "run for currents, excitation"]),
    ({"runs": {**PARTS, "offset": "c"}}, ["offset", "equilibrium", "currents or excitation"]),
    ({"kind": "cogging", "runs": {**PARTS, "offset": "c"}}, ["gaps", "range"]),
    ({"kind": "identification"}, ["excitation", "part of identification"]),
    ({"kind": "identification", "runs": {"stage": "a"}}, ["runs", "run for model, currents, parabolas"]),
    ({"gaps": ["10 mm"]}, ["gaps"]),
    ({"gaps": ["10 mm", "2 s"]}, ["gaps", "2 s", "m"]),
    ({"printed": {"C1": 14.2}}, ["printed", "C1"]),
    ({"tabel": "4.2"}, ["tabel", "'table'"])])
def test_settings_that_do_not_fit_are_refused(table: dict[str, Any], facts: list[str]) -> None:
    with pytest.raises(ValidationError) as refusal:
        settings(**table)
    require_facts(refusal.value.errors(), *facts)


FILE = """
extends = "{drive}"
name = "mine"
title = "Mine"
stop_time = "5 ms"
[procedure]
kind = "parabolas"
name = "my-procedure"
title = "Mine"
[[procedure.claims]]
text = "It pulls"
source = "p. 1"
value = "thrust"
relation = ">"
target = 4
[variants.a]
[variants.b]
"""


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('kind = "parabolas"', 'kind = "parabola"', ["procedure.kind", "'parabola'", "'parabolas'"]),
    ('kind = "parabolas"', 'kind = "forgetting"', ["procedure.runs", "jump"]),
    ('title = "Mine"\n[[', 'title = "Mine"\nruns = { stage = "mine-a" }\n[[',
     ["procedure.runs.stage", "'mine-a'", "parabolas"]),
    ("target = 4", "than = { epsilon = 0.01 }\ntarget = 4", ["procedure.claims[0].target", "4.0", "than"]),
    ('value = "thrust"', 'value = "trust"', ["procedure.claims[0].value", "'trust'", "'thrust'"]),
    ('name = "my-procedure"', 'name = "mine-b"', ["procedure.name", "'mine-b'", "run"])])
def test_refusals_are_one_line_with_file_and_key(tmp_path: Path, old: str, new: str, facts: list[str]) -> None:
    text = FILE.format(drive=PACKAGED / "loops" / "2dof-drive.toml")
    assert text.count(old) == 1
    (tmp_path / "mine.toml").write_text(text.replace(old, new))
    with raises(ScenarioError, tmp_path / "mine.toml", *facts):
        load_plans(tmp_path / "mine.toml")


def test_every_variant_belongs_to_the_procedure(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(FILE.format(drive=PACKAGED / "loops" / "2dof-drive.toml"))
    names = {run.name: run.procedure.name for run in load_plans(tmp_path / "mine.toml") if run.procedure}
    assert names == {"mine-a": "my-procedure", "mine-b": "my-procedure"}
    assert load_plan("2dof-setpoints").procedure is None


def test_values_of_the_thesis_belong_to_their_epsilon() -> None:
    three = settings(printed={"C2": [1.0, 2.0, 3.0], "C3": [5.0]})
    assert three.printed_at(0.001) == {"C2": 1.0}
    assert three.printed_at(0.01) == {"C2": 2.0, "C3": 5.0}
    assert three.printed_at(0.02) == {}


@pytest.mark.parametrize("name", ["2dof-setpoints", "2dof-procedure-3"])
def test_a_procedure_cannot_be_called_like_a_run_or_another_procedure(tmp_path: Path, name: str) -> None:
    text = (PACKAGED / "2dof" / "2dof-cogging.toml").read_text(encoding="utf-8")
    text = text.replace('"2dof-procedure-3"', f'"{name}"')
    mine = tmp_path / "mine.toml"
    mine.write_text(text.replace('"2dof-cogging"', '"mine"').replace('"loops/', f'"{PACKAGED}/loops/')
                    .replace('"references/', f'"{PACKAGED}/references/'), encoding="utf-8")
    other = "mine.toml" if name == "2dof-procedure-3" else "2dof-setpoints.toml"
    with raises(ScenarioError, "procedure.name", repr(name), other):
        select([str(mine), "2dof-setpoints", "2dof-cogging"])
    assert len(select([str(mine)])) == 1

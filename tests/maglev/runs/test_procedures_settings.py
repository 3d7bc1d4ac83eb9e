"""What a scenario file says about its procedure, and what it cannot say."""

from pathlib import Path
from typing import Any

import pytest
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


@pytest.mark.parametrize(("table", "words"), [
    ({"kind": "equilibria"}, ["kind", "'equilibrium'"]),
    ({"runs": {"currents": "a"}}, ["runs", "expected a run for excitation"]),
    ({"runs": {}}, ["expected a run for currents, excitation"]),
    ({"runs": {**PARTS, "offset": "c"}}, ["offset", "not a part of equilibrium, expected currents or excitation"]),
    ({"kind": "cogging", "runs": {**PARTS, "offset": "c"}}, ["gaps", "expected the range of air gaps for the force"]),
    ({"kind": "identification"}, ["excitation", "not a part of identification"]),
    ({"kind": "identification", "runs": {"stage": "a"}}, ["expected a run for model, currents, parabolas"]),
    ({"gaps": ["10 mm"]}, ["gaps"]),
    ({"gaps": ["10 mm", "2 s"]}, ["gaps", "2 s", "in m"]),
    ({"printed": {"C1": 14.2}}, ["printed", "C1"]),
    ({"tabel": "4.2"}, ["tabel", "nearest is 'table'"])])
def test_settings_that_do_not_fit_are_refused(table: dict[str, Any], words: list[str]) -> None:
    with pytest.raises(ValidationError) as refusal:
        settings(**table)
    message = str(refusal.value.errors())
    assert all(word in message for word in words), message


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


@pytest.mark.parametrize(("old", "new", "words"), [
    ('kind = "parabolas"', 'kind = "parabola"', ["procedure.kind = 'parabola'", "'parabolas'"]),
    ('kind = "parabolas"', 'kind = "forgetting"', ["procedure.runs", "expected a run for jump"]),
    ('title = "Mine"\n[[', 'title = "Mine"\nruns = { stage = "mine-a" }\n[[',
     ["procedure.runs.stage = 'mine-a'", "not a"]),
    ("target = 4", "than = { epsilon = 0.01 }\ntarget = 4", ["claims[0].target = 4", "no meaning", "with than"]),
    ('value = "thrust"', 'value = "trust"', ["procedure.claims[0].value = 'trust'", "'thrust'"]),
    ('name = "my-procedure"', 'name = "mine-b"', ["procedure.name = 'mine-b'", "a run has this name"])])
def test_refusals_are_one_line_with_file_and_key(tmp_path: Path, old: str, new: str, words: list[str]) -> None:
    text = FILE.format(drive=PACKAGED / "loops" / "2dof-drive.toml")
    assert text.count(old) == 1
    (tmp_path / "mine.toml").write_text(text.replace(old, new))
    with pytest.raises(ScenarioError) as caught:
        load_plans(tmp_path / "mine.toml")
    message = str(caught.value)
    assert all(word in message for word in ["mine.toml", *words]), message
    assert "\n" not in message


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
    with pytest.raises(ScenarioError, match=f"procedure.name = '{name}': .* uses it, expected another name"):
        select([str(mine), "2dof-setpoints", "2dof-cogging"])
    assert len(select([str(mine)])) == 1

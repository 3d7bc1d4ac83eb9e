"""Texts of a user's files are data in every language that they are written in."""

import ast
import csv
import json
import re
import shlex
import tomllib
import zipfile
from dataclasses import fields
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any, cast
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import maglev
from facts import raises
from report_outcomes import chart
from report_runs import Page, judged, packaged, page_of, recorded
from studied_grid import broken_at

from maglev.api.studying import new_study
from maglev.descriptions.description_file import PACKAGED, Reader, read_stage
from maglev.descriptions.registry import definitions
from maglev.descriptions.writer import page_texts
from maglev.files.console import plain_console
from maglev.files.errors import StageError
from maglev.files.pictures import new_figure, write_figure
from maglev.files.toml_file import read_toml
from maglev.fmi.block_code import model_table
from maglev.fmi.documentation import documentation, typeset
from maglev.fmi.escapes import c_comment, c_string, csv_text, xml_text
from maglev.fmi.freestanding import listed, members, parameter_line
from maglev.fmi.model_description import model_description, model_description_3
from maglev.many.tuning_plan import TuneFile
from maglev.many.tuning_search import SearchResult, gains_toml
from maglev.pages.run_text import claims_markdown, curves_csv, run_text
from maglev.pages.study_page import study_page
from maglev.pages.study_terminal import show_study
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import Event
from maglev.user.new_controller import new_controller, new_plant
from maglev.user.new_stage import new_scenario
from pmlsm.stage_description import StageDescription

# What ends a comment, a string, an element, an equation, a row or a line in each language, and continues with code.
ATTACKS = {
    "C": '*/ int pwned(const char *); /* ??/ " %s \\',
    "Python": '""" + pwned() + """ \'\'\' \\" \\',
    "TOML": '"\npwned = 1\n[pwned]\n# \\u0000',
    "HTML": '"\'></title></script><pwned onload="pwned()">&lt;pwned><!--shell-->${pwned}@NAME@',
    "TeX": r"\(\pwned{\frac\) \[\begin{pmatrix}\] $\pwned{$ \input{pwned}",
    "CSV": '",\n"=pwned()"\r\n;\tpwned',
    "shell": "'; pwned \"$(pwned)\" `pwned` \n& |",
    "terminal": "\x1b]0;pwned\x07\x1b[2J\x9b31m\u202e[bold][/] [/nothing] {pwned}",
    "XML": "\x01\ud800]]><pwned/>\ufffe",
    "Markdown": "a | b\n# pwned\n<pwned> `pwned` \\|"}
ALL = "".join(ATTACKS.values())
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\ud800-\udfff]")


def hostile_stage(name: str) -> StageDescription:
    """A stage of the package in which every text has all that its reader lets pass."""
    path = PACKAGED / f"{name}.toml"
    table = read_toml(path)

    def passes(place: tuple[str, ...], text: str) -> bool:
        tried = cast(dict[str, Any], json.loads(json.dumps(table)))
        put(tried, place, text)
        reader = Reader(Path("mine.toml"))
        try:
            reader.check(cast(StageDescription, reader.read(StageDescription, tried, "")))
        except StageError as error:
            assert not CONTROLS.search(str(error)), "a message in one line, and nothing in it that a terminal obeys"
            assert "\n" not in str(error)
            return False
        return True

    places: list[tuple[str, ...]] = [(member.name,) for member in fields(StageDescription) if member.type is str]
    places += [("axes", axis, "meaning") for axis in table["axes"]]
    cited = (*table["sources"], "law", "linearisation", "equation", "constants", "stage")
    places += [("sources", key) for key in cited]
    assert len(places) > 10
    for place in places:
        text = " ".join(attack for attack in ATTACKS.values() if passes(place, attack))
        if text:
            put(table, place, text)
    reader = Reader(path)
    stage = cast(StageDescription, reader.read(StageDescription, table, ""))
    reader.check(stage)
    return stage


def put(table: dict[str, Any], place: tuple[str, ...], text: str) -> None:
    *above, key = place
    for name in above:
        table = table[name]
    table[key] = text


def code_of(text: str) -> str:
    """C without its comments and strings, lines joined that a backslash joins."""
    text = text.replace("??/", "\\").replace("\\\n", "")
    return re.sub(r'/\*.*?\*/|"(\\.|[^"\\])*"', " ", text, flags=re.DOTALL)


def names_in(text: str) -> set[str]:
    """Names in the code of a Python module."""
    return {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}


def is_data(page: Page) -> None:
    assert not page.all("pwned")
    assert not [element for element in page.elements if "onload" in element.attributes]
    assert not page.all("parsererror")


@pytest.mark.parametrize("text", ATTACKS.values(), ids=ATTACKS)
def test_c_comments_and_strings_hold_any_text(text: str) -> None:
    assert "pwned" not in code_of(f"/* {c_comment(text)} */")
    printable = text.encode("utf-8", "replace").decode()
    assert "pwned" not in code_of(c_string(printable)) and c_string(printable).isascii()


@pytest.mark.parametrize("name", ["2dof", "5dof"])
def test_texts_of_a_stage_are_no_code(name: str) -> None:
    stage = hostile_stage(name)
    for text in page_texts(stage).values():
        is_data(Page(typeset(f"<html>{text}</html>")))
    for made in ("Plant", "Regulator", "Estimator"):
        definition = definitions(stage)[f"{made}{stage.suffix}"].value()
        for described in (model_description(definition, "", "", 0), model_description_3(definition, "", "", 0)):
            assert "pwned" not in {element.tag for element in ElementTree.parse(BytesIO(described)).iter()}
        is_data(Page(documentation(definition, "1").replace("<wbr>", "")))
        assert "pwned" not in code_of(model_table(definition, "", True))
        ports = [v for v in definition.variables if v.causality == "input"]
        shown = [parameter_line(definition, v, k) for k, v in enumerate(ports)]
        assert "pwned" not in code_of(members(ports) + "/*" + listed([*shown, definition.description]) + "*/")


@pytest.mark.parametrize("key", ["title", "equation"])
@pytest.mark.parametrize("text", ["*/ int system(const char *); /*", "/*", '"""', "a\nb", "\\"])
def test_refuses_a_title_that_ends_a_comment_or_a_string(tmp_path: Path, key: str, text: str) -> None:
    """It stands in docstrings of what is written of a stage, which were comments in C."""
    path = tmp_path / "mine.toml"
    given = (PACKAGED / "2dof.toml").read_text(encoding="utf-8")
    path.write_text(re.sub(f"(?m)^{key} = .*$", lambda _: f"{key} = {json.dumps(text)}", given), encoding="utf-8")
    with raises(StageError, path, key):
        read_stage(path)


def test_files_to_begin_with_hold_titles_and_names_as_data(tmp_path: Path) -> None:
    """Of a stage in a folder, and under a name, that other systems' users have too."""
    folder = tmp_path / "a \"b\" \\ 'c' $(pwned) #"
    folder.mkdir()
    stage = folder / "mine.toml"
    assert maglev("new", "stage", stage).exit_code == 0
    title = "it's <b>50 %</b> [bold] {x} $y$"
    stage.write_text(re.sub("(?m)^title = .*$", lambda _: f"title = '''{title}'''",
                            stage.read_text(encoding="utf-8")), encoding="utf-8")
    scenario = new_scenario(tmp_path / "scenario.toml", stage)
    plan = load_plan(scenario)
    assert plan.title == f"{title}: a sequence of setpoints" and plan.stage_file == str(stage)
    study = tomllib.loads(new_study(tmp_path / "study.toml", str(folder / "mine-setpoints.toml")).read_text("utf-8"))
    assert study["title"] == f"{title}: mass and friction"
    assert study["scenario"] == str(folder / "mine-setpoints.toml")
    for new in (new_controller, new_plant):
        names_in(new(tmp_path / f"{new.__name__}.py", str(stage)).read_text("utf-8"))
    said = maglev("new", "scenario", folder / "other.toml", "--stage", stage).stdout
    command = said[said.index("`") + 1:said.rindex("`")]
    assert shlex.split(command) == ["maglev", "run", str(folder / "other.toml"), "--plot"]


def test_texts_of_a_scenario_are_data() -> None:
    text = ALL.replace("\ud800", "")
    plan = packaged("2dof-setpoints")
    plan = plan.model_copy(update={"title": text, "description": text, "events": [Event(name=text, time=0.1)]})
    claims = [judged("not reproduced", text=text, source=text, reason=text)]
    run = recorded(plan)
    is_data(page_of([run], {plan.name: claims}))
    assert not CONTROLS.search(run_text(run, claims))
    rows = [line for line in claims_markdown([run], {plan.name: claims}).splitlines() if "pwned" in line]
    assert len(rows) == 1 and "<pwned" not in rows[0]
    marks = csv.reader(StringIO(curves_csv([chart(text, text)])))
    assert {row[0] for row in marks} == {"figure", text}


@pytest.mark.parametrize("text", ["=1+1", "+SUM(A1)", "-cmd|' /C calc'!A0", "@pwned", " =1+1", "\t=1", "\n=1"])
def test_texts_in_a_csv_are_no_formulas(text: str) -> None:
    """A spreadsheet computes what begins with = + - or @; numbers are none of these."""
    rows = [*csv.reader(StringIO(curves_csv([chart(text, text)])))][1:]
    assert rows and all(row[0] == f"'{text}" for row in rows)
    assert [csv_text(number) for number in ("-1.5", "+2", "-inf", "4.9", "a - b", "")] == [
        "-1.5", "+2", "-inf", "4.9", "a - b", ""]


def test_texts_of_a_study_are_data() -> None:
    text = ALL.replace("\ud800", "")
    table, about = broken_at()
    about |= {"title": text, "description": text, "name": "study"}
    is_data(Page(study_page(table, about)))
    shown = StringIO()
    show_study(plain_console(file=shown, width=80), table, about)
    assert not CONTROLS.search(shown.getvalue()) and "[bold][/]" in shown.getvalue().replace("\n", "")


def test_texts_of_a_tuning_file_are_data() -> None:
    text, key = ALL.replace("\ud800", ""), 'v."k1"\\'
    tuning = TuneFile.model_construct(name="mine", title=text, scenario="mine.toml")
    nothing = np.zeros(0)
    found = SearchResult({f"controller.{key}": 1.0}, (), 0.0, 0.0, nothing, nothing, nothing, nothing, 1)
    assert tomllib.loads(gains_toml(tuning, found)) == {"fmus": {"controller": {"start": {key: 1.0}}}}


def test_texts_in_pictures_are_no_equations(tmp_path: Path) -> None:
    """What stands between two dollars is none of TeX's, and what is wrong as TeX draws as it is."""
    figure = new_figure(16, 8)
    text = ATTACKS["TeX"]
    figure.suptitle(text)
    panel = figure.subplots()
    panel.set(title=text, xlabel=text, ylabel=text, yscale="log")
    panel.plot([1.0, 2.0], [1.0, 10.0], label=text)
    panel.legend()
    figure.legend()
    write_figure(tmp_path / "picture.png", figure)


def test_texts_of_an_fmu_are_data(tmp_path: Path) -> None:
    """Its names, units and descriptions, as far as XML can hold them, where it is refused."""
    text = xml_text(ALL)
    root = ElementTree.Element("fmiModelDescription", {
        "fmiVersion": "2.0", "modelName": text, "guid": text, "description": text, "generationTool": text})
    ElementTree.SubElement(root, "CoSimulation", {"modelIdentifier": "theirs"})
    variables = ElementTree.SubElement(root, "ModelVariables")
    for k, causality in enumerate(("input", "output")):
        variable = ElementTree.SubElement(variables, "ScalarVariable", {
            "name": f"{causality}{text}", "valueReference": str(k), "causality": causality, "description": text})
        ElementTree.SubElement(variable, "Real", {"unit": text})
    structure = ElementTree.SubElement(root, "ModelStructure")
    ElementTree.SubElement(ElementTree.SubElement(structure, "Outputs"), "Unknown", {"index": "2"})
    with zipfile.ZipFile(tmp_path / "theirs.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", ElementTree.tostring(root))
    result = maglev("check", tmp_path / "theirs.fmu")
    assert result.exit_code == 2 and "theirs.fmu" in result.output and not CONTROLS.search(result.output)


def test_progress_shows_names_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """A label of a run is no markup of the bars."""
    from maglev.cli import terminal

    shown = StringIO()
    shown.isatty = lambda: True   # type: ignore[method-assign]
    monkeypatch.setattr("sys.stderr", shown)
    monkeypatch.setenv("COLUMNS", "80")
    with terminal.progress_of(["a[/]", "[red]b"]) as watch:
        watch("a[/]", 1, 3)
        watch("[red]b", 1, 3)
    assert "a[/]" in shown.getvalue() and "[red]b" in shown.getvalue()

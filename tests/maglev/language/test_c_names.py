"""The C of a block has the names and places of its Python, and nothing else of its text."""

import ast
import re
from inspect import getsourcelines, signature
from pathlib import Path

import pytest
from written_blocks import load_block, load_module

from maglev.descriptions.registry import known_stages
from maglev.language.blocks import block_text
from maglev.language.c_text import CText
from maglev.language.names import KEYWORDS, identifier
from maglev.language.program import FLOAT, Function, Struct
from maglev.language.statements import Program

MADE = re.compile(r"(?:part|result|out|value)_\d+|failure|int64_t|INT64_C")   # names that no Python has
FUNCTION = re.compile(r"^/\* (?P<file>\S+), line (?P<line>\d+) \*/\nstatic (?:inline )?(?P<result>\w+) (?P<name>\w+)"
                      r"\((?P<parameters>.*)\)\n\{$", re.MULTILINE)

SECRETS = '''\
"""Secret 1 */ of the module."""
# Secret 2 */ at its top
SECRET = "Secret 3 */"


def share(x: "Secret_4", y=1.0) -> "Secret_5":
    """Secret 6 */ of a function."""
    return x * y  # Secret 7 */


class Tank:
    """Secret 8 */ of the class."""

    title = "Secret 9 */"

    def __init__(self):
        """Secret 10 */ of the constructor."""
        self.level = 1.0   # Secret 11 */
        self.title = "Secret 12 */"
        self.names = {"Secret 13": "*/"}

    def step(self):
        """Secret 14 */ of the method."""
        "Secret 15 */"
        level: "Secret_16" = share(self.level)
        # Secret 17 */
        self.level = level
'''


@pytest.mark.parametrize("name", ["ClosedLoop2DOF", "ClosedLoopAdaptive5DOF"])
def test_functions_have_names_and_places_of_the_python(name: str) -> None:
    block = known_stages().definition(name).new_block()
    program = Program(block)
    roots = [program.method("start"), program.method("step", (FLOAT, FLOAT))]
    text = CText(program.layout, roots)
    by_name = {function.name: function for function in text.functions}
    shown = list(FUNCTION.finditer(text.code))
    assert [each["name"] for each in shown] == list(by_name)
    assert len(shown) == len(re.findall(r"^static ", text.code, re.MULTILINE))
    root = Path(__file__).parents[3]
    for each in shown:
        function = by_name[each["name"]]
        line = (root / each["file"]).read_text(encoding="utf-8").splitlines()[int(each["line"]) - 1]
        assert line.strip().startswith(f"def {function.source.__name__}(")
        assert re.fullmatch(rf"{owner(program, function)}__{function.source.__name__}(_\d+)?", each["name"])
        written = [re.sub(r".*?(\w+)\)?$", r"\1", part) for part in each["parameters"].split(", ")]
        own = [part for part in written if not MADE.fullmatch(part)]
        assert own == [identifier(part) for part in signature(function.source).parameters]
        assert names_in(body_of(text.code, each["name"])) <= names_of(function) | set(program.layout.fields)


def owner(program: Program, function: Function) -> str:
    """What the name of a function in C begins with: its class, or its module."""
    kind = function.parameters[0][1] if function.parameters else None
    if isinstance(kind, Struct) and "." in function.source.__qualname__:
        return program.layout.classes[kind.name].__name__ + r"(_\d+)?"
    return function.source.__module__.rpartition(".")[2]


def body_of(code: str, name: str) -> str:
    return re.sub(r"/\*.*?\*/", "", code.partition(f" {name}(")[2].partition("\n}\n")[0])


def names_in(code: str) -> set[str]:
    """Names in the C that are not C's own, and not made by the translator."""
    words = set(re.findall(r"\b[A-Za-z_]\w*", code)) - KEYWORDS - {"int64_t"}
    return {word for word in words if not MADE.fullmatch(word)}


def names_of(function: Function) -> set[str]:
    """Names in the Python of a function as C has them, and those of functions that it calls."""
    lines, _ = getsourcelines(function.source)
    tree = ast.parse("".join(["if True:\n", *lines]) if lines[0].startswith(" ") else "".join(lines))
    words = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    words |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    words |= {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    return set(map(identifier, words)) | {called.name for called in function.calls}


def test_members_of_structs_are_the_attributes() -> None:
    block = known_stages().definition("Plant3DOF").new_block()
    text = block_text(block)
    members = re.search(rf"^struct {text.struct} {{\n(.*?)^}};", text.structs, re.MULTILINE | re.DOTALL)
    assert members is not None
    assert re.findall(r"(\w+)(?:\[\d+\])*;", members[1]) == [name for name in vars(block) if vars(block)[name] != []]


@pytest.mark.parametrize("name", ["struct", "sqrt", "quotient", "M_PI", "UINT8_MAX", "size_t", "angle_t", "lanes_any",
                                  "_live", "__x", "a__b", "x_", "struct_"])
def test_names_of_c_and_of_the_translator_get_an_underscore(name: str) -> None:
    assert identifier(name) == f"{name}_"


@pytest.mark.parametrize("name", ["x", "level", "part", "integer", "unlanes_x", "t", "a_b", "float32"])
def test_other_names_stay(name: str) -> None:
    assert identifier(name) == name


UNLIKE = '''\
class Part:
    def __init__(self, x):
        self.x = x

    def twice(self):
        return self.x + self.x


class Tank:
    def __init__(self):
        self.real, self.whole = Part(1.0), Part(1)

    def step(self):
        self.real.x = self.real.twice() * float(self.whole.twice())
'''


def test_each_kind_of_a_class_has_names_of_its_own(tmp_path: Path) -> None:
    """Objects of a class with other attributes, and names that the C around has."""
    block = load_block(tmp_path, UNLIKE, "Tank")
    for reserved, parts in (((), ("Part", "Part_2")), (("Part", "Part_3"), ("Part_2", "Part_4"))):
        program = Program(block, reserved=reserved)
        text = CText(program.layout, [program.method("step")])
        assert re.findall(r"^struct (\w+) \{", text.structs(), re.MULTILINE) == [*parts, "Tank"]
        assert {each["name"] for each in FUNCTION.finditer(text.code)} == {*(f"{part}__twice" for part in parts),
                                                                           "Tank__step"}


def test_no_docstring_and_no_comment_reaches_the_c(tmp_path: Path) -> None:
    block = load_block(tmp_path, SECRETS, "Tank")
    program = Program(block)
    text = CText(program.layout, [program.method("step")])
    code = text.structs() + text.functions_text() + text.initial(block, "INITIAL")
    assert "secret" not in code.lower()
    assert re.findall(r"/\*.*?\*/", code) == ["/* tank.py, line 6 */", "/* tank.py, line 22 */", "/* y */"]


@pytest.mark.parametrize("name", ["a*", "a*-b", 'q"', "back\\slash", "new\nline", "ä", "??-"])
def test_name_of_a_file_cannot_end_its_comment(name: str, tmp_path: Path) -> None:
    block = load_module(tmp_path, SECRETS, f"{name}.py").Tank()
    program = Program(block)
    code = CText(program.layout, [program.method("step")]).code
    shown = re.findall(r"^/.*", code, re.MULTILINE)
    assert len(shown) == 2 == code.count("/*") - 1
    assert all(re.fullmatch(r"/\* [A-Za-z0-9_./ -]+\.py, line \d+ \*/", each) for each in shown)

"""The linter of phrases: those that it finds, and those that it leaves."""

from pathlib import Path

import pytest

from tools import plain_english
from tools.plain_english import code_texts, page_texts, problems, texts

pytestmark = pytest.mark.quick


@pytest.mark.parametrize(("text", "phrase"), [
    ("What is measured is so at all.", "'what' as a noun"),
    ("Run a scenario many times, with what varies.", "'what' as a noun"),
    ("ScenarioError of a list that is none.", "'none' as a predicate"),
    ("An FMU of yours.", "'of yours'"),
    ("Anybody's FMU.", "'of yours'"),
    ("A controller beside ours.", "'beside'"),
    ("It is built anew.", "'anew'"),
    ("All axes but for the tilts.", "'but for'"),
    ("A file in place of the name.", "'in place of'"),
    ("The run goes on.", "'goes on'"),
    (f"{36 * 'word '}.", "36 words, at most 35")])
def test_finds_a_phrase(text: str, phrase: str) -> None:
    assert [name for name, _ in problems(text, ".py")] == [phrase]


@pytest.mark.parametrize(("text", "phrase"), [
    (f"{31 * 'word '}.", "31 words, at most 30"), ("It runs; it stops; it ends.", "two semicolons")])
def test_is_stricter_on_pages(text: str, phrase: str) -> None:
    assert [name for name, _ in problems(text, ".md")] == [phrase]
    assert list(problems(text, ".py")) == []


@pytest.mark.parametrize("text", [
    "What does a sample cost?", "It says what went wrong.", "There is none if the run failed.", "Besides, it is fast.",
    "The thesis writes \"but for this\".", "Give `beside` a value.", f"{30 * 'word '}on p. 61 of it. {30 * 'word '}.",
    f"{30 * 'word '}[a link]({40 * 'a '}).", f"{30 * 'word '}$a + b + c + d + e + f + g$."])
def test_leaves_plain_text(text: str) -> None:
    assert list(problems(text, ".py")) == []


def test_reads_prose_of_a_page_with_its_lines() -> None:
    page = ("# What reproduces\n\nOne\nparagraph.\n\n    code anew\n\n```\nfenced anew\n```\n"
            "- an item\n  of two lines\n| a cell | another |\n"
            "<!-- bits: made -->\ngenerated anew\n<!-- end of bits -->\nLast.\n")
    assert [(line, " ".join(text.split())) for line, text in page_texts(page) if text.strip()] == [
        (3, "One paragraph."), (11, "an item of two lines"), (13, "a cell"), (13, "another"), (17, "Last.")]


def test_reads_docstrings_and_messages_of_code() -> None:
    code = ('"""What a module is about here."""\nname = "short"\n'
            'raise ValueError(f"{name}: expected a number of it anew")\n')
    assert [(line, text) for line, text in code_texts(code)] == [
        (1, "What a module is about here."), (3, "X: expected a number of it anew")]


@pytest.mark.parametrize(("suffix", "text", "read"), [
    (".toml", '# One comment\n# of two lines.\n[a]\nb = "a text of four words"   # beside it\n',
     [(4, "a text of four words"), (1, "One comment of two lines."), (4, "beside it")]),
    (".js", 'say(`it was built ${count} times anew`);   // made anew\nrefuse("%s of what is there", name);\n',
     [(1, "it was built X times anew"), (2, "X of what is there"), (1, "made anew")]),
    (".c", '/* A comment of\n * two lines. */\nint a;\n', [(1, "A comment of two lines.")]),
    (".py", "# A comment\n# of two lines.\na = 1   # one\nb = 2   # another\n",
     [(1, "A comment of two lines."), (3, "one"), (4, "another")]),
    ("", "# A target.\na:\n\techo\n", [(1, "A target.")])])
def test_reads_comments_and_messages(suffix: str, text: str, read: list[tuple[int, str]]) -> None:
    assert [(line, " ".join(found.split())) for line, found in texts(text, suffix)] == read


def test_a_phrase_fails(tmp_path: Path) -> None:
    page = tmp_path / "a.md"
    for text, code in (("It is built anew.\n", 1), ("It is rebuilt.\n", 0)):
        page.write_text(text, encoding="utf-8")
        assert plain_english.main([page]) == code

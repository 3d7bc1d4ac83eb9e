"""Find phrases that read twice in pages, help, messages and docstrings: a part of `make lint`.

    python tools/plain_english.py [--list] [--lower]

Pages have no such phrase unless plain_english.toml allows some; `--list` prints every one, `--lower` lowers the limits.
"""

import argparse
import ast
import re
import sys
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
LIMITS = Path(__file__).with_suffix(".toml")
CODE = "code"   # one limit for all packages, so that a file may move
GENERATED = "docs/claims_table.md"
LONGEST = {".md": 30, ".py": 35}    # words of a sentence of a page, of code
ABOUT = "# Phrases that read twice: how many a page, or the code, may have; other pages have none. Numbers only fall."

PHRASES = {
    "'what' as a noun": re.compile(
        r"(?:^What (?!.*\?$)|\b(?:of|with|by|for|from|to|in|on|at|and|or|as|is|are|than|like|about|but|all) what )"
        r"|[,;:(] what (?!.*\?$)"),
    "'none' as a predicate": re.compile(r"(?<![Tt]here )\b(?:is|are|was|were|expected) none\b"),
    "'of yours'": re.compile(r"\bof (?:yours|ours|theirs|others)\b|\banybody's\b", re.IGNORECASE),
    "'beside'": re.compile(r"\bbeside\b", re.IGNORECASE),
    "'anew'": re.compile(r"\banew\b"),
    "'but for'": re.compile(r"\bbut for\b"),
    "'in place of'": re.compile(r"\bin place of\b", re.IGNORECASE),
    "'goes on'": re.compile(r"\bgo(?:es)? on\b"),
}
ON_PAGES = {"two semicolons": re.compile(r";.*;")}
ONE_WORD = re.compile(r"``[^`]+``|`[^`]+`|\$[^$]+\$|\\\(.*?\\\)|“[^”]*”|\"[^\"]*\"|https?://\S+", re.DOTALL)
NO_PROSE = re.compile(r"<!-- ([\w -]+?)(?::.*?)? -->.*?<!-- end of \1 -->|^```.*?^```|\$\$.*?\$\$",
                      re.DOTALL | re.MULTILINE)   # generated parts, code, equations
SENTENCE_END = re.compile(r"(?<!\bp\.)(?<!\bpp\.)(?<!\bFig\.)(?<!\bFigs\.)(?<=[.!?])\s+")


class Found(NamedTuple):
    """A phrase at a line of a file, and its sentence."""

    file: str
    line: int
    phrase: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.phrase}: {self.sentence[:100]}"


class Text(NamedTuple):
    line: int
    text: str


def plain(text: str) -> str:
    """The text with code, formulas, links and quotations as one word each."""
    text = re.sub(r"!?\[((?:[^\[\]]|\[[^\]]*\])*)\]\([^)]*\)", r"\1", text)
    return " ".join(ONE_WORD.sub("X", text).replace("*", "").split())


def problems(text: str, suffix: str) -> Iterator[tuple[str, str]]:
    """Phrases of a text of a page (.md) or of code (.py), each with its sentence."""
    for sentence in SENTENCE_END.split(plain(text)):
        for name, pattern in (PHRASES | ON_PAGES if suffix == ".md" else PHRASES).items():
            if pattern.search(sentence):
                yield name, sentence
        if (count := len(re.findall(r"\S*\w\S*", sentence))) > LONGEST[suffix]:
            yield f"{count} words, at most {LONGEST[suffix]}", sentence


def page_texts(text: str) -> Iterator[Text]:
    """Paragraphs, items of lists and cells of tables of a page, without headings, code and generated parts."""
    text = NO_PROSE.sub(lambda cut: "\n" * cut[0].count("\n"), text)
    number, lines = 1, list[str]()
    for n, line in enumerate([*text.splitlines(), ""], 1):
        if not line.strip() or line.startswith(("    ", "|", "#", "<")) or re.match(r"\s*([-*]|\d+\.) ", line):
            yield Text(number, " ".join(lines))
            number, lines = n if line.strip() else n + 1, []
        if line.startswith("|"):
            yield from (Text(n, cell) for cell in line.split("|"))
        elif not line.startswith(("    ", "<", "#")):
            lines.append(re.sub(r"^\s*([-*]|\d+\.) ", "", line))


def code_texts(text: str) -> Iterator[Text]:
    """Docstrings and other texts of four words or more of a Python file, by paragraph."""
    inner: set[int] = set()
    for node in ast.walk(ast.parse(text)):   # an f-string comes before its parts
        if isinstance(node, ast.JoinedStr):
            inner |= {id(part) for part in node.values}
            value = "".join(str(part.value) if isinstance(part, ast.Constant) else "X" for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inner:
            value = node.value
        else:
            continue
        for paragraph in re.split(r"\n\s*\n|\n\s*-{3,}\n", value):
            if len(re.findall(r"\b[a-z]{2,}\b", paragraph)) >= 4:
                yield Text(node.lineno, paragraph)


def files() -> list[Path]:
    pages = [*ROOT.glob("*.md"), ROOT / "examples" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    pages.remove(ROOT / GENERATED)
    packages = [init.parent for init in sorted(ROOT.glob("*/__init__.py")) if init.parent.name != "tests"]
    return [*pages, *(path for package in packages for path in sorted(package.rglob("*.py")))]


def found_in(path: Path) -> list[Found]:
    name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)
    texts = code_texts if path.suffix == ".py" else page_texts
    return [Found(name, line, phrase, sentence) for line, text in texts(path.read_text(encoding="utf-8"))
            for phrase, sentence in problems(text, path.suffix)]


def too_many(found: Iterable[Found], limits: Mapping[str, int]) -> dict[str, list[Found]]:
    """Pages, and the code as one, with more phrases than their limit; it is 0 unless it is given."""
    areas: dict[str, list[Found]] = {}
    for each in found:
        areas.setdefault(CODE if each.file.endswith(".py") else each.file, []).append(each)
    return {name: phrases for name, phrases in areas.items() if len(phrases) > limits.get(name, 0)}


def main(arguments: Sequence[str] | None = None, checked: Sequence[Path] = ()) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--list", action="store_true", help="list every phrase")
    parser.add_argument("--lower", action="store_true", help="lower the limits to the present counts")
    asked = parser.parse_args(arguments)
    found = [each for path in checked or files() for each in found_in(path.resolve())]
    if asked.list:
        print(*found, sep="\n")
        return 0
    limits = tomllib.loads(LIMITS.read_text(encoding="utf-8"))
    over = too_many(found, limits)
    for name, phrases in over.items():
        if name != CODE:
            print(*phrases, sep="\n")
        print(f"{name}: {len(phrases)} phrases that read twice, expected at most {limits.get(name, 0)}: "
              f"`python tools/plain_english.py --list`")
    if asked.lower:
        counts = {name: len(phrases) for name, phrases in too_many(found, {}).items()}
        rows = [f'"{name}" = {min(limit, counts[name])}' for name, limit in limits.items() if name in counts]
        LIMITS.write_text("\n".join([ABOUT, *rows, ""]), encoding="utf-8")
    return 1 if over else 0


if __name__ == "__main__":
    sys.exit(main())

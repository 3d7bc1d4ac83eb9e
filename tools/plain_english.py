"""Find phrases that have to be read twice in pages, help, messages, docstrings and comments: a part of `make lint`.

    python tools/plain_english.py
"""

import ast
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
GENERATED = "docs/claims_table.md"
LONGEST, LONGEST_ON_PAGES = 35, 30   # words of a sentence
# Comments, those in successive lines as one.
HASHED = re.compile(r"^[ \t]*#([^\n]*(?:\n[ \t]*#[^\n]*)*)|(?<=\s)# ([^\n]*)", re.MULTILINE)
SLASHED = re.compile(r"/\*(.*?)\*/|(?<![:\"'])//([^\n]*(?:\n[ \t]*//[^\n]*)*)", re.DOTALL)
# Texts that are code: with statements or rules, a program, or a list of words.
CODE_TEXT = re.compile(r"\{.*;|;.*\}|^import |^\s*(?:\w+\s+){60}", re.DOTALL)

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
    """Phrases of a text of a page (.md) or of code, each with its sentence."""
    for sentence in SENTENCE_END.split(plain(text)):
        for name, pattern in (PHRASES | ON_PAGES if suffix == ".md" else PHRASES).items():
            if pattern.search(sentence):
                yield name, sentence
        most = LONGEST_ON_PAGES if suffix == ".md" else LONGEST
        if (count := len(re.findall(r"\S*\w\S*", sentence))) > most:
            yield f"{count} words, at most {most}", sentence


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
        for paragraph in re.split(r"\n\s*\n|\n\s*-{3,}\n|(?:^|\n)\s*[\w, *]+ : [^\n]*\n|\n\s*[├└│]", value):
            if len(re.findall(r"\b[a-z]{2,}\b", paragraph)) >= 4 and not CODE_TEXT.search(paragraph):
                yield Text(node.lineno, paragraph)


def toml_texts(text: str) -> Iterator[Text]:
    """Texts of four words or more of a TOML file."""
    for n, line in enumerate(text.splitlines(), 1):
        yield from (Text(n, found) for found in re.findall(r'"([^"]*)"', line) if len(found.split()) >= 4)


def script_texts(text: str) -> Iterator[Text]:
    """Texts of four words or more of a file in C or JavaScript."""
    text = SLASHED.sub(lambda cut: "\n" * cut[0].count("\n"), text)
    for found in re.finditer(r"\"([^\"\n]*)\"|`([^`]*)`", text):
        value = re.sub(r"\$\{[^}]*\}|%\w+", "X", found[1] or found[2] or "")
        if len(re.findall(r"\b[a-z]{2,}\b", value)) >= 4 and not CODE_TEXT.search(value):
            yield Text(text.count("\n", 0, found.start()) + 1, value)


def comments(text: str, pattern: re.Pattern[str]) -> Iterator[Text]:
    """Comments of a file, those in successive lines as one."""
    for found in pattern.finditer(text):
        words = re.sub(r"\n\s*(?:#|//|\*)?", "\n", found[1] or found[2] or "")
        for paragraph in re.split(r"\n\s*\n|@param|@returns", words):
            yield Text(text.count("\n", 0, found.start(found.lastindex or 0)) + 1, paragraph)


TEXTS = {".md": page_texts, ".py": code_texts, ".toml": toml_texts, ".c": script_texts, ".h": script_texts,
         ".js": script_texts}
COMMENTS = {".py": HASHED, ".toml": HASHED, ".c": SLASHED, ".h": SLASHED, ".js": SLASHED, "": HASHED}   # "": Makefile


def texts(text: str, suffix: str) -> list[Text]:
    """Texts and comments of a file with a suffix; "" is a Makefile's."""
    read, pattern = TEXTS.get(suffix), COMMENTS.get(suffix)
    return [*(read(text) if read else ()), *(comments(text, pattern) if pattern else ())]


def files() -> list[Path]:
    pages = [*ROOT.glob("*.md"), ROOT / "examples" / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    pages.remove(ROOT / GENERATED)
    folders = [*(init.parent for init in sorted(ROOT.glob("*/__init__.py")) if init.parent.name != "tests"),
               ROOT / "scenarios", ROOT / "stages", ROOT / "examples"]
    return [*pages, ROOT / "Makefile", *(path for folder in folders for path in sorted(folder.rglob("*"))
                      if path.suffix in TEXTS and path.suffix != ".md" and "vendor" not in path.parts)]


def found_in(path: Path) -> list[Found]:
    name = path.relative_to(ROOT).as_posix() if path.is_relative_to(ROOT) else str(path)
    return [Found(name, line, phrase, sentence)
            for line, text in texts(path.read_text(encoding="utf-8"), path.suffix)
            for phrase, sentence in problems(text, path.suffix)]


def main(checked: Sequence[Path] = ()) -> int:
    found = [each for path in checked or files() for each in found_in(path.resolve())]
    print(*found, sep="\n", end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

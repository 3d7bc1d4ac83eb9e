"""The shell of the pages: one table of colours, the way from each page to the others, and the index of a folder.

A page has its kind in its head, and `<!--shell-->` at the place of the links to the others. Links are relative, so
that a folder of pages can be put anywhere.
"""

import base64
import gzip
import json
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from functools import cache
from html import escape, unescape
from pathlib import Path
from string import Template
from textwrap import shorten
from typing import NamedTuple
from urllib.parse import quote

from maglev.files.whole_file import write_whole

FOLDER = Path(__file__).with_name("shell")
TOKENS = "tokens.css"   # colours of all pages, light and dark, and the way to the others
INDEX = "index.html"
SCENE = ("camera.js", "scene.js", "space.js", "gap.js")
PLACE = "<!--shell-->"
HEAD = 4000   # bytes of a page in which its head stands
SAID = 240    # characters of a page's description in the index
SAYS = re.compile(r'<meta name="maglev-page" content="(\w+)">')
TITLE = re.compile(r"<title>(.*?)</title>", re.DOTALL)
# The beginning of NAME.json of a run: name, title and ending, as JSON; and the files next to it.
RUN = re.compile(r'\{\s*"name": ("[^\n]*"),\s*"title": ("[^\n]*"),\s*"outcome": "[^\n]*,\s*"ending": ("[^\n]*"),')
RUN_FILES = ("txt", "csv", "parquet", "json")
COMMENT = re.compile(r"^(?: *//.*|/\*\*[^`]*?\*/)\n| {2,}// .*$", re.MULTILINE)   # lines, or behind code
ABOUT = re.compile(r'<meta name="description" content="(.*?)">', re.DOTALL)

# Kinds of pages in their order, with their names in singular and plural.
KINDS = {"report": ("Report", "Reports"), "live": ("Live stage", "Live stages"),
         "compare": ("Comparison", "Comparisons"), "study": ("Study", "Studies")}
PLOTS = "script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"   # what a page with plots needs


class Page(NamedTuple):
    """A page in a folder: the name of its file, its kind, its title, its description, and its day."""

    name: str
    kind: str
    title: str
    about: str
    day: str


@cache
def read(name: str, folder: Path = FOLDER) -> str:
    """Return the text of a file of this package, or of another folder."""
    return (folder / name).read_text(encoding="utf-8")


def page(kind: str, title: str, about: str, style: str, body: str, policy: str = PLOTS, **parts: str) -> str:
    """Text of a page: its head, with a style sheet over that of all, and a body, which is a template for parts.

    The title, the description and the parts are HTML. The policy lists the allowed content next to its text: nothing
    from a network.
    """
    said = re.sub(r" (?=[.,:;])", "", " ".join(re.sub("<[^>]*>", " ", about).replace('"', "&quot;").split()))
    return Template(read("page.html")).substitute(
        kind=kind, title=title, about=said, icon=quote(read("icon.svg").strip()), style=read(TOKENS) + style,
        policy=policy, body=Template(body).substitute(parts).rstrip("\n"))


def scripts(*texts: str) -> str:
    """Return elements with the shared code of all scripts, and with scripts, without their comments."""
    return "\n".join(f"<script>\n{COMMENT.sub('', text)}</script>" for text in (read("scale.js"), *texts))


def scene() -> str:
    """Script that draws a stage on a canvas: in space, and next to it its air gap."""
    return "\n".join(map(read, SCENE))


def packed_text(data: bytes) -> str:
    """Bytes as gzip in base64: its time is zero, so that the same bytes give the same text."""
    return base64.b64encode(gzip.compress(data, 9, mtime=0)).decode("ascii")


def colour(name: str) -> str:
    """A colour on light paper, such as "#0b5cad" of "run-0": that of the pages, for pictures."""
    return str(re.findall(rf"--{name}: (#[0-9a-f]{{6}})", read(TOKENS))[0])


def publish(path: Path, text: str) -> None:
    """Write a page with the way to those that lie next to it, and the index of its folder.

    An index.html that is not of this project stays as it is.
    """
    kind = SAYS.search(text[:HEAD])
    others, own_index = [page for page in pages_in(path.parent) if page.name != path.name], has_own_index(path.parent)
    write_whole(path, text.replace(PLACE, way(others, kind[1] if kind else "", own_index)))
    if own_index:
        write_index(path.parent)


def pages_in(folder: Path) -> Iterator[Page]:
    """The pages of this project in a folder, by their names; other files are left out."""
    for path in filter(Path.is_file, sorted(folder.glob("*.html")) if folder.is_dir() else ()):
        with path.open("rb") as file:
            head = file.read(HEAD).decode("utf-8", "replace")
        kind, title, about = SAYS.search(head), TITLE.search(head), ABOUT.search(head)
        if kind and kind[1] in KINDS:
            yield Page(path.name, kind[1], unescape(title[1]).strip() if title else path.name,
                       unescape(about[1]) if about else "", day_of(path))


def day_of(path: Path) -> str:
    """The day on which a file was written, such as 2026-01-31."""
    return datetime.fromtimestamp(path.stat().st_mtime, UTC).date().isoformat()


def has_own_index(folder: Path) -> bool:
    """Return True if the index of a folder is of this project, or can be: there is none."""
    path = folder / INDEX
    if not path.is_file():
        return not path.exists()
    return bool(SAYS.search(path.read_bytes()[:HEAD].decode("utf-8", "replace")))


def way(pages: list[Page], here: str, index: bool) -> str:
    """Links from a page of a kind to the index and to others of each kind; of several to where the index lists them."""
    links = [f'<a href="{INDEX}">All results</a>'] if index else []
    for kind, (one, several) in KINDS.items():
        others = [page for page in pages if page.kind == kind]
        if kind == here:
            links.append(f'<span aria-current="page">{one}</span>')
        if len(others) == 1:
            words = one if kind != here else f"Other {one.lower()}"
            links.append(f'<a href="{escape(quote(others[0].name))}">{words}</a>')
        elif others and index:
            links.append(f'<a href="{INDEX}#{kind}">{several}</a>')
    return f'<nav class="shell" aria-label="Pages">{" ".join(links)}</nav>'


def runs_in(folder: Path) -> Iterator[str]:
    """Return entries of the index for the runs whose files lie in a folder: the end of each, its day, and its files."""
    for path in filter(Path.is_file, sorted(folder.glob("*.json"))):
        with path.open("rb") as file:
            said = RUN.match(file.read(HEAD).decode("utf-8", "replace"))
        if said and (name := json.loads(said[1])) == path.stem:   # an earlier run has another name
            files = " ".join(f'<a href="{escape(quote(other.name))}">{escape(other.suffix[1:].upper())}</a>'
                             for ending in RUN_FILES if (other := folder / f"{name}.{ending}").is_file())
            yield (f"<li>{escape(name)} <small>{day_of(path)}</small> {files}"
                   f"<p>{escape(json.loads(said[2]))}: {escape(json.loads(said[3]))}</p></li>")


def folders_in(folder: Path) -> Iterator[str]:
    """Return entries of the index for its folders that have an index of this project."""
    for path in sorted(folder.glob(f"*/{INDEX}")):
        if has_own_index(path.parent):
            yield (f'<li><a href="{escape(quote(path.parent.name))}/{INDEX}">{escape(path.parent.name)}</a> '
                   f"<small>{day_of(path)}</small></li>")


def write_index(folder: Path) -> None:
    sections = []
    pages = list(pages_in(folder))
    for kind, (one, several) in KINDS.items():
        entries = [f'<li><a href="{escape(quote(page.name))}">{escape(page.title)}</a> '
                   f"<small>{escape(page.name)}, {page.day}</small>"
                   f"<p>{escape(shorten(page.about, SAID, placeholder=' …'))}</p></li>"
                   for page in pages if page.kind == kind]
        if entries:
            sections.append(f'<section id="{kind}"><h2>{one if len(entries) == 1 else several}</h2>\n<ul>'
                            + "\n".join(entries) + "</ul></section>")
    for place, heading, more in (("runs", "Runs", [*runs_in(folder)]), ("folders", "Folders", [*folders_in(folder)])):
        if more:
            sections.append(f'<section id="{place}"><h2>{heading}</h2>\n<ul>' + "\n".join(more) + "</ul></section>")
    write_whole(folder / INDEX, page("index", "Maglev stages: results", "Every page of results in this folder.",
                                     read("index.css"), read("index.html"),
                                     "style-src 'unsafe-inline'; img-src data:", sections="\n".join(sections)))

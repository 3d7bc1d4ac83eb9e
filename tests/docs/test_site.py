"""The documentation site: it builds without a warning, from what is installed, and opens from a file."""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from report_tab import SHIFTS, violations

import maglev
from maglev.cli.app import app as command_line

DOCS = Path(__file__).parents[2] / "docs"


class Page(HTMLParser):
    """What a page links to, what it loads, and what can be linked to in it."""

    def __init__(self, text: str):
        super().__init__()
        self.links: set[str] = set()
        self.loaded: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        self.anchors |= {found[name] for name in ("id", "name") if name in found}
        if tag == "a" and "href" in found:
            self.links.add(found["href"])
        if tag in ("script", "img", "source", "iframe") and "src" in found:
            self.loaded.add(found["src"])
        if tag == "link" and found.get("rel") in ("stylesheet", "preload", "icon", "modulepreload"):
            self.loaded.add(found["href"])


@pytest.fixture(scope="module")
def site(slow: None, tmp_path_factory: pytest.TempPathFactory) -> dict[Path, Page]:
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run([sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-d", folder / "doctrees",
                           "-b", "html", DOCS, folder / "html"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return {path: Page(path.read_text(encoding="utf-8")) for path in (folder / "html").rglob("*.html")
            if path.parent.name != "stage"}   # the live page, where it was made, has tests of its own


def test_every_link_leads_somewhere(site: dict[Path, Page]) -> None:
    wrong = []
    for path, page in site.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = path if not parts.path else (path.parent / unquote(parts.path)).resolve()
            if not target.is_file() or (parts.fragment and target in site
                                        and unquote(parts.fragment) not in site[target].anchors):
                wrong.append(f"{path.name}: {link}")
    assert len(site) > 15
    assert not wrong


def test_nothing_comes_from_a_network(site: dict[Path, Page]) -> None:
    for path, page in site.items():
        assert page.loaded
        assert not [each for each in page.loaded if urlsplit(each).scheme not in ("", "data") or urlsplit(each).netloc]
        assert not [each for each in page.loaded if not urlsplit(each).scheme
                    and not (path.parent / unquote(urlsplit(each).path)).is_file()]


def test_equations_are_drawn_by_the_browser(site: dict[Path, Page]) -> None:
    text = next(path for path in site if path.name == "equations.html").read_text(encoding="utf-8")
    assert text.count("<math") > 40
    assert "$" not in text.split("<article", 1)[1].split("</article>", 1)[0]


def test_an_equation_is_found_by_its_number(site: dict[Path, Page]) -> None:
    """Sphinx splits words at a point, but looks for what was typed as a whole among the entries of its index."""
    page = next(path for path in site if path.name == "equations.html")
    _, _, text = (page.parent / "searchindex.js").read_text(encoding="utf-8").partition("(")
    index = json.loads(text.rstrip(")"))
    number = index["docnames"].index("equations")
    for typed in ("(4.16)", "equation 4.16"):
        anchors = [anchor for document, anchor, _ in index["indexentries"][typed] if document == number]
        assert anchors and set(anchors) <= site[page].anchors


def test_colours_are_those_of_the_pages(site: dict[Path, Page]) -> None:
    """Light, and dark twice: as the system asks, and by the switch of the site."""
    found = next(path for path in site if path.name == "index.html").parent / "_static" / "tokens.css"
    style = (DOCS.parent / "maglev" / "pages" / "shell" / "tokens.css").read_text(encoding="utf-8")
    light, dark = re.findall(r"--phase-0: (#\w+);", style)
    text = found.read_text(encoding="utf-8")
    assert re.findall(r"--phase-0: (#\w+);", text) == [light, dark, dark]


def test_the_first_page_has_a_description_for_links(site: dict[Path, Page]) -> None:
    path = next(path for path in site if path.name == "index.html")
    text = path.read_text(encoding="utf-8")
    title, *_ = re.findall(r"<title>(.*?)</title>", text)   # others are of icons
    assert title == f"Maglev FMUs {version('maglev-fmus')}"
    said = {name: content for content, name in re.findall(r'<meta content="([^"]*)" (?:name|property)="([^"]*)"', text)}
    assert said["og:title"] == "Maglev FMUs"
    assert said["description"] == said["og:description"] and 60 < len(said["description"]) < 160
    icon, = re.findall(r'<link rel="shortcut icon" href="([^"]+)"', text)
    for shown in (said["og:image"], icon):
        assert (path.parent / shown).is_file(), shown


@pytest.mark.parametrize("width", [1440, 390])
def test_the_first_page_begins_with_its_picture_and_nothing_moves(browser, site: dict[Path, Page], width: int) -> None:
    context = browser.new_context(offline=True, viewport={"width": width, "height": 844})
    tab = context.new_page()
    tab.goto(next(path for path in site if path.name == "index.html").as_uri())
    shifts = tab.evaluate(SHIFTS)
    top, bottom, kept, natural = tab.evaluate("""(() => {
        // The live page, where it was made, is there instead of its picture.
        const picture = document.querySelector("article img, article .live iframe");
        const { top, bottom } = picture.getBoundingClientRect(), { aspectRatio } = getComputedStyle(picture);
        if (picture.tagName === "IMG")
            return [top, bottom, aspectRatio, `auto ${picture.naturalWidth} / ${picture.naturalHeight}`];
        // A frame without a size of its own has 150 px; one for a phone is nearly as high as its screen.
        return [top, Math.min(bottom, innerHeight - 1), bottom - top > innerHeight / 2, true];
    })()""")
    context.close()
    assert sum(share for share, *_ in shifts) < 0.05, shifts
    assert 0 < top < bottom < 844
    assert kept == natural, "its room is kept before it has come"


@pytest.mark.parametrize(("name", "width", "scheme"), [("index", 390, "dark"), ("equations", 390, "light")])
def test_a_page_can_be_read(browser, site: dict[Path, Page], name: str, width: int, scheme: str) -> None:
    context = browser.new_context(offline=True, viewport={"width": width, "height": 900}, color_scheme=scheme)
    tab = context.new_page()
    tab.goto(next(path for path in site if path.name == f"{name}.html").as_uri())
    assert tab.evaluate("document.documentElement.scrollWidth") <= width
    found = violations(tab, rules=["landmark-unique"])   # of the theme's drawers
    context.close()
    assert found == []


@pytest.mark.parametrize("name", ["equations", "tutorial"])
def test_paper_cuts_nothing_and_has_no_list_of_the_page(browser, site: dict[Path, Page], name: str) -> None:
    context = browser.new_context(offline=True, viewport={"width": 688, "height": 900})   # px between margins of 14 mm
    tab = context.new_page()
    tab.emulate_media(media="print")
    tab.goto(next(path for path in site if path.name == f"{name}.html").as_uri())
    cut = tab.evaluate("""[...document.querySelectorAll("div.math, pre, .table-wrapper")]
        .filter(({ scrollWidth, clientWidth }) => scrollWidth > clientWidth).map(({ textContent }) => textContent)""")
    listed = tab.is_visible(".toc-drawer")
    whole = tab.evaluate("[...document.querySelectorAll('article table')]"
                         ".filter((table) => getComputedStyle(table).breakInside !== 'auto').length")
    context.close()
    assert (cut, listed, whole) == ([], False, 0)


def test_headings_have_a_level(site: dict[Path, Page]) -> None:
    """The role alone says nothing to a screen reader."""
    headings = [tag for path in site for tag in re.findall(r'<[^>]*role="heading"[^>]*>', path.read_text("utf-8"))]
    assert headings
    assert all('aria-level="2"' in tag for tag in headings)


def test_the_reference_is_complete(site: dict[Path, Page]) -> None:
    functions = next(page for path, page in site.items() if path.name == "functions.html")
    assert {f"maglev.{name}" for name in maglev.__all__} <= functions.anchors
    commands = next(page for path, page in site.items() if path.name == "command_line.html")
    names = [each.name or each.callback.__name__ for each in command_line.registered_commands if each.callback]
    assert names
    assert {f"maglev-{name}" for name in names} <= commands.anchors

"""The way from each page to those next to it, and the index of a folder: whatever was written in which order."""

import json
import re
from datetime import UTC, datetime
from html.parser import HTMLParser
from pathlib import Path

import pytest

from maglev.pages.shell import HEAD, INDEX, KINDS, PLACE, SAYS, TITLE, colour, page, publish, read


def a_page(kind: str, title: str) -> str:
    """Text of a page of a kind."""
    return (f'<!DOCTYPE html>\n<meta name="maglev-page" content="{kind}"><title>{title}</title>\n'
            f"<header>{PLACE}</header>")


class Links(HTMLParser):
    """Addresses and words of the links of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.found: list[list[str]] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.inside = tag == "a"
        if self.inside:
            self.found.append([dict(attributes)["href"] or "", ""])

    def handle_endtag(self, tag: str) -> None:
        self.inside = False

    def handle_data(self, text: str) -> None:
        if getattr(self, "inside", False):
            self.found[-1][1] += text


def links(path: Path) -> list[tuple[str, str]]:
    return [(address, words) for address, words in Links(path).found]


def test_pages_lead_to_each_other_and_the_index_lists_them(tmp_path: Path) -> None:
    publish(tmp_path / "report.html", a_page("report", "All &amp; everything"))
    assert links(tmp_path / "report.html") == [(INDEX, "All results")], "what is missing is left out"
    publish(tmp_path / "a b.html", a_page("study", "Payload"))
    assert links(tmp_path / "a b.html") == [(INDEX, "All results"), ("report.html", "Report")]
    publish(tmp_path / "c.html", a_page("study", "Friction"))
    assert links(tmp_path / "c.html")[1:] == [("report.html", "Report"), ("a%20b.html", "Other study")]
    (tmp_path / "mine.html").write_text("<title>somebody else's</title>", encoding="utf-8")
    publish(tmp_path / "report.html", a_page("report", "All &amp; everything"))
    assert links(tmp_path / "report.html") == [(INDEX, "All results"), (f"{INDEX}#study", "Studies")]
    assert links(tmp_path / INDEX) == [("report.html", "All & everything"), ("a%20b.html", "Payload"),
                                       ("c.html", "Friction")]
    assert 'id="study"' in (tmp_path / INDEX).read_text(encoding="utf-8")


def test_the_index_has_what_a_page_says(tmp_path: Path) -> None:
    said = '<p>Does "it" hold? <strong>1 of 2</strong>, or so</p>'
    publish(tmp_path / "a.html", page("study", "Payload", said, "", ""))
    assert "<p>Does &quot;it&quot; hold? 1 of 2, or so</p>" in (tmp_path / INDEX).read_text(encoding="utf-8")


def test_an_index_of_somebody_else_stays(tmp_path: Path) -> None:
    (tmp_path / INDEX).write_text("<h1>mine</h1>", encoding="utf-8")
    publish(tmp_path / "report.html", a_page("report", "All"))
    assert (tmp_path / INDEX).read_text(encoding="utf-8") == "<h1>mine</h1>"
    assert links(tmp_path / "report.html") == []


def test_colours_are_those_of_the_light_pages() -> None:
    light, dark = (dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", part))
                   for part in read("tokens.css").split("@media screen")[:2])
    assert light.keys() == dark.keys(), "a colour of one scheme is missing in the other"
    assert colour("run-0") == light["run-0"] != dark["run-0"]
    with pytest.raises(IndexError):
        colour("none-such")


def test_every_template_has_a_place_for_the_way_and_its_page_says_what_it_is() -> None:
    root = Path(__file__).parents[3] / "maglev/pages"
    for path in (root / "report/page.html", root / "comparison/comparison.html", root / "study/study.html",
                 root / "live/page.html"):
        assert path.read_text(encoding="utf-8").count(PLACE) == 1
    for kind in KINDS:
        made = page(kind, "A &amp; B", "<b>C</b>", "p {}", f"<body>{PLACE}${{words}}</body>\n", words="said")
        assert SAYS.findall(made[:HEAD]) == [kind] and TITLE.findall(made[:HEAD]) == ["A &amp; B"]
        assert made.endswith(f"</head>\n<body>{PLACE}said</body>\n</html>\n")


def test_the_index_lists_runs_with_what_came_of_them_and_folders(tmp_path: Path) -> None:
    """A run by its NAME.json, as `maglev run` writes it; other JSON, and files of an earlier run, are left out."""
    about = {"name": "push", "title": "a <push>", "outcome": "failed", "ending": "failed: it fell", "failure": None}
    for name in ("push.json", "push.previous.json"):
        (tmp_path / name).write_text(json.dumps(about, indent=1), encoding="utf-8")
    (tmp_path / "push.csv").write_text("time\n", encoding="utf-8")
    (tmp_path / "push.compare.json").write_text('{"name": "push", "title": "t", "verdict": "v"}', encoding="utf-8")
    publish(tmp_path / "more" / "study.html", page("study", "Payload", "It holds", "", "<body></body>"))
    publish(tmp_path / "study.html", page("study", "Payload", "It holds", "", "<body></body>"))
    text = (tmp_path / INDEX).read_text(encoding="utf-8")
    day = datetime.now(UTC).date().isoformat()
    assert "<p>a &lt;push&gt;: failed: it fell</p>" in text and text.count("it fell") == 1
    assert links(tmp_path / INDEX)[1:] == [("push.csv", "CSV"), ("push.json", "JSON"), ("more/index.html", "more")]
    assert text.count(f"{day}</small>") == 3

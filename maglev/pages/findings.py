"""Outcomes of the procedures as HTML: tables of values, and notes for the reader."""

import re
from collections.abc import Iterable, Sequence
from html import escape

from maglev.files.fmi_units import RAISED
from maglev.files.text_columns import unbroken
from maglev.fmi.documentation import breakable
from maglev.pages.figures import anchor, stage_name
from maglev.runs.procedure_outcome import Outcome, ValueTable

POWER = re.compile(r"(?<=\d)e([+-]\d+)\b")
MINUS = re.compile(r"(?<![\w.)\]-])-(?=\.?\d)")   # before a number, not in a name


def typeset(text: str) -> str:
    """HTML of a text with numbers: kept with their units, with a minus sign, U+2212, before them, and powers of ten."""
    powers = POWER.sub(lambda found: f" · 10{str(int(found[1])).translate(RAISED)}", text)
    return escape(MINUS.sub("\N{MINUS SIGN}", unbroken(powers)))


def findings_section(outcomes: Iterable[Outcome]) -> str:
    """Section of the page with the tables and the notes; empty if there are none."""
    articles = []
    for outcome in outcomes:
        if outcome.tables or outcome.notes:
            name, notes = outcome.settings.name, "".join(f"<li>{typeset(note)}</li>" for note in outcome.notes)
            articles.append(f'<article id="{anchor("found", name)}" data-stage="{stage_name(name)}">'
                            f"<h3>{escape(outcome.settings.title)}</h3>"
                            f'<p class="origin"><a href="#{anchor("procedure", name)}">{escape(name)}</a></p>\n'
                            + "".join(map(value_table, outcome.tables))
                            + (f'<ul class="notes">{notes}</ul>' if notes else "") + "</article>")
    parts = "\n".join(articles)
    return parts and f'\n\n<section id="identification">\n<h2>Identification</h2>\n{parts}\n</section>'


def value_table(table: ValueTable) -> str:
    """One table; the first cell of a row is its heading."""
    return html_table(table.header, ([*map(typeset, row)] for row in table.rows), table.title) + "\n"


def html_table(heads: Iterable[str], rows: Iterable[Sequence[str]], title: str = "", look: str = "") -> str:
    """Table under headings of text; of the cells of a row, which are HTML, the first is its heading.

    Of the look "cards" each row is a card on a phone, of "cards numbers" with a line for each number.
    """
    first_head, *names = heads
    labels = [escape(name) for name in names]
    head = "".join(f'<th scope="col">{breakable(text)}</th>' for text in (first_head, *names))
    body = "\n".join(f'<tr><th scope="row">{first}</th>' + "".join(
        f'<td data-label="{label}">{cell}</td>' if look else f"<td>{cell}</td>"
        for label, cell in zip(labels, cells, strict=True)) + "</tr>" for first, *cells in rows)
    caption = f"<caption>{escape(title)}</caption>\n" if title else ""
    return (f'<div class="wide" tabindex="0" role="group" aria-label="{escape(title) or "Table"}">'
            f'<table class="{f"values {look}".rstrip()}">{caption}<thead><tr>{head}</tr></thead>\n'
            f"<tbody>{body}</tbody></table></div>")

"""The table of claims in the documentation is that of the scenarios."""

import re
from pathlib import Path

from packaged_plans import RUNS

from maglev.runs.verdicts import VERDICTS
from maglev.scenario.claims import CLAIM_KINDS, Claim

DOCS = Path(__file__).parents[1] / "docs"


def test_the_readme_counts_what_the_page_counts() -> None:
    page, readme = (file.read_text(encoding="utf-8") for file in (DOCS / "claims.md", DOCS.parent / "README.md"))
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("|")][2:7]
    counts = {name: (reproduced, claims) for name, claims, reproduced, *_ in rows}
    assert list(counts) == [*CLAIM_KINDS.values(), "all"]
    said = re.findall(r"(\d+) of (\d+) (printed numbers|orderings|specifications|claims)", " ".join(readme.split()))
    assert said == [(*counts[kind], "claims" if kind == "survival" else kind) for kind in CLAIM_KINDS.values()]


def test_the_table_has_every_claim_with_a_verdict() -> None:
    page = (DOCS / "claims_table.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split(" | ")] for line in page.splitlines()
            if line.startswith("| `") and line.count(" | ") == 5]
    procedures = {run.procedure.name: run.procedure for run in RUNS if run.procedure is not None}
    claims: list[tuple[str, Claim]] = [(run.name, claim) for run in RUNS for claim in run.claims]
    claims += [(name, claim) for name, procedure in sorted(procedures.items()) for claim in procedure.claims]
    # The claims in words stand in tables of their own by what they state, before the bounds of figures.
    kinds = [*CLAIM_KINDS]
    claims.sort(key=lambda each: len(kinds) if each[1].figure is not None else kinds.index(each[1].kind))
    assert [row[:4] for row in rows] == [[f"| `{name}`", claim.text, claim.cited, claim.criterion]
                                         for name, claim in claims], "`make claims` makes the table again"
    for row, (_, claim) in zip(rows, claims, strict=True):
        verdict, _, reason = row[5].removesuffix(" |").replace("**", "").partition(": ")
        assert verdict in VERDICTS
        assert verdict != "not run"
        if verdict in ("no difference", "not reproduced", "not testable"):
            owed = claim.reason or claim.not_testable
            assert owed and reason.startswith(owed), "a reason is owed"

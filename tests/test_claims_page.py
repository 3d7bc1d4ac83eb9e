"""The table of claims in the documentation is that of the scenarios."""

import re
from pathlib import Path

from maglev.judging.verdicts import VERDICTS
from maglev.schema.claims import Claim
from maglev.schema.layers import packaged_files
from maglev.schema.loading import load_plans

PAGE = Path(__file__).parents[1] / "docs" / "claims.md"


def test_the_readme_counts_what_the_page_counts() -> None:
    counts = re.search(r"(\d+) claims on .*?: (\d+) reproduced, (\d+) within 10 %, (\d+) not reproduced, "
                       r"(\d+) not testable. (\d+) of (\d+) bounds .*? are met, (\d+) of them",
                       PAGE.read_text(encoding="utf-8"))
    assert counts
    claims, good, close, bad, untested, met, bounds, chosen = counts.groups()
    said = " ".join((PAGE.parents[1] / "README.md").read_text(encoding="utf-8").split())
    assert (f"Of {claims} claims that it makes in words, {good} reproduce, {close} comes within 10 %, {untested} "
            f"cannot be tested, and {bad} do not") in said
    assert f"Of {bounds} bounds that the axes of its figures set, {met} are met, {chosen} of them by figures" in said


def test_the_table_has_every_claim_with_a_verdict() -> None:
    rows = [[cell.strip() for cell in line.split(" | ")] for line in PAGE.read_text(encoding="utf-8").splitlines()
            if line.startswith("| `") and line.count(" | ") == 5]
    runs = [run for name in packaged_files() for run in load_plans(name)]
    procedures = {run.procedure.name: run.procedure for run in runs if run.procedure is not None}
    claims: list[tuple[str, Claim]] = [(run.name, claim) for run in runs for claim in run.claims]
    claims += [(name, claim) for name, procedure in sorted(procedures.items()) for claim in procedure.claims]
    # The claims in words stand in a table of their own, before the bounds of figures.
    claims.sort(key=lambda each: each[1].figure is not None)
    assert [row[:4] for row in rows] == [[f"| `{name}`", claim.text, claim.source, claim.criterion]
                                         for name, claim in claims], "`make claims` makes the table anew"
    for row, (_, claim) in zip(rows, claims, strict=True):
        verdict, _, reason = row[5].removesuffix(" |").replace("**", "").partition(": ")
        assert verdict in VERDICTS
        assert verdict != "not run"
        if verdict in ("not reproduced", "not testable"):
            owed = claim.reason or claim.not_testable
            assert owed and reason.startswith(owed), "a reason is owed"

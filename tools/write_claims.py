"""Put the table of claims of all runs into docs/claims.md, between its markers.

    maglev run --all && python tools/write_claims.py results/claims.md
    python tools/write_claims.py results/claims.md --check     # exits with 1 where the page has other numbers
"""

import sys
from difflib import unified_diff
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "claims.md"
BEGIN = "<!-- claims: made by `make claims` -->\n"
END = "<!-- end of claims -->\n"


def with_claims(page: str, claims: str) -> str:
    """Text of the page with the claims between the markers; both must be there."""
    before, begin, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(f"{PAGE}: expected the lines {BEGIN.strip()} and {END.strip()}")
    return f"{before}{BEGIN}\n{claims}\n{END}{after}"


if __name__ == "__main__":
    old = PAGE.read_text(encoding="utf-8")
    new = with_claims(old, Path(sys.argv[1]).read_text(encoding="utf-8"))
    if "--check" not in sys.argv[2:]:
        PAGE.write_text(new, encoding="utf-8")
    elif new != old:
        sys.stdout.writelines(unified_diff(old.splitlines(True), new.splitlines(True), "page", "runs", n=0))
        sys.exit("docs/claims.md: other numbers than those of these runs, expected what `make claims` writes")

"""Put the table of claims of all runs into docs/claims.md, between its markers.

    maglev run --all && python tools/write_claims.py results/claims.md
"""

import sys
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
    PAGE.write_text(with_claims(PAGE.read_text(encoding="utf-8"), Path(sys.argv[1]).read_text(encoding="utf-8")),
                      encoding="utf-8")

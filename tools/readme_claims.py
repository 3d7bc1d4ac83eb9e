"""Put the table of claims of a study into the README, between its markers.

    maglev run --all && python tools/readme_claims.py results/claims.md
"""

import sys
from pathlib import Path

README = Path(__file__).parents[1] / "README.md"
BEGIN = "<!-- claims: made by `make claims` -->\n"
END = "<!-- end of claims -->\n"


def with_claims(readme: str, claims: str) -> str:
    """Text of the README with the claims between the markers; both must be there."""
    before, begin, rest = readme.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not begin or not end:
        raise SystemExit(f"{README}: expected the lines {BEGIN.strip()} and {END.strip()}")
    return f"{before}{BEGIN}\n{claims}\n{END}{after}"


if __name__ == "__main__":
    README.write_text(with_claims(README.read_text(encoding="utf-8"), Path(sys.argv[1]).read_text(encoding="utf-8")),
                      encoding="utf-8")

"""Put the tables of claims of all runs into docs/claims_table.md, and their counts into docs/claims.md.

    maglev run --all && python tools/write_claims.py results/claims.md
    python tools/write_claims.py results/claims.md --check     # exits with 1 where a page has other numbers
"""

import sys
from difflib import unified_diff
from pathlib import Path

from maglev.files.marked import with_part

DOCS = Path(__file__).parents[1] / "docs"

if __name__ == "__main__":
    counts, _, tables = Path(sys.argv[1]).read_text(encoding="utf-8").partition("\n## ")
    differing: list[str] = []
    for page, part in ((DOCS / "claims.md", counts), (DOCS / "claims_table.md", f"## {tables}")):
        old = page.read_text(encoding="utf-8")
        new = with_part(page, "claims", part)
        differing += unified_diff(old.splitlines(True), new.splitlines(True), page.name, "runs", n=0)
        if "--check" not in sys.argv[2:]:
            page.write_text(new, encoding="utf-8")
    if "--check" in sys.argv[2:] and differing:
        sys.stdout.writelines(differing)
        sys.exit("docs: other claims than those of these runs, expected what `make claims` writes")

"""The tables of keys and units in the documentation are those that files are read by; each key has a meaning."""

import runpy
from pathlib import Path

from maglev.files.marked import with_part
from maglev.scenario.toml_table import Table

ROOT = Path(__file__).parents[2]
NO_KEYS = {"own", "inherited", "open_unit"}   # of tables as they are merged, not of files


def test_the_page_has_every_key() -> None:
    tool = runpy.run_path(str(ROOT / "tools" / "write_keys.py"))
    page = tool["PAGE"].read_text(encoding="utf-8")
    for name, made in tool["PARTS"].items():
        assert with_part(tool["PAGE"], name, made()) == page, "`python tools/write_keys.py` makes the tables again"
    tables = tool["TABLES"]
    scenario = [table for table in Table.known_tables() if table.__module__.startswith("maglev.scenario")]
    assert {table for table in scenario if table.PLACE} == set(tables)
    for table in tables:
        assert not [name for name, field in table.model_fields.items()
                    if not field.description and name not in {*NO_KEYS, "quantity"}], table
    for key in ("output_interval", "tracking_from", "terms", "fail_error", "bands", "trip_flag", "stop_flag", "column"):
        assert f"| `{key}` |" in page

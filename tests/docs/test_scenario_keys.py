"""The documentation has every key that files are read by; each key has a meaning."""

import runpy
from pathlib import Path

from maglev.scenario.toml_table import Table

ROOT = Path(__file__).parents[2]
NO_KEYS = {"own", "inherited", "open_unit"}   # of tables as they are merged, not of files


def test_the_page_has_every_key() -> None:
    page = (ROOT / "docs" / "scenario_keys.md").read_text(encoding="utf-8")
    tables = runpy.run_path(str(ROOT / "tools" / "write_tables.py"))["TABLES"]
    scenario = [table for table in Table.known_tables() if table.__module__.startswith("maglev.scenario")]
    assert {table for table in scenario if table.PLACE} == set(tables)
    for table in tables:
        assert not [name for name, field in table.model_fields.items()
                    if not field.description and name not in {*NO_KEYS, "quantity"}], table
    for key in ("output_interval", "tracking_from", "terms", "fail_error", "bands", "trip_flag", "stop_flag", "column"):
        assert f"| `{key}` |" in page

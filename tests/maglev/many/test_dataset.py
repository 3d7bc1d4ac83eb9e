"""A finished dataset is believed for as long as it is as it was written."""

from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

import maglev
from maglev.files.errors import MaglevError
from maglev.many.dataset import SEAL, Contents, is_as_written, merge_parts, read_dataset
from maglev.many.study_columns import METADATA

SCHEMA = pa.schema([pa.field("sample", pa.int64()), pa.field("mass", pa.float64(), metadata={"unit": "kg"}),
                    pa.field("passed", pa.bool_()), pa.field("failure", pa.string())],
                   metadata={METADATA: b'{"key": "k", "name": "s", "samples": 5, "scenario": "t"}'})
ROWS = pa.table([[0, 1, 2, 3, 4], [4.0, None, float("nan"), -0.0, 5.0], [True, False, None, True, True],
                 [None, "it\nfell", "", None, "it"]], schema=SCHEMA)

Edit = Callable[[pa.Table], pa.Table]


def written(path: Path) -> Path:
    sink = pa.BufferOutputStream()
    pq.write_table(ROWS, sink)
    merge_parts(iter([sink.getvalue().to_pybytes()]), SCHEMA, path)
    return path


def with_column(name: str, values: list[object]) -> Edit:
    return lambda table: table.set_column(table.schema.get_field_index(name), table.schema.field(name),
                                          pa.array(values, table.schema.field(name).type))


def with_metadata(old: bytes, new: bytes) -> Edit:
    return lambda table: table.replace_schema_metadata({METADATA: table.schema.metadata[METADATA].replace(old, new)})


EDITS: dict[str, Edit] = {
    "a value": with_column("mass", [4.0, None, float("nan"), -0.0, 9.0]),
    "a sign": with_column("mass", [4.0, None, float("nan"), 0.0, 5.0]),
    "a null": with_column("mass", [4.0, 0.0, float("nan"), -0.0, 5.0]),
    "no number": with_column("mass", [4.0, float("nan"), float("nan"), -0.0, 5.0]),
    "a verdict": with_column("passed", [True, True, None, True, True]),
    "a missing verdict": with_column("passed", [True, False, False, True, True]),
    "a reason": with_column("failure", [None, "it\nflew", "", None, "it"]),
    "no reason": with_column("failure", [None, "it\nfell", None, None, "it"]),
    "texts that join": with_column("failure", [None, "it", "fell", None, "it"]),
    "the order": lambda table: table.take(pc.array_sort_indices(table["sample"], order="descending")),
    "a row less": lambda table: table.slice(0, 4),
    "a row twice": lambda table: pa.concat_tables([table, table.slice(0, 1)]),
    "a name": lambda table: table.rename_columns(["sample", "weight", "passed", "failure"]).replace_schema_metadata(
        table.schema.metadata),
    "a type": lambda table: table.cast(pa.schema([SCHEMA.field(0), SCHEMA.field(1), SCHEMA.field(2),
                                                  pa.field("failure", pa.large_string())], metadata=SCHEMA.metadata)),
    "a unit": lambda table: table.cast(pa.schema([SCHEMA.field(0), pa.field("mass", pa.float64(), metadata={
        "unit": "g"}), SCHEMA.field(2), SCHEMA.field(3)], metadata=SCHEMA.metadata)),
    "a limit": with_metadata(b'"t"', b'"u"')}


@pytest.mark.parametrize("edit", EDITS.values(), ids=EDITS)
def test_refuses_an_edited_dataset(edit: Edit, tmp_path: Path) -> None:
    """Also where the digest is kept in it, as nobody does by accident."""
    path = written(tmp_path / "s.parquet")
    assert is_as_written(path, "k") and not is_as_written(path, "l")
    assert read_dataset(path).schema.equals(pq.read_table(path).schema, check_metadata=True)
    assert str(read_dataset(path).to_pylist()) == str(ROWS.to_pylist())   # as text: NaN differs from itself
    seal = pq.ParquetFile(path).metadata.metadata[SEAL]
    edited = edit(pq.read_table(path))
    for kept in ({}, {SEAL: seal}):
        with pq.ParquetWriter(path, edited.schema) as writer:
            writer.write_table(edited)
            writer.add_key_value_metadata(kept)
        assert not is_as_written(path, "k")
        with raises(MaglevError, path, "edited"):
            maglev.Study(path).to_arrow()


@given(cuts=st.lists(st.integers(0, 5), max_size=4).map(sorted))
def test_portions_do_not_matter(cuts: list[int]) -> None:
    whole, portions = Contents(SCHEMA), Contents(SCHEMA)
    whole.add(ROWS)
    for begin, end in zip([0, *cuts], [*cuts, 5], strict=True):
        portions.add(ROWS.slice(begin, end - begin))
    assert portions.sha256 == whole.sha256

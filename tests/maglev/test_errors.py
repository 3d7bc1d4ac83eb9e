"""What all refusals share: keys as TOML has them, in one line."""

import tomllib

from hypothesis import given
from hypothesis import strategies as st

from maglev.errors import in_one_line, key_path

KEYS = st.text(st.characters(exclude_categories=["Cs"]))


@given(st.lists(KEYS, min_size=1, max_size=3))
def test_a_key_is_one_that_toml_reads(keys: list[str]) -> None:
    """Whatever is in it: line ends, quotes, what reorders a line."""
    path = key_path(keys)
    assert len(f"{path} ".splitlines()) == 1 and path.isprintable()
    found = tomllib.loads(f"{path} = 1")
    for key in keys:
        assert list(found) == [key]
        found = found[key]
    assert found == 1


def test_keys_and_places() -> None:
    assert key_path(["signals", 0, "v.reference", "a\nb"]) == 'signals[0]."v.reference"."a\\nb"'


@given(st.text())
def test_one_line(text: str) -> None:
    assert len(f"{in_one_line(text)} ".splitlines()) == 1

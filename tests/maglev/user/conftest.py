"""What a test lets the process know of stages is forgotten after it."""

from collections.abc import Iterator

import pytest

from maglev.descriptions.registry import known_stages


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    yield
    known_stages().forget(*known_stages().own)

"""What a test lets the process know of stages is forgotten after it."""

from collections.abc import Iterator

import pytest

from maglev.own_stage.adoption import OWN, forget


@pytest.fixture(autouse=True)
def forgotten() -> Iterator[None]:
    yield
    for name in [*OWN]:
        forget(name)

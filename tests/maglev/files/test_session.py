"""The session has one part of each class, and tests begin with none."""

from maglev.files.session import Session


class Part:
    def __init__(self) -> None:
        self.closed = False

    def close(self) -> None:
        self.closed = True


def test_a_part_is_made_once() -> None:
    session = Session()
    assert session.part(Part) is session.part(Part)
    assert session.part(dict) == {}
    assert session.use(Part()) is session.part(Part)


def test_a_block_begins_with_no_parts_and_closes_its_own() -> None:
    session = Session()
    before = session.part(Part)
    with session.anew():
        inside = session.part(Part)
        assert inside is not before and not inside.closed
    assert inside.closed
    assert session.part(Part) is before and not before.closed

"""The session has one object of each class, and a block of a test begins with none."""

from maglev.files.session import Session


class Kept:
    def __init__(self) -> None:
        self.closed = False

    def close(self) -> None:
        self.closed = True


def test_makes_an_object_once() -> None:
    session = Session()
    assert session.get(Kept) is session.get(Kept)
    assert session.get(dict) == {}
    assert session.use(Kept()) is session.get(Kept)


def test_a_block_begins_without_objects_and_closes_its_own() -> None:
    session = Session()
    before = session.get(Kept)
    with session.anew():
        inside = session.get(Kept)
        assert inside is not before and not inside.closed
    assert inside.closed
    assert session.get(Kept) is before and not before.closed

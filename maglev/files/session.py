"""State of a process from one call to the next: one object has all of it, and tests replace it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


class Session:
    """Parts that live on, such as the user's stages: one object of a class, made when it is first asked for.

    A part that has a method `close` is closed at the end of the process. Modules keep nothing themselves.
    """

    def __init__(self) -> None:
        self.parts: dict[type, Any] = {}

    def part(self, kind: type[T]) -> T:
        """Return the part of a class, which is made without arguments."""
        found: T | None = self.parts.get(kind)
        return self.use(kind()) if found is None else found

    def use(self, part: T, kind: type[T] | None = None) -> T:
        """Keep a part of its class, or of `kind`, unless there is one; return the one that is kept."""
        kept: T = self.parts.setdefault(kind or type(part), part)
        if kept is part and hasattr(part, "close"):
            from multiprocessing.util import Finalize  # a process that closes nothing does not wait for it

            Finalize(None, part.close, exitpriority=0)   # also in processes of multiprocessing, unlike atexit
        return kept

    @contextmanager
    def anew(self) -> Iterator[None]:
        """Begin a block with no parts, close those that it makes, and then have those of before again."""
        before, self.parts = self.parts, {}
        try:
            yield
        finally:
            for part in reversed(self.parts.values()):
                if hasattr(part, "close"):
                    part.close()
            self.parts = before


SESSION = Session()

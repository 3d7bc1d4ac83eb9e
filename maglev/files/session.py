"""State of a process from one call to the next: one object has all of it, and tests replace it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


class Session:
    """Objects that live on, such as the stages of users: one of each class. Modules keep no state themselves.

    An object is made when it is first asked for. If it has a method `close`, that is called at the end of the process.
    """

    def __init__(self) -> None:
        self.objects: dict[type, Any] = {}

    def get(self, kind: type[T]) -> T:
        """Return the object of a class, which is made without arguments."""
        known: T | None = self.objects.get(kind)
        return self.use(kind()) if known is None else known

    def use(self, new: T, kind: type[T] | None = None) -> T:
        """Keep an object for its class, or for `kind`, unless there is one already; return the one that is kept."""
        kept: T = self.objects.setdefault(kind or type(new), new)
        if kept is new and hasattr(new, "close"):
            from multiprocessing.util import Finalize  # a process that closes nothing does not wait for it

            Finalize(None, new.close, exitpriority=0)   # also in processes of multiprocessing, unlike atexit
        return kept

    @contextmanager
    def anew(self) -> Iterator[None]:
        """Begin a block without objects; after it, close those of the block, and restore those of before."""
        before, self.objects = self.objects, {}
        try:
            yield
        finally:
            for each in reversed(self.objects.values()):
                if hasattr(each, "close"):
                    each.close()
            self.objects = before


SESSION = Session()

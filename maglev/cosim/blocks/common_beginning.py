"""What the runs of a batch begin with in common, as constants in the C of their loop.

Nearly all that a run begins with are parameters and what follows from them, which samples have in common but for a few.
As constants they take no memory, and what they switch off is left out: a flexible mode, a rough rail, a noise. Every
operation that is left has the operands that it had, so that the bits of a run stay.
"""

from collections.abc import Iterable, Sequence
from ctypes import Structure
from typing import NamedTuple, Self

import numpy as np
import numpy.typing as npt

from maglev.cosim.blocks import HERE, filled

Words = npt.NDArray[np.uint64]
WORD = np.dtype(np.uint64).itemsize


class Common(NamedTuple):
    """What a run of several begins with, in words, and the places of those that others begin with otherwise."""

    words: Words
    places: tuple[int, ...]

    @classmethod
    def of(cls, words: Words, before: Self | None = None) -> Self:
        """Of runs, shape (runs, words), and of those before."""
        first = words[0] if before is None else before.words
        places = {*(before.places if before is not None else ()), *np.flatnonzero((words != first).any(0)).tolist()}
        return cls(first, tuple(sorted(places)))

    def holds(self, words: Words) -> bool:
        """Whether runs, shape (runs, words), differ at these places alone."""
        return not np.delete((words != self.words).any(0), self.places).any()

    def code(self, calls: Iterable[Structure]) -> str:
        """C of it, for behind that of the run; `calls` are the struct moved of the loop."""
        moved = ", ".join(f"{{{', '.join(repr(getattr(call, name)) for name, *_ in call._fields_)}}}" for call in calls)
        return filled(
            HERE / "common_beginning.h", begins=", ".join(map(str, self.words.tobytes())), calls=moved,
            count=max(1, len(self.places)),
            places="\n".join(f"    __builtin_memcpy((char *)beginning + {WORD * place}, own + {k}, {WORD});"
                             for k, place in enumerate(self.places)),
            words="\n".join(f"    __builtin_memcpy(own + {k}, (const char *)beginning + {WORD * place}, {WORD});"
                            for k, place in enumerate(self.places)))


def words_of(beginnings: Sequence[bytes]) -> Words:
    """What runs begin with, shape (runs, words)."""
    return np.frombuffer(b"".join(beginnings), np.uint64).reshape(len(beginnings), -1)

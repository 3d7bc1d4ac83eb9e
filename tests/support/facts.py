"""What an error or a warning has to tell: its class, and the facts in its message. The words around them may change.

Facts are names, values, units, files, lines, options: what a reader needs to find the mistake, and to correct it.
"""

import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TypeVar

import pytest

E = TypeVar("E", bound=BaseException)


def require_facts(message: object, *facts: object) -> None:
    """Fail unless the message is one line with each fact as a whole: mass is no fact of a message about v.mass."""
    text = str(message)
    assert "\n" not in text, text
    missing = [str(fact) for fact in facts if not re.search(rf"(?<![\w.-]){re.escape(str(fact))}(?!\w|[-./]\w)", text)]
    assert not missing, f"{', '.join(missing)} missing in: {text}"


@contextmanager
def raises(kind: type[E], *facts: object) -> Iterator[pytest.ExceptionInfo[E]]:
    """Fail unless the block raises an error of exactly this class with these facts in its message."""
    with pytest.raises(kind) as refusal:
        yield refusal
    assert refusal.type is kind, f"{refusal.type.__name__}, expected {kind.__name__}: {refusal.value}"
    require_facts(refusal.value, *facts)


@contextmanager
def warns(*facts: object) -> Iterator[None]:
    """Fail unless the block gives a warning to users with these facts; other warnings go on to the code around it."""
    with pytest.warns(UserWarning) as said:
        yield
    require_facts(" ".join(str(warning.message) for warning in said), *facts)

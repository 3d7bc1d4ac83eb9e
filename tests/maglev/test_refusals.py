"""What readers of parameters answer: a message that becomes another one is seen, and whether it became a better one."""

from pathlib import Path

from refusals import ANSWERS, answers


def test_answers_are_those_that_were_read_by_somebody(fmus: Path) -> None:
    assert [*answers(fmus)] == ANSWERS.read_text(encoding="utf-8").splitlines(), (
        "`python tests/support/refusals.py FMUS` writes them again: look at the difference")

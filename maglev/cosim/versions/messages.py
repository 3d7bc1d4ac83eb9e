"""What FMUs say through FMI's logger: kept with a bound, for an error and for a note after the run."""

import re
from collections import deque

from maglev.errors import in_one_line

MOST_MESSAGES = 20      # of an FMU that are kept
LONGEST_MESSAGE = 500   # characters of one of them

# How pythonfmu's binary reports an exception; its text is what a person wants to read.
PYTHON_EXCEPTION = re.compile(r"""^Fatal py exception encountered: \[\w+\] \w+ \w+\((["'])(.*)\1\)$""")


class Messages:
    """Messages of one FMU, whose status is not fmi2OK."""

    def __init__(self) -> None:
        self.latest: deque[str] = deque(maxlen=MOST_MESSAGES)   # since somebody asked
        self.counts: dict[str, int] = {}   # of the first different ones
        self.others = 0                    # messages beyond these
        self.warnings: dict[str, int] = {}   # calls that returned one, with their numbers

    def add(self, text: str) -> None:
        text = PYTHON_EXCEPTION.sub(r"\2", in_one_line(text))
        text = text if len(text) <= LONGEST_MESSAGE else text[:LONGEST_MESSAGE] + "…"
        self.latest.append(text)
        if text in self.counts or len(self.counts) < MOST_MESSAGES:
            self.counts[text] = self.counts.get(text, 0) + 1
        else:
            self.others += 1

    def warned(self, call: str, number: int = 1) -> None:
        self.warnings[call] = self.warnings.get(call, 0) + number

    def take(self) -> str:
        """The latest messages, which are not given again."""
        text = "; ".join(self.latest)
        self.latest.clear()
        return text

    def summary(self) -> str:
        """What was said since the beginning, each text once with its number; empty if nothing was.

        Of calls that returned a warning it is said only where no text came with it.
        """
        counts = self.counts or {f"a warning from {call}, without a text": number
                                 for call, number in self.warnings.items()}
        texts = [text if number == 1 else f"{text} ({number} times)" for text, number in counts.items()]
        return "; ".join([*texts, *([f"and {self.others} more messages"] if self.others else [])])

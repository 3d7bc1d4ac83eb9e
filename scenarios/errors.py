"""What every refusal of a scenario has in common; its wording is that of all packages."""

from messages.wording import in_one_line, nearest

__all__ = ["ScenarioError", "in_one_line", "nearest"]


class ScenarioError(ValueError):
    """A scenario that cannot be used; one line with file, key, value and what was expected."""

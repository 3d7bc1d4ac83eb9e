"""Links that open a run in the live page, from pages in the same folder: "fly this"."""

from collections.abc import Mapping
from pathlib import Path
from urllib.parse import quote

NAME = "live.html"


def has_live_page(page: Path) -> bool:
    """Whether the live page lies beside a page."""
    return page.with_name(NAME).is_file()


def live_address(run: str, settings: Mapping[str, float | bool] | None = None) -> str:
    """Address of a run by its name, with start values by `fmu.variable`, SI, whose bits stay the same."""
    values = {name: str(value).lower() if isinstance(value, bool) else repr(value)
              for name, value in (settings or {}).items()}
    return f"{NAME}#" + "&".join(f"{quote(key)}={quote(value)}" for key, value in {"run": run, **values}.items())

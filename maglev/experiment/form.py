"""Forms in which the columns of a run are written."""

from typing import Literal

Format = Literal["csv", "parquet"]

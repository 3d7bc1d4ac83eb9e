"""Write the pages of the stages in the folder `stages`: `python -m maglev.descriptions`, from the repository."""

from maglev.descriptions.description_file import PACKAGED, read_stage
from maglev.descriptions.writer import write

for path in sorted(PACKAGED.glob("*.toml")):
    write(read_stage(path), PACKAGED.parent)

"""Write the modules of the rigs in the folder `rigs`: `python -m maglev.descriptions`, from the repository."""

from maglev.descriptions.description_file import PACKAGED, read_rig
from maglev.descriptions.writer import write

for path in sorted(PACKAGED.glob("*.toml")):
    write(read_rig(path), PACKAGED.parent)

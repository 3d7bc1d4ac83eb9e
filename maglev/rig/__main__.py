"""Write the modules of the rigs in the folder `rigs`: `python -m maglev.rig`, from the repository."""

from maglev.rig.description import PACKAGED, read_rig
from maglev.rig.writer import write

for path in sorted(PACKAGED.glob("*.toml")):
    write(read_rig(path), PACKAGED.parent)

"""The packages of this project, and a check that Python finds no others under their names."""

from functools import cache
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

from maglev.files.errors import MaglevError

BLOCKS = ("pmlsm", "plant_fmu", "controller_fmu")   # packages of blocks and their parts
PACKAGES = (*BLOCKS, "maglev")                        # all packages of this project
# Packages whose modules FMUs carry. Others of `maglev` read files of the installation, and stay in it.
IN_FMUS = (*BLOCKS, "maglev.fmi", "maglev.closed_loop")

HERE = Path(__file__).resolve().parents[2]


@cache
def require_own_packages() -> None:
    """Import our packages, so that none which is found later takes their place; MaglevError if one does already.

    Their names go into FMUs as they are, and others who follow the layout of pythonfmu may have the same in a folder.
    """
    for name in PACKAGES:
        spec = find_spec(name)
        file = None if spec is None else spec.origin or next(iter(spec.submodule_search_locations or ()), None)
        if file is None or HERE not in Path(file).resolve().parents:
            raise MaglevError(f"import {name}: finds {file or 'nothing'}, expected the package of maglev-fmus in "
                              f"{HERE / name}: rename the other one, or run `maglev` or `python -P` instead of "
                              "`python -m maglev`")
        import_module(name)

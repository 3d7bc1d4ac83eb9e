"""The unit of all ratios: one C loop over controller and plant as they were when sines came from the C library.

It is frozen, so that blocks that become faster do not make everything around them look slower. The folder `reference`
has what pyccel made of the blocks of commit eb32d8e, and for each stage the loop that `c_loop.py` wrote over them.
"""

import ctypes
import lzma
import tempfile
from collections.abc import Callable
from pathlib import Path

from c_loop import timed_loop
from loops import Pair

from fmi_export.native.build import host_platform
from fmi_export.native.compiler import compiled

FROZEN = "frozen C loop"
FOLDER = Path(__file__).with_name("reference")
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fno-sanitize=all", "-g0", "-shared", "-fPIC",
         "-lm")   # as they were then, too


def reference_loop(pair: Pair, steps: int) -> Callable[[], float]:
    """Measurement of the time of one step of a pair's loop as it was, s; references are constant."""
    text = lzma.decompress((FOLDER / f"{pair.rig.name}.c.xz").read_bytes()).decode("utf-8")
    platform = next(iter(host_platform().values()))
    with tempfile.TemporaryDirectory() as folder:
        name = f"{pair.rig.name}{platform.ending}"
        (Path(folder) / "loop.c").write_text(text, encoding="utf-8")
        compiled(Path(folder), [*FLAGS, "-target", platform.targets[0], "-o", name, "loop.c"])
        library = ctypes.CDLL(str(Path(folder) / name))
    return timed_loop(library["run"], pair, steps, text.count("*record++"))

"""The unit of all ratios: one C loop over controller and plant as they were when sines came from the C library.

It is frozen, so that blocks that become faster do not make everything around them look slower. The folder `reference`
has what pyccel made of the blocks of commit eb32d8e, and for each stage a loop over them, which does what a
master does: references, measurements, controller, currents, plant, and a record of every output.
"""

import ctypes
import lzma
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import perf_counter

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
    run = library["run"]
    run.argtypes = [ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]
    record = (ctypes.c_double * (steps * text.count("*record++")))()
    given = (ctypes.c_double * len(pair.starts))(*pair.starts)

    def measure() -> float:
        begin = perf_counter()
        if run(steps, pair.dt, given, record) != 0:
            sys.exit("the C loop was refused a step")
        return (perf_counter() - begin) / steps

    return measure

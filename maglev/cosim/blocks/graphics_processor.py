"""A graphics processor of NVIDIA, and blocks on it.

They are compiled to PTX by the compiler of native FMUs. CuPy loads it: of it memory, copies, launches and operations on
arrays are used.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fmi_export.target.graphics import FLAGS, in_one_rounding, ptx
from maglev.errors import MaglevError, ScenarioError, extra, one_of, option
from maglev_files.cache import BLOCK_LOOPS, keep_here, kept, key_of

DEVICES = ("cpu", "gpu")
FILE = "kernel.ptx"
OLDEST = 80    # compute capability, in tenths, that the PTX is for
THREADS = 32   # of a block: with 64 a batch took 5 % longer on an H200


def require_device(device: str, scheduler: str | None = None) -> None:
    """MaglevError if it is none of them, is not there, or does not go with a scheduler of other machines."""
    if device not in DEVICES:
        raise ScenarioError(f"{option('device', device)}: expected {one_of(device, DEVICES)}")
    if device != "cpu" and scheduler is not None:
        raise ScenarioError(f"{option('device', device)}: expected no {option('scheduler')} with it, whose workers "
                            "have processors of their own")
    if device == "gpu":
        driver()


def driver() -> Any:
    """CuPy, with a graphics processor; MaglevError without one that can be used."""
    asked = option("device", "gpu")
    cupy = extra("cupy", "gpu", asked)
    try:
        cupy.cuda.runtime.getDeviceCount()
        capability = int(cupy.cuda.Device().compute_capability)
    except (cupy.cuda.runtime.CUDARuntimeError, ImportError) as error:
        raise MaglevError(f"{asked}: {error}, expected a graphics processor of NVIDIA with its driver, or "
                          f"{option('device', 'cpu')}") from error
    if capability < OLDEST:
        raise MaglevError(f"{asked}: the graphics processor has compute capability {capability / 10:.1f}, expected at "
                          f"least {OLDEST / 10:.1f}, or {option('device', 'cpu')}")
    return cupy


def kernels(cupy: Any, code: Mapping[str, str], *names: str) -> list[Any]:
    """Functions of C files by name, compiled now if they were not before; ExportError, or OSError if not kept."""
    files = in_one_rounding(code)
    place = key_of(BLOCK_LOOPS, sorted(files.items()), FLAGS)
    file = kept(place, FILE) or keep_here(place, FILE, ptx(files, names[0]))
    module = cupy.RawModule(path=str(file.path))
    return [module.get_function(name) for name in names]


def sent(cupy: Any, content: Any) -> Any:
    """Bytes, or a ctypes object, on the processor."""
    return cupy.asarray(np.frombuffer(bytes(content), np.uint8))


def launch(kernel: Any, count: int, given: Any) -> None:
    """Run a kernel in so many threads; it is done when an array of it is asked for."""
    kernel((-(-count // THREADS),), (THREADS,), (given,))

"""CuPy and a graphics processor as they are asked for, on this one: its threads run one after the other."""

from collections.abc import Mapping
from ctypes import CDLL, c_void_p
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fmi_export.native.build import host_platform
from fmi_export.native.compiler import library
from maglev.studies.flying import graphics_processor


class Memory:
    """Memory of the processor, at an address: numbers that `asnumpy` alone gives back."""

    def __init__(self, array: Any):
        self.array = np.array(array)
        self.data = SimpleNamespace(ptr=self.array.ctypes.data)

    def __dlpack_device__(self) -> tuple[int, int]:
        return 2, 0


class Cupy(SimpleNamespace):
    """What is used of CuPy; memory of so many bytes, of which `taken` are in use, unknown to who asks what is free."""

    def __init__(self, memory: float = 1e9, found: int = 1, capability: str = "90"):
        self.launches: list[Any] = []
        self.memory = memory
        self.taken = 0

        def count() -> int:
            if not found:
                raise RuntimeError("cudaErrorNoDevice: no CUDA-capable device is detected")
            return found

        runtime = SimpleNamespace(getDeviceCount=count, CUDARuntimeError=RuntimeError,
                                  memGetInfo=lambda: (int(self.memory), int(1e12)))
        self.cuda = SimpleNamespace(runtime=runtime, Device=lambda: SimpleNamespace(compute_capability=capability))

    def get_default_memory_pool(self) -> Any:
        return SimpleNamespace(free_all_blocks=lambda: None)

    def zeros(self, shape: tuple[int, ...], kind: Any) -> Memory:
        if self.taken:
            self.memory -= self.taken
            raise MemoryError("Out of memory allocating")
        return Memory(np.zeros(shape, kind))

    def asarray(self, array: Any) -> Memory:
        return Memory(array)

    def from_dlpack(self, array: Memory) -> Memory:
        return array

    def asnumpy(self, array: Memory) -> Any:
        return array.array.copy()

    def RawModule(self, path: str) -> Any:   # noqa: N802
        function = CDLL(path)[graphics_processor.FUNCTION]

        def launch(blocks: tuple[int], threads: tuple[int], arguments: tuple[Any]) -> None:
            self.launches.append((blocks, threads))
            function(c_void_p(arguments[0].data.ptr))

        return SimpleNamespace(get_function=lambda _: launch)


def stand_in(patch: pytest.MonkeyPatch, **options: Any) -> Cupy:
    """Put it into CuPy's place, and the compiler of this processor into that of PTX."""
    cupy = Cupy(**options)

    def compiled(sources: Mapping[str, str], name: str) -> bytes:
        platform, = host_platform().values()
        return library(sources, name, platform)

    patch.setattr(graphics_processor, "extra", lambda *_: cupy)
    patch.setattr(graphics_processor, "ptx", compiled)
    patch.setattr(graphics_processor, "FILE", "stand_in.so")   # what is kept is no PTX
    return cupy

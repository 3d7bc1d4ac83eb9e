"""CuPy and a graphics processor as they are asked for, on this one: its threads run one after the other."""

from collections.abc import Callable, Iterable, Mapping
from ctypes import CDLL, c_void_p
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fmi_export.native.build import host_platform
from fmi_export.native.compiler import library
from maglev.cosim.blocks import graphics_processor


class Memory(np.ndarray[Any, Any]):
    """Memory of the processor, at an address: arrays of this one and of that one do not go together unasked."""

    @property
    def data(self) -> Any:
        return SimpleNamespace(ptr=self.ctypes.data)

    def __array_ufunc__(self, function: Any, method: Any, *inputs: Any,   # type: ignore[override]
                        **options: Any) -> Any:
        require_there([*inputs, *options.get("out", ())])
        made = getattr(function, method)(*map(plain, inputs), **{
            name: tuple(map(plain, value)) if name == "out" else plain(value) for name, value in options.items()})
        return there(made)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        raise TypeError(f"numpy.{function.__name__} of an array of the graphics processor")

    def __setitem__(self, place: Any, value: Any) -> None:
        require_there([place, value])
        plain(self)[plain(place)] = plain(value)

    def __getitem__(self, place: Any) -> Any:
        require_there(place if isinstance(place, tuple) else [place])
        return there(plain(self)[tuple(map(plain, place)) if isinstance(place, tuple) else plain(place)])

    def __dlpack_device__(self) -> tuple[int, int]:   # type: ignore[override]
        return 2, 0


def plain(array: Any) -> Any:
    return array.view(np.ndarray) if isinstance(array, Memory) else array


def there(made: Any) -> Any:
    return np.asarray(made).view(Memory) if isinstance(made, np.ndarray | np.generic) else made


def require_there(given: Iterable[Any]) -> None:
    for one in given:
        if isinstance(one, np.ndarray) and not isinstance(one, Memory):
            raise TypeError("Unsupported type <class 'numpy.ndarray'>")


def taken_there(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of NumPy as CuPy has it."""
    def called(*arguments: Any, **options: Any) -> Any:
        require_there(arguments)
        made = function(*map(plain, arguments), **options)
        return [there(part) for part in made] if isinstance(made, list) else there(made)

    return called


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
        for function in (np.arange, np.clip, np.isfinite, np.split, np.where):
            setattr(self, function.__name__, taken_there(function))

    def get_default_memory_pool(self) -> Any:
        return SimpleNamespace(free_all_blocks=lambda: None)

    def zeros(self, shape: Any, kind: Any = np.float64) -> Any:
        if self.taken:
            self.memory -= self.taken
            raise MemoryError("Out of memory allocating")
        return there(np.zeros(shape, kind))

    def asarray(self, array: Any, kind: Any = None) -> Any:
        return array if isinstance(array, Memory) and kind in (None, array.dtype) else there(np.array(array, kind))

    def array(self, array: Any, kind: Any, ndmin: int) -> Any:
        return there(np.array(plain(array), kind, ndmin=ndmin))

    def from_dlpack(self, array: Memory) -> Memory:
        return array

    def asnumpy(self, array: Memory) -> Any:
        return np.array(plain(array))

    def RawModule(self, path: str) -> Any:   # noqa: N802
        module = CDLL(path)

        def function(name: str) -> Callable[..., None]:
            def launch(blocks: tuple[int], threads: tuple[int], arguments: tuple[Any]) -> None:
                self.launches.append((blocks, threads))
                module[name](c_void_p(arguments[0].data.ptr))

            return launch

        return SimpleNamespace(get_function=function)


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

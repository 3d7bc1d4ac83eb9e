"""Versions of FMI that native FMUs are made for: the C files over the block, the headers, the folders of binaries."""

from collections.abc import Mapping
from typing import NamedTuple

from fmi_export.native.compiler import MACOS, PLATFORMS, Platform

# The layer that is the same in all versions: each file knows those before it, and all know model.h and instance.h.
PARTS = ("messages", "state", "outputs", "variables", "exchange", "events", "life")
CORE = ("model.h", "instance.h", *(f"{part}.{ending}" for part in PARTS for ending in ("h", "c")))


class Shell(NamedTuple):
    """A version of FMI: `layer`, the C files of an FMU beside its block, headers that importers have, platforms."""

    version: str
    layer: tuple[str, ...]
    headers: tuple[str, ...]
    platforms: Mapping[str, Platform]


SHELLS = {
    2: Shell("2.0", (*CORE, "fmi2.c", "fmi2_exchange.c", "fmi2_absent.c"),
             ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
             {"linux64": PLATFORMS["x86_64-linux"], "win64": PLATFORMS["x86_64-windows"], "darwin64": MACOS,
              # FMI 2.0 has no name for it and allows others (2.3).
              "aarch64-linux": PLATFORMS["aarch64-linux"]}),
    3: Shell("3.0", (*CORE, "fmi3.c", "fmi3_events.c", "fmi3_exchange.c", "fmi3_absent.c"),
             ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
             PLATFORMS),
}

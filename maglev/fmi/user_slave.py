"""The slave of a user's class, which may raise, and may hold anything."""

import sys
from copy import deepcopy
from math import isfinite
from numbers import Real
from operator import attrgetter
from pathlib import Path
from typing import Any

from maglev.fmi.definition import FmuDefinition, Slot
from maglev.fmi.plain_state import NotPlain, read_state, written_state
from maglev.fmi.slave import BlockSlave, Refused
from maglev.fmi.trouble import RAISED, error_text


class WrittenSlave(BlockSlave):
    """Executes a block of `user_block`; an exception of the user's class becomes an error that names its place."""

    raised = RAISED

    def __init__(self, definition: FmuDefinition, **kwargs: Any):
        super().__init__(definition, **kwargs)
        self.written = type(self.block.law)
        self.finite = [(status, attrgetter(place)) for status, place in definition.finite]

    def slots(self) -> list[Slot]:
        return []   # the state is copied as it is

    def checked(self) -> int:
        """Return the status of the first output that is no finite number."""
        for status, port in self.finite:
            value: Any = port(self.block)
            if not (isinstance(value, (float, Real)) and isfinite(value)):
                return status
        return 0

    def failed(self, error: BaseException, time: float | None = None) -> Refused:
        """Refusal with the line of the class that failed."""
        what = "start failed" if time is None else f"step failed at t = {time} s"
        return self.refused(f"{what}: {error_text(error, self.written)}")

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        """Return True for Booleans, those of other packages too, and for 0 and 1."""
        values = super().get_boolean(vrs)
        for vr, value in zip(vrs, values, strict=True):
            if getattr(value, "shape", ()) != () or value not in (False, True):
                raise self.refused(f"{self.variables[vr].name} = {value!r}, expected True or False from "
                                   f"{self.written.__name__}")
        return [bool(value) for value in values]

    def _get_fmu_state(self) -> dict[str, Any]:
        try:
            return super()._get_fmu_state() | {"block": deepcopy((vars(self.block.law), vars(self.block.clock)))}
        except Exception as error:
            raise self.refused(f"the state cannot be saved: {error_text(error, self.written)}") from error

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        saved = state.get("block")
        if isinstance(saved, tuple):
            saved = deepcopy(saved)
        else:   # it was serialized
            try:
                saved = read_state(saved, self.folder())
                for part, values in zip((self.block.law, self.block.clock), saved, strict=True):
                    if not isinstance(values, dict) or not all(isinstance(name, str) for name in values):
                        raise NotPlain(f"the attributes of a {type(part).__name__} are {values!r}")
            except ValueError as error:
                raise self.refused(f"serialized state: {error}, expected one that this FMU has written") from error
        super()._set_fmu_state(state | {"block": []})
        for part, values in zip((self.block.law, self.block.clock), saved, strict=True):
            vars(part).clear()
            vars(part).update(values)

    def folder(self) -> Path | None:
        """Folder of the user's files, whose classes a state may hold objects of."""
        file = getattr(sys.modules.get(self.written.__module__), "__file__", None)
        return None if file is None else Path(file).parent

    @staticmethod
    def _fmu_state_to_bytes(state: dict[str, Any]) -> bytes:
        return BlockSlave._fmu_state_to_bytes(state | {"block": written_state(state["block"], "vars(self)")})

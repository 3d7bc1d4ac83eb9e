"""Reads a block: follows the calls from its methods, and reads each function for the types of its arguments."""

import ast
import inspect
from collections.abc import Callable, Collection, Sequence
from typing import Any

from maglev.language.layout import Layout
from maglev.language.names import identifier
from maglev.language.program import Function, Site, Struct, Type, Untranslatable
from maglev.language.texts import definition_of, shown_file


class Reader:
    """A block as a typed program, from an instance of it.

    The instance is only read. Parameters
    ----------
    block : object
        Whose attributes are as its constructor has left them.
    careful : collection of str
        Packages whose code checks values before it divides or takes a root: their results are not checked again.
    reserved : collection of str
        Names that no struct and no function may have.
    prefix : str
        Begins the names of the structs.
    """

    def __init__(self, block: Any, careful: Collection[str] = (), reserved: Collection[str] = (), prefix: str = ""):
        self.careful = frozenset(careful)
        self.taken = set(reserved)
        self.layout = Layout(block, lambda name: self.free_name(prefix + identifier(name)))
        self.functions: dict[tuple[Any, ...], Function] = {}
        self.reading: list[Function] = []   # from the first call to the innermost
        self.sites: list[Site] = []

    def free_name(self, name: str) -> str:
        """The name, with a number or an underscore behind it if it is taken."""
        free, number = name, 1
        while free in self.taken:
            number += 1
            free = f"{name}_{number}"
        self.taken.add(free)
        return free

    def method(self, name: str, arguments: Sequence[Type] = (), place: str = "") -> Function:
        """The program of a method of the block, or of its part at a place such as "law", called with numbers.

        Untranslatable if there is no such method, or it is not in the language of blocks.
        """
        owner: Type = self.layout.root
        for part in place.split(".") if place else []:
            owner = self.layout.fields[owner.name][part]   # type: ignore[union-attr]
        assert isinstance(owner, Struct)
        return self.function(self.method_of(owner, name), [owner, *arguments], owner)

    def method_of(self, owner: Struct, name: str) -> Callable[..., Any]:
        """The function that a class has by a name; AttributeError if it has no plain method of it."""
        found = inspect.getattr_static(self.layout.classes[owner.name], name)
        if isinstance(found, staticmethod):
            raise AttributeError(name)
        if not inspect.isfunction(found):
            raise AttributeError(name)
        return found

    def site(self, file: str, line: int, text: str) -> Site:
        """A place that can fail."""
        self.sites.append(Site(len(self.sites) + 1, f"{file}, line {line}: {text}"))
        return self.sites[-1]

    def read_body(self, function: Function, node: ast.FunctionDef) -> None:
        """Fill in the body of a function; `Program` does it."""
        raise NotImplementedError

    def function(self, source: Callable[..., Any], types: Sequence[Type], owner: Struct | None) -> Function:
        """Return the program of a function for the types of its arguments; the first one of a method is `owner`."""
        key = (source, tuple(types))
        if key in self.functions:
            function = self.functions[key]
            if function in self.reading:
                raise Untranslatable(f"{function.file}, line {function.line}: {source.__name__} calls itself: "
                                     "expected a loop")
            return function
        node = definition_of(source)
        base = owner.name if owner is not None else identifier(source.__module__.rpartition(".")[2])
        names, given = [each.arg for each in node.args.args], node.args
        place = f"{shown_file(source)}, line {node.lineno}"
        if given.vararg or given.kwarg or given.kwonlyargs or given.posonlyargs:
            raise Untranslatable(f"{place}: {node.name} with * or /: expected every parameter by itself")
        if len(names) != len(types):
            raise Untranslatable(f"{place}: {node.name}({', '.join(names)}) is called with {len(types)} values: "
                                 "expected as many parameters")
        function = Function(self.free_name(f"{base}__{identifier(source.__name__)}"), source, shown_file(source),
                            node.lineno, list(zip(names, types, strict=True)))
        self.functions[key] = function
        self.reading.append(function)
        self.read_body(function, node)
        function.fails = bool(function.sites) or any(called.fails for called in function.calls)
        self.reading.pop()
        return function

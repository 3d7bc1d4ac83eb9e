"""A typed program as C for several blocks at once: values that differ become vectors, all others stay scalars.

Which attributes differ is found from those that are known to: whatever is computed from them, or assigned in some
lanes only. A function is printed for each set of arguments that differ, and once more for calls in some lanes only.
Every operation of a lane is that of the C of a single block, so that a lane has its bits.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from maglev.language.c_text import constant_text, declared, filled
from maglev.language.clone import Clone
from maglev.language.helpers import HELPERS
from maglev.language.lane_expressions import VECTORS
from maglev.language.lane_statements import LaneStatements
from maglev.language.lanes_helpers import BITS, FAILING, SURE, TOGETHER, TYPES, lane_helper
from maglev.language.layout import Layout
from maglev.language.names import identifier
from maglev.language.program import ConstList, Function, List, Struct, Type, ends, functions_of

Attribute = tuple[str, str]   # name of a struct, and of a member of it


class LanesText:
    """The C of methods for several lanes at once; `varying` are attributes that differ between lanes at the beginning.

    Names begin with `prefix`. Names of structs are those of the layout behind it.
    """

    def __init__(self, layout: Layout, roots: Sequence[Function], varying: Iterable[Attribute], width: int,
                 prefix: str = "lanes_"):
        self.layout, self.width, self.prefix = layout, width, prefix
        self.varying = set(varying)
        self.clones: dict[tuple[Function, tuple[bool, ...], bool], Clone] = {}
        self.kept_names: dict[str, int] = {}
        again = True
        while again:
            self.changed = False
            self.printed: dict[int, str] = {}
            self.helpers: set[str] = set()          # of lanes
            self.scalar_helpers: set[str] = set()   # of one number
            self.lists: dict[str, tuple[ConstList, bool, str]] = {}
            self.roots = [self.clone(root, (False,) * len(root.parameters), False) for root in roots]
            again = self.changed or any(clone.changed for clone in self.clones.values())
            for clone in self.clones.values():
                clone.changed = False

    def clone(self, function: Function, varying: tuple[bool, ...], masked: bool) -> Clone:
        """A function for arguments that differ, which is printed after those that it calls."""
        key = (function, varying, masked)
        if key not in self.clones:
            number = self.kept_names[function.name] = self.kept_names.get(function.name, 0) + 1
            self.clones[key] = Clone(function, varying, masked, f"{self.prefix}{function.name}__{number}")
        clone = self.clones[key]
        if id(clone) not in self.printed:
            text = LaneStatements(self, clone).text()
            self.printed[id(clone)] = text
        return clone

    def lists_needed(self, function: Function, varying: Sequence[bool]) -> list[bool]:
        """Return which lists a function makes differ between lanes, as far as that is known."""
        return [any(clone.needed[k] for (own, *_), clone in self.clones.items() if own is function)
                for k, _ in enumerate(varying)]

    def harmless(self, function: Function) -> bool:
        """Return True if a function may be called in lanes that are masked out."""
        return not function.writes and not function.fails and ends(functions_of([function]))

    # Attributes

    def is_varying(self, owner: Type, name: str) -> bool:
        return (owner.name, name) in self.varying   # type: ignore[union-attr]

    def make_vary(self, owner: Type, name: str) -> None:
        attribute = (owner.name, name)   # type: ignore[union-attr]
        self.changed |= attribute not in self.varying
        self.varying.add(attribute)

    # Texts

    def takes_room(self, kind: Type) -> bool:
        return filled(kind)

    def struct_name(self, kind: Struct) -> str:
        return self.prefix + kind.name

    def declared(self, kind: Type, name: str, varies: bool) -> str:
        """Declaration of a member or a variable."""
        if isinstance(kind, List):
            assert kind.item is not None
            return self.declared(kind.item, f"{name}[{kind.length}]", varies)
        if isinstance(kind, Struct):
            return f"struct {self.struct_name(kind)} {name}"
        return f"{VECTORS[kind]} {name}" if varies else declared(kind, name)

    def list_name(self, constant: ConstList, varies: bool) -> str:
        text = f"{constant.type}{constant.values!r}{varies}"
        if text not in self.lists:
            self.lists[text] = constant, varies, f"{self.prefix}{identifier(constant.name)}__{len(self.lists) + 1}"
        return self.lists[text][2]

    def structs(self) -> str:
        texts = []
        for name, fields in self.layout.fields.items():
            members = [f"    {self.declared(kind, identifier(part), (name, part) in self.varying)};\n"
                       for part, kind in fields.items() if filled(kind)]
            texts.append(f"struct {self.prefix}{name} {{\n{''.join(members) or '    char nothing;' + chr(10)}}};\n")
        return "\n".join(texts)

    def constants(self) -> str:
        texts = []
        for constant, varies, name in self.lists.values():
            values = self.in_lanes(constant.values) if varies else constant_text(constant.values)
            texts.append(f"static const {self.declared(constant.type, name, varies)} = {values};\n")
        return "".join(texts)

    def in_lanes(self, values: Sequence[Any]) -> str:
        """C of numbers of a constant list, as vectors."""
        return "{" + ", ".join(self.in_lanes(each) if isinstance(each, tuple) else constant_text(
            (-int(each) if isinstance(each, bool) else each,) * self.width) for each in values) + "}"

    def functions_text(self) -> str:
        return "\n".join([self.constants(), *self.printed.values()])

    # The blocks that lanes begin with

    def load(self, place: str, block: str, kind: Type | None = None, depth: int = 1, name: str = "",
             varies: bool = False) -> list[str]:
        """C that puts a block into a lane; it sets `same` to false if the values that lanes have in common differ.

        `lane` is its number; lane 0 sets the values that all have in common.
        """
        kind = kind or self.layout.root
        pad = "    " * depth
        if isinstance(kind, Struct):
            return [line for part, inner in self.layout.fields[kind.name].items() if filled(inner)
                    for line in self.load(f"{place}.{identifier(part)}", f"{block}.{identifier(part)}", inner, depth,
                                          part, (kind.name, part) in self.varying)]
        if isinstance(kind, List):
            assert kind.item is not None
            k = f"k{depth}"
            return [f"{pad}for (int {k} = 0; {k} < {kind.length}; ++{k}) {{",
                    *self.load(f"{place}[{k}]", f"{block}[{k}]", kind.item, depth + 1, name, varies), f"{pad}}}"]
        value = f"-(int64_t){block}" if kind.name == "bool" else block
        if varies:
            return [f"{pad}{place}[lane] = {value};"]
        return [f"{pad}if (lane == 0) {place} = {block};",
                f"{pad}same = same && __builtin_memcmp(&{place}, &{block}, sizeof {block}) == 0;"]

    def copied(self, place: str, kind: Type | None = None, depth: int = 1, varies: bool = False) -> list[str]:
        """C that copies lane `from` to lane `to`."""
        kind = kind or self.layout.root
        pad = "    " * depth
        if isinstance(kind, Struct):
            return [line for part, inner in self.layout.fields[kind.name].items() if filled(inner)
                    for line in self.copied(f"{place}.{identifier(part)}", inner, depth,
                                            (kind.name, part) in self.varying)]
        if isinstance(kind, List):
            assert kind.item is not None
            lines = self.copied(f"{place}[k{depth}]", kind.item, depth + 1, varies)
            return [f"{pad}for (int k{depth} = 0; k{depth} < {kind.length}; ++k{depth}) {{", *lines,
                    f"{pad}}}"] if lines else []
        return [f"{pad}{place}[to] = {place}[from];"] if varies else []


def helper_text(texts: Iterable[LanesText]) -> str:
    """C that must precede the functions of programs of lanes; LANES is defined, and <math.h> included."""
    lanes = {name for text in texts for name in text.helpers}
    single = {name for text in texts for name in text.scalar_helpers}
    for name in list(lanes):
        base = name.removeprefix("common_")
        if base in FAILING or base in SURE:
            single.add(base)
    if any("note_failure(" in HELPERS[name] for name in single):
        single.add("note_failure")
    if "whole" in lanes:
        lanes.add("trunc")
    ordered = sorted(lanes, key=lambda name: (name in TOGETHER, name))
    return "\n".join([TYPES, BITS, *(text for name, text in HELPERS.items() if name in single),
                      *map(lane_helper, ordered)])


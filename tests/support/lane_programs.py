"""C programs that step blocks one by one and in lanes, and print the states of both."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from random import Random
from typing import Any

from maglev.language.c_text import CText
from maglev.language.lanes import LanesText, helper_text
from maglev.language.layout import Layout
from maglev.language.names import identifier
from maglev.language.program import BOOL, FLOAT, List, Struct, Type
from maglev.language.statements import Program

HEAD = """\
#include <inttypes.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static void show_float(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    if (isnan(x)) printf("nan "); else printf("%016" PRIx64 " ", bits);
}

static void show_whole(int64_t x) { printf("%" PRId64 " ", x); }

"""

RUN = """\
static void run_{n}(void)
{{
    const struct {root} *const all[] = {{{initial}}};
    static struct lanes{n}_{root} lanes;
    for (int b = 0; b < {count}; ++b) {{
        struct {root} block = *all[b];
        printf("program {n} block %d\\n", b);
        for (int k = 0; k < {steps}; ++k) {{
            int64_t failure = 0;
            {alone};
            if (failure != 0) {{ printf("refused\\n"); break; }}
            {show_alone}
            printf("\\n");
        }}
    }}
    for (int first = 0; first < {count}; first += LANES) {{
        bool same = true, refused[LANES] = {{false}};
        for (int lane = 0; lane < LANES; ++lane) {{
            const int b = first + lane < {count} ? first + lane : first;
            {load}
        }}
        if (!same) printf("program {n} lanes are unlike\\n");
        for (int k = 0; k < {steps}; ++k) {{
            lanes_int failure = {{0}};
            {together};
            (void)failure;
            for (int lane = 0; lane < LANES && first + lane < {count}; ++lane) {{
                if (refused[lane]) continue;
                printf("program {n} lane %d\\n", first + lane);
                refused[lane] = failure[lane] != 0;
                if (refused[lane]) {{ printf("refused\\n"); continue; }}
                {show_lane}
                printf("\\n");
            }}
        }}
    }}
}}
"""


def vary(block: Any, random: Random, attributes: set[str], lane: int) -> None:
    """Give attributes of a block, and of its parts, other values, which depend on the lane."""
    for name, part in vars(block).items():
        for each in part if isinstance(part, list) else [part]:
            if hasattr(each, "__dict__"):
                vary(each, random, attributes, lane)
        if name not in attributes:
            continue
        if isinstance(part, bool):
            setattr(block, name, random.random() < 0.5)
        elif isinstance(part, float):
            setattr(block, name, part + random.choice((0.0, 0.5, -1.0, 3.0e10)) * lane)
        elif isinstance(part, int):
            setattr(block, name, part + random.choice((0, 1, -2)) * lane)
        elif isinstance(part, list) and part and isinstance(part[0], float):
            part[:] = [each + random.choice((0.0, 1.0, -0.25)) * lane for each in part]


def shows(layout: Layout, kind: Type | None, place: str, lanes: LanesText | None, varies: bool = False
          ) -> Iterator[str]:
    """C that prints the numbers at a place, those of `lane` where they vary."""
    if isinstance(kind, Struct):
        for name, part in layout.fields[kind.name].items():
            yield from shows(layout, part, f"{place}.{identifier(name)}", lanes,
                             lanes is not None and (kind.name, name) in lanes.varying)
    elif isinstance(kind, List):
        for k in range(kind.length):
            yield from shows(layout, kind.item, f"{place}[{k}]", lanes, varies)
    else:
        sign = "-" if varies and kind == BOOL else ""
        yield f"show_{'float' if kind == FLOAT else 'whole'}({sign}{place}{'[lane]' if varies else ''});"


def differing(layout: Layout, blocks: Sequence[Any]) -> set[tuple[str, str]]:
    """Attributes in which blocks differ."""
    found = set[tuple[str, str]]()

    def differs(kind: Type | None, values: list[Any]) -> bool:
        if isinstance(kind, Struct):
            found.update((kind.name, name) for name, part in layout.fields[kind.name].items()
                         if differs(part, [value[name] for value in values]))
            return False
        if isinstance(kind, List):   # a list of objects differs in attributes of these
            return True in {differs(kind.item, [value[k] for value in values]) for k in range(kind.length)}
        return any(repr(value) != repr(values[0]) for value in values)

    differs(layout.root, [layout.value_of(block, layout.root) for block in blocks])
    return found


@dataclass
class LaneProgram:
    """Blocks of one class with `step(t)`, one by one and in lanes."""

    number: int
    blocks: Sequence[Any]
    steps: int
    width: int

    def __post_init__(self) -> None:
        program = Program(self.blocks[0], prefix=f"B{self.number}_")
        step = program.method("step", (FLOAT,))
        layout, n = program.layout, self.number
        self.alone = CText(layout, [step])
        self.lanes = LanesText(layout, [step], differing(layout, self.blocks), self.width, f"lanes{n}_")
        self.lanes.scalar_helpers |= self.alone.helpers
        failing = ", &failure" if step.fails else ""
        self.text = "\n".join([
            self.alone.structs(), self.alone.constants(), self.alone.code,
            *("static " + self.alone.initial(block, f"INITIAL_{n}_{k}") for k, block in enumerate(self.blocks)),
            self.lanes.structs(), self.lanes.functions_text(),
            RUN.format(n=n, root=layout.root.name, count=len(self.blocks), steps=self.steps,
                       initial=", ".join(f"&INITIAL_{n}_{k}" for k in range(len(self.blocks))),
                       alone=f"{step.name}(&block, 0.125 * k{failing})", show_alone="\n".join(shows(
                           layout, layout.root, "block", None)),
                       together=f"{self.lanes.roots[0].name}(&lanes, 0.125 * k{failing})",
                       load="\n".join(self.lanes.load("lanes", "(*all[b])")),
                       show_lane="\n".join(shows(layout, layout.root, "lanes", self.lanes)))])


def c_program(programs: Sequence[LaneProgram]) -> str:
    """C that runs programs, all of one width."""
    return "\n".join([f"#define LANES {programs[0].width}", HEAD, helper_text([each.lanes for each in programs]),
                      *(each.text for each in programs),
                      "int main(void)\n{", *(f"    run_{each.number}();" for each in programs), "    return 0;\n}\n"])


def states(printed: str) -> dict[str, list[str]]:
    """Lines that a program prints, by the block or lane that they are of."""
    found: dict[str, list[str]] = {}
    for part in printed.split("program ")[1:]:
        head, *lines = part.splitlines()
        found.setdefault(head, []).extend(line.strip() for line in lines)
    return found

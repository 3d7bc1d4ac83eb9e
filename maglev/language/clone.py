"""A function of a block for arguments of which some differ between lanes."""


from maglev.language.program import Function, Scalar


class Clone:
    """A function for arguments some of which differ between lanes, called in all lanes or, `masked`, in some."""

    def __init__(self, function: Function, varying: tuple[bool, ...], masked: bool, name: str):
        self.function, self.varying, self.masked, self.name = function, varying, masked, name
        self.changed = False
        self.partial = False      # true if lanes return while others continue
        self.results_vary = [False] * len(function.results)
        self.differing: dict[str, bool] = {}     # names, of objects and lists those that stand for several
        self.elements: dict[str, bool] = {}      # names of lists, whose numbers differ
        self.left: set[int] = set()              # loops that lanes leave one by one
        self.needed = [False] * len(varying)     # lists that it makes differ
        for (parameter, kind), varies in zip(function.parameters, varying, strict=True):
            (self.differing if isinstance(kind, Scalar) else self.elements)[parameter] = varies

    def varies(self, name: str) -> bool:
        return self.differing.get(name, False)

    def make_vary(self, name: str) -> None:
        self.changed |= not self.varies(name)
        self.differing[name] = True

    def elements_vary(self, name: str) -> bool:
        return self.elements.get(name, False)

    def make_elements_vary(self, name: str) -> None:
        self.changed |= not self.elements_vary(name)
        self.elements[name] = True
        for k, (parameter, _) in enumerate(self.function.parameters):
            if parameter == name and not self.varying[k]:
                self.needed[k] = True

    def make_result_vary(self, number: int) -> None:
        self.changed |= not self.results_vary[number]
        self.results_vary[number] = True

    def make_partial(self) -> None:
        self.changed |= not self.partial
        self.partial = True

    def leaves(self, loop: int) -> bool:
        return loop in self.left

    def note_leaving(self, loop: int) -> None:
        self.changed |= loop not in self.left
        self.left.add(loop)

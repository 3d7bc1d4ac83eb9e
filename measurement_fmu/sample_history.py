"""The last samples of a signal: a ring of 128, of eights of scalars, for blocks have no lists."""

SLOTS = 128


class EightSamples:
    """Eight samples by number, 0 to 7."""

    def __init__(self) -> None:
        self.s0 = 0.0   # m, state
        self.s1 = 0.0   # m, state
        self.s2 = 0.0   # m, state
        self.s3 = 0.0   # m, state
        self.s4 = 0.0   # m, state
        self.s5 = 0.0   # m, state
        self.s6 = 0.0   # m, state
        self.s7 = 0.0   # m, state

    def put(self, number: int, value: float) -> None:
        """Keep a sample (m)."""
        if number == 0:
            self.s0 = value
        elif number == 1:
            self.s1 = value
        elif number == 2:
            self.s2 = value
        elif number == 3:
            self.s3 = value
        elif number == 4:
            self.s4 = value
        elif number == 5:
            self.s5 = value
        elif number == 6:
            self.s6 = value
        else:
            self.s7 = value

    def get(self, number: int) -> float:
        """A sample (m)."""
        if number == 0:
            return self.s0
        if number == 1:
            return self.s1
        if number == 2:
            return self.s2
        if number == 3:
            return self.s3
        if number == 4:
            return self.s4
        if number == 5:
            return self.s5
        if number == 6:
            return self.s6
        return self.s7


class SampleHistory:
    """The last 128 samples by slot, 0 to 127."""

    def __init__(self) -> None:
        self.part0 = EightSamples()
        self.part1 = EightSamples()
        self.part2 = EightSamples()
        self.part3 = EightSamples()
        self.part4 = EightSamples()
        self.part5 = EightSamples()
        self.part6 = EightSamples()
        self.part7 = EightSamples()
        self.part8 = EightSamples()
        self.part9 = EightSamples()
        self.part10 = EightSamples()
        self.part11 = EightSamples()
        self.part12 = EightSamples()
        self.part13 = EightSamples()
        self.part14 = EightSamples()
        self.part15 = EightSamples()

    def put(self, slot: int, value: float) -> None:
        """Keep a sample (m) in a slot."""
        part = slot >> 3
        number = slot & 7
        if part == 0:
            self.part0.put(number, value)
        elif part == 1:
            self.part1.put(number, value)
        elif part == 2:
            self.part2.put(number, value)
        elif part == 3:
            self.part3.put(number, value)
        elif part == 4:
            self.part4.put(number, value)
        elif part == 5:
            self.part5.put(number, value)
        elif part == 6:
            self.part6.put(number, value)
        elif part == 7:
            self.part7.put(number, value)
        elif part == 8:
            self.part8.put(number, value)
        elif part == 9:
            self.part9.put(number, value)
        elif part == 10:
            self.part10.put(number, value)
        elif part == 11:
            self.part11.put(number, value)
        elif part == 12:
            self.part12.put(number, value)
        elif part == 13:
            self.part13.put(number, value)
        elif part == 14:
            self.part14.put(number, value)
        else:
            self.part15.put(number, value)

    def get(self, slot: int) -> float:
        """The sample (m) in a slot."""
        part = slot >> 3
        number = slot & 7
        if part == 0:
            return self.part0.get(number)
        if part == 1:
            return self.part1.get(number)
        if part == 2:
            return self.part2.get(number)
        if part == 3:
            return self.part3.get(number)
        if part == 4:
            return self.part4.get(number)
        if part == 5:
            return self.part5.get(number)
        if part == 6:
            return self.part6.get(number)
        if part == 7:
            return self.part7.get(number)
        if part == 8:
            return self.part8.get(number)
        if part == 9:
            return self.part9.get(number)
        if part == 10:
            return self.part10.get(number)
        if part == 11:
            return self.part11.get(number)
        if part == 12:
            return self.part12.get(number)
        if part == 13:
            return self.part13.get(number)
        if part == 14:
            return self.part14.get(number)
        return self.part15.get(number)

    def fill(self, value: float) -> None:
        """Begin at rest at a value (m)."""
        for slot in range(SLOTS):
            self.put(slot, value)

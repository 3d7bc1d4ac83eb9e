"""The last samples of a signal: a ring of 128, fours within fours within eight, for blocks have no lists."""

SLOTS = 128


class FourSamples:
    """Four samples, 0 to 3."""

    def __init__(self) -> None:
        self.s0 = 0.0   # m, state
        self.s1 = 0.0   # m, state
        self.s2 = 0.0   # m, state
        self.s3 = 0.0   # m, state

    def put(self, number: int, value: float) -> None:
        """Keep a sample (m)."""
        if number == 0:
            self.s0 = value
        elif number == 1:
            self.s1 = value
        elif number == 2:
            self.s2 = value
        else:
            self.s3 = value

    def get(self, number: int) -> float:
        """A sample (m)."""
        if number == 0:
            return self.s0
        if number == 1:
            return self.s1
        if number == 2:
            return self.s2
        return self.s3


class SixteenSamples:
    """Sixteen samples by slot, 0 to 15."""

    def __init__(self) -> None:
        self.part0 = FourSamples()
        self.part1 = FourSamples()
        self.part2 = FourSamples()
        self.part3 = FourSamples()

    def put(self, slot: int, value: float) -> None:
        """Keep a sample (m) in a slot."""
        part = slot >> 2
        number = slot & 3
        if part == 0:
            self.part0.put(number, value)
        elif part == 1:
            self.part1.put(number, value)
        elif part == 2:
            self.part2.put(number, value)
        else:
            self.part3.put(number, value)

    def get(self, slot: int) -> float:
        """The sample (m) in a slot."""
        part = slot >> 2
        number = slot & 3
        if part == 0:
            return self.part0.get(number)
        if part == 1:
            return self.part1.get(number)
        if part == 2:
            return self.part2.get(number)
        return self.part3.get(number)


class SampleHistory:
    """The last 128 samples by slot, 0 to 127."""

    def __init__(self) -> None:
        self.part0 = SixteenSamples()
        self.part1 = SixteenSamples()
        self.part2 = SixteenSamples()
        self.part3 = SixteenSamples()
        self.part4 = SixteenSamples()
        self.part5 = SixteenSamples()
        self.part6 = SixteenSamples()
        self.part7 = SixteenSamples()

    def put(self, slot: int, value: float) -> None:
        """Keep a sample (m) in a slot."""
        part = slot >> 4
        number = slot & 15
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
        else:
            self.part7.put(number, value)

    def get(self, slot: int) -> float:
        """The sample (m) in a slot."""
        part = slot >> 4
        number = slot & 15
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
        return self.part7.get(number)

    def fill(self, value: float) -> None:
        """Begin at rest at a value (m)."""
        for slot in range(SLOTS):
            self.put(slot, value)

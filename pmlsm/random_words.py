"""Random words by Philox2x32-10: the same bits in Python and in C, on every machine.

Salmon, Moraes, Dror and Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC11, doi 10.1145/2063384.2063405. The
generator has no state: sample, stream and seed give the words, so that a run that is restored continues as it did.
"""

WORD_MASK = 0xFFFFFFFF     # of 32 bits
HALF_MASK = 0xFFFF         # of 16 bits
MULTIPLIER_HIGH = 0xD256   # 0xD256D193 in halves: with these no product comes to 2^49, and C's integers hold them all
MULTIPLIER_LOW = 0xD193
KEY_STEP = 0x9E3779B9
ROUNDS = 10

SHARE = 1.0 / 4294967296.0   # of all words, that one is


def random_words(seed: int, stream: int, number: int) -> tuple[int, int]:
    """Two random words of 32 bits, by seed, stream and number of the sample, of 32 bits each."""
    key = seed
    left = number & WORD_MASK
    right = stream
    for _ in range(ROUNDS):
        low = left * MULTIPLIER_LOW
        high = left * MULTIPLIER_HIGH + (low >> 16)
        left = (high >> 16) ^ key ^ right
        right = ((high & HALF_MASK) << 16) | (low & HALF_MASK)
        key = (key + KEY_STEP) & WORD_MASK
    return left, right

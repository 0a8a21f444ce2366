"""Model of the random source: parallel Trivium generators, each with 64 bits per step.

Trivium (De Canniere and Preneel, 2005) is a stream cipher of 288 bits of state whose 64 output bits
per cycle cost a few gates each. Its state update is invertible and the loaded state is never zero,
so the generator cannot get stuck.
"""

from __future__ import annotations

from pathgene.hdl.protocol.random_words import LANES, SEED_BITS, WARM_UP_STEPS, WORD_BITS


__all__ = ["RandomSource", "Trivium", "check_seed"]

_WORD = (1 << WORD_BITS) - 1
_A, _B, _C = 93, 84, 111


def check_seed(seed: int) -> None:
    """Raise an error unless ``seed`` is a valid seed of the chip.

    Raises
    ------
    ValueError
        If ``seed`` is not from 0 to 2**64 - 1.
    """
    if not 0 <= seed < 1 << SEED_BITS:
        raise ValueError(f"Seed must be from 0 to 2**{SEED_BITS} - 1, not {seed!r}")


class Trivium:
    """One generator.

    Bit ``i - 1`` of a register is the cipher's ``s_i``, counted from the register's first, so new
    bits enter at bit 0. The first of the 64 output bits of a step is the highest of the word.

    Parameters
    ----------
    key, iv : int
        80 bits each; bit ``i - 1`` goes to ``s_i`` and ``s_(93 + i)``.
    """

    def __init__(self, key: int, iv: int) -> None:
        self._a = key & ((1 << 80) - 1)
        self._b = iv & ((1 << 80) - 1)
        self._c = 0b111 << (_C - 3)
        for _ in range(WARM_UP_STEPS):
            self.step()

    @property
    def state(self) -> tuple[int, int, int]:
        """The three registers, of 93, 84 and 111 bits."""
        return self._a, self._b, self._c

    def step(self) -> int:
        """Advance by 64 bits and return them."""
        a, b, c = self._a, self._b, self._c
        t1 = (a >> 2) ^ (a >> 29)
        t2 = (b >> 5) ^ (b >> 20)
        t3 = (c >> 2) ^ (c >> 47)
        word = (t1 ^ t2 ^ t3) & _WORD
        self._b = (b << 64 | (t1 ^ (a >> 27) & (a >> 28) ^ (b >> 14)) & _WORD) & ((1 << _B) - 1)
        self._c = (c << 64 | (t2 ^ (b >> 18) & (b >> 19) ^ (c >> 23)) & _WORD) & ((1 << _C) - 1)
        self._a = (a << 64 | (t3 ^ (c >> 45) & (c >> 46) ^ (a >> 5)) & _WORD) & ((1 << _A) - 1)
        return word


class RandomSource:
    """All lanes of the chip. Lane ``i`` has the seed as its key and ``i`` as its IV.

    Parameters
    ----------
    seed : int
        0..2**64 - 1.
    """

    def __init__(self, seed: int) -> None:
        check_seed(seed)
        self._lanes = [Trivium(seed, lane) for lane in range(LANES)]

    def step(self) -> tuple[int, ...]:
        """Return the next word of each lane."""
        return tuple(lane.step() for lane in self._lanes)

"""Places of the random draws in the words of the random source, for gateware and model.

A generation takes :attr:`pathgene.hdl.config.Config.draw_steps` steps of the source; each step
gives one selection word and one mutation word. Pure Python.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from pathgene.hdl.config import Config


__all__ = ["LANES", "SEED_BITS", "WARM_UP_STEPS", "WORD_BITS", "RandomWordLayout", "Slice"]

#: Width of a word, and the maximum that Trivium's feedback taps allow in one step.
WORD_BITS = 64
#: Words per step: selection first, then mutation, each from its own generator.
LANES = 2
#: Width of the seed.
SEED_BITS = 64
#: Steps between loading a seed and the first word used: four full cycles of the 288-bit state.
WARM_UP_STEPS = 4 * 288 // WORD_BITS

Slice = tuple[int, int]


@dataclass(frozen=True)
class RandomWordLayout:
    """Bit slices ``(low, high)`` of the draws of one configuration.

    A uniform draw below ``n`` is ``slice * n >> width``: the relative error of each probability
    ``1 / n`` is at most ``n / 2**width``. With 24 bits for children and survivors, every ordered
    choice of 5 of 22 is within 7e-6.

    Step ``i`` of a generation carries, in the selection word, the two draws of crossover rank ``i``
    and the two of survivor ``i``; with the largest population they fill the word. In the mutation
    word it carries the child and the waypoint of mutator ``i``. Each step after the last mutator
    carries the offsets of one new waypoint: the first candidate of every patch, then the second
    candidate of every patch, and so on.
    """

    config: Config

    #: Width of the draws that pick distinct children and survivors.
    DISTINCT_BITS = 24
    #: Width of the draw that picks a waypoint, and of each coordinate's offset.
    OFFSET_BITS = 16

    @cached_property
    def rank_first(self) -> Slice:
        """First uniform draw of a crossover rank; the smaller of the two is the rank."""
        return 0, self.config.slot_bits

    @cached_property
    def rank_second(self) -> Slice:
        """Second uniform draw of a crossover rank."""
        return self.config.slot_bits, 2 * self.config.slot_bits

    @cached_property
    def survivor_first(self) -> Slice:
        """Draw of a survivor among the remaining paths."""
        low = 2 * self.config.slot_bits
        return low, low + self.DISTINCT_BITS

    @cached_property
    def survivor_second(self) -> Slice:
        """Second draw of a survivor, used when survivors are drawn by rank."""
        low = self.survivor_first[1]
        return low, low + self.DISTINCT_BITS

    @cached_property
    def child(self) -> Slice:
        """Draw of a mutator's child among the remaining children."""
        return 0, self.DISTINCT_BITS

    @cached_property
    def waypoint(self) -> Slice:
        """Draw of the waypoint that a mutator works on."""
        return self.DISTINCT_BITS, self.DISTINCT_BITS + self.OFFSET_BITS

    @cached_property
    def offsets(self) -> tuple[Slice, Slice, Slice]:
        """Draws of a new waypoint's offsets in x, y and altitude."""
        width = self.OFFSET_BITS
        return (0, width), (width, 2 * width), (2 * width, 3 * width)

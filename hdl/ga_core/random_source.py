"""The random source: parallel Trivium generators, each with 64 bits per step."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from pathgene.hdl.primitives.unit import Count, Unit
from pathgene.hdl.protocol.random_words import LANES, SEED_BITS, WARM_UP_STEPS, WORD_BITS


__all__ = ["RandomSource", "Trivium"]


class Trivium(Unit):
    """One generator: 288 bits of state, 64 steps of the cipher at once.

    The first of the 64 bits is the highest bit of ``word``; a path from state to state or to
    ``word`` is a single XOR of five or six bits, however many bits a step has.

    Source: De Canniere and Preneel, *Trivium specifications*, 2005. Equals
    :class:`pathgene.sim.model.random_source.Trivium` except for the warm-up, which is left to the
    user.

    Members
    -------
    load : In(1)
        Load ``key`` and the IV. Overrides ``step``. Before the first load the key is 0.
    key : In(64)
        The lowest 64 of the cipher's 80 key bits; the rest is 0.
    step : In(1)
        Advance.
    word : Out(64)
        Word of the step from the current state. Combinational.
    """

    iv: Count(0, "2**80 - 1", "Part of the loaded state.", name="IV")

    load: In(1)
    key: In(SEED_BITS)
    step: In(1)
    word: Out(WORD_BITS)

    def elaborate(self, platform):
        m = Module()

        # The newest bit of each register is the lowest.
        a = Signal(93, reset_less=True)
        b = Signal(84, init=self.iv, reset_less=True)
        c = Signal(111, init=0b111 << 108, reset_less=True)

        def tap(register, age):
            return register[age : age + WORD_BITS]

        t1 = tap(a, 2) ^ tap(a, 29)
        t2 = tap(b, 5) ^ tap(b, 20)
        t3 = tap(c, 2) ^ tap(c, 47)
        m.d.comb += self.word.eq(t1 ^ t2 ^ t3)

        with m.If(self.load):
            m.d.sync += [
                a.eq(self.key),
                b.eq(b.init),
                c.eq(c.init),
            ]
        with m.Elif(self.step):
            m.d.sync += [
                a.eq(Cat(t3 ^ tap(c, 45) & tap(c, 46) ^ tap(a, 5), a)),
                b.eq(Cat(t1 ^ tap(a, 27) & tap(a, 28) ^ tap(b, 14), b)),
                c.eq(Cat(t2 ^ tap(b, 18) & tap(b, 19) ^ tap(c, 23), c)),
            ]

        return m


class RandomSource(Unit):
    """All lanes: lane ``i`` has the seed as its key and ``i`` as its IV.

    After ``load``, the source warms up by itself and is ``ready`` again ``WARM_UP_STEPS + 1`` = 19
    cycles later. A newly configured chip starts in the same way with seed 0. After the warm-up, the
    state only advances with ``step``, so it is a function of the seed and the number of steps. The
    update of the state is invertible and no loaded state is 0, so the source never gets stuck. A
    reset does not reach the state, because its wires would span the chip.

    Equals :class:`pathgene.sim.model.random_source.RandomSource`.

    Members
    -------
    seed : In(64)
        Sampled with ``load``.
    load : In(1)
        Start again from ``seed``, at any time. Overrides ``step``.
    step : In(1)
        Advance by one word of each lane. Ignored while not ``ready``.
    words : Out(data.ArrayLayout(64, LANES))
        Words of the step from the current state, valid while ``ready``. Combinational.
    ready : Out(1)
        Warmed up.
    """

    seed: In(SEED_BITS)
    load: In(1)
    step: In(1)
    words: Out(data.ArrayLayout(WORD_BITS, LANES))
    ready: Out(1)

    def elaborate(self, platform):
        m = Module()

        # It counts up to its top bit, because `ready` enables every register and must be early.
        bits = ceil_log2(WARM_UP_STEPS)
        warm_up = Signal(bits + 1, init=(1 << bits) - WARM_UP_STEPS, reset_less=True)
        m.d.comb += self.ready.eq(warm_up[-1])

        for i in range(LANES):
            m.submodules[f"lane_{i}"] = lane = Trivium(iv=i)
            m.d.comb += [
                lane.load.eq(self.load),
                lane.key.eq(self.seed),
                lane.step.eq(self.step | ~self.ready),
                self.words[i].eq(lane.word),
            ]

        with m.If(self.load):
            m.d.sync += warm_up.eq(warm_up.init)
        with m.Elif(~self.ready):
            m.d.sync += warm_up.eq(warm_up + 1)

        return m

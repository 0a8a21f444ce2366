"""Header and fields of the answers as a sequence of words."""

from functools import reduce
from operator import or_

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.primitives.unit import Given, Unit


__all__ = ["WORD_BYTES", "ReplyWords"]

#: Bytes of a word: the width of a counter, so that a counter is read in one cycle.
WORD_BYTES = 6
#: Number of words that the first stage combines.
_GROUP = 8


class ReplyWords(Unit):
    """Presents the words of an answer one after another.

    There are many words, and their sources are spread over the chip. Therefore a shift register
    with one bit per word selects the word, and two registered stages combine the candidates.

    Members
    -------
    kind : In(AnswerKind)
        Steady from 2 cycles before ``word`` is used.
    begin : In(1)
        Go to the header.
    next : In(1)
        Go to the next word. ``begin`` comes before the first ``next``, also after a reset.
    word : Out(48)
        Bytes of the word, first byte lowest, padded with zeros. The word is valid 3 cycles after
        ``begin`` or ``next``, and follows its sources 2 cycles later.
    size : Out(3)
        Bytes of the word, valid with it.
    final : Out(1)
        The word is the last of its kind of answer; valid with it.
    """

    header: Given("Value", "First word of every answer.")
    replies: Given(
        "dict of tuple of AnswerKind to list of Value",
        "Fields of the answers, by kind, in one part or several: a part begins with a word "
        "of its own. Header and parts are whole bytes.",
    )

    def interface(self):
        self._firsts = {}
        self._words = [(self.header, len(self.header) // 8, False)]
        for kinds, parts in self.replies.items():
            self._firsts[kinds] = len(self._words)
            for part in parts:
                size, rest = divmod(len(part), 8)
                if rest:
                    raise ValueError(
                        f"Fields of an answer must be whole bytes, not {len(part)} bits"
                    )
                for at in range(0, size, WORD_BYTES):
                    end = min(size, at + WORD_BYTES)
                    final = part is parts[-1] and end == size
                    self._words.append((part[8 * at : 8 * end], end - at, final))
        return {
            "kind": In(AnswerKind),
            "begin": In(1),
            "next": In(1),
            "word": Out(8 * WORD_BYTES),
            "size": Out(range(WORD_BYTES + 1)),
            "final": Out(1),
        }

    def elaborate(self, platform):
        m = Module()

        chosen = Signal(len(self._words), init=1, reset_less=True)
        bare = Signal()  # The answer is only a header.
        with m.If(self.begin):
            m.d.sync += chosen.eq(1)
        with m.Elif(self.next):
            m.d.sync += chosen.eq(Cat(C(0, 2), chosen[1:]))
            with m.If(chosen[0]):
                with m.Switch(self.kind):
                    for kinds, first in self._firsts.items():
                        with m.Case(*kinds):
                            m.d.sync += chosen[first].eq(1)
        with m.Switch(self.kind):
            with m.Case(*(kind for kinds in self._firsts for kind in kinds)):
                m.d.comb += bare.eq(0)
            with m.Default():
                m.d.comb += bare.eq(1)

        numbered = list(zip(chosen, self._words, strict=True))
        groups = []
        for start in range(0, len(numbered), _GROUP):
            group = Signal(8 * WORD_BYTES, reset_less=True, name=f"group_{len(groups)}")
            words = numbered[start : start + _GROUP]
            m.d.sync += group.eq(_any(Mux(bit, word, 0) for bit, (word, _, _) in words))
            groups.append(group)
        size = Signal.like(self.size, reset_less=True)
        final = Signal(reset_less=True)
        m.d.sync += [
            size.eq(_any(Mux(bit, count, 0) for bit, (_, count, _) in numbered)),
            final.eq(_any(bit for bit, (_, _, last) in numbered if last) | (chosen[0] & bare)),
            self.word.eq(_any(groups)),
            self.size.eq(size),
            self.final.eq(final),
        ]

        return m


def _any(values):
    return reduce(or_, values)

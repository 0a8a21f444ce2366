"""Keys of paths, from decisions and walks."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from pathgene.hdl.feasibility.result_queue import ResultQueue
from pathgene.hdl.planner.evaluator.layouts import PLACES, decision_layout
from pathgene.hdl.planner.population_layouts import member_layout
from pathgene.hdl.planner.walker.path_reducer import result_layout
from pathgene.hdl.primitives.unit import Unit, Width
from pathgene.hdl.protocol.planner import HIT_BITS, VALUE_BITS, PathClass


__all__ = ["KeyMaker"]

#: A colliding corner counts in the penalty as four cells of length.


class KeyMaker(Unit):
    """Gives each path its key, in the order of the decisions.

    The key of a path follows its decision, or the result of its walk if it is walked, by 3 cycles;
    or it follows the previous key by a cycle, if that is later. It waits while a key is not taken.

    A path that is not walked is infeasible or given up, with the value of its score. One that is
    walked is infeasible if it collides or has a penalty: its value is the penalty plus four cells
    for each corner that collides, clamped to the maximum value. Else it is feasible, with its cost.

    Members
    -------
    decision : In(decision_layout)
        At most 16 decisions without a key are pending.
    result : In(result_layout)
        Walk of each path that is walked, in the order of the decisions, and after its decision.
    evaluated : Out(stream.Signature(member_layout))
    """

    slot_bits: Width(1)
    length_bits: Width(1)
    hits_bits: Width(1)

    def interface(self):
        return {
            "decision": In(decision_layout(self.slot_bits, self.length_bits)),
            "result": In(result_layout(self.hits_bits)),
            "evaluated": Out(stream.Signature(member_layout(self.slot_bits, self.length_bits))),
        }

    def elaborate(self, platform):
        m = Module()
        decision, result, evaluated = self.decision, self.result, self.evaluated

        word = data.StructLayout(
            {
                "walked": 1,
                "infeasible": 1,
                "value": VALUE_BITS,
                "slot": self.slot_bits,
                "length": self.length_bits,
            }
        )
        m.submodules.decisions = decisions = ResultQueue(word, PLACES)
        m.submodules.results = results = ResultQueue(self.hits_bits, PLACES)
        m.d.comb += [
            decisions.put.eq(decision.valid),
            *(
                decisions.word[name].eq(decision[name])
                for name in ("walked", "infeasible", "value")
            ),
            decisions.word.slot.eq(decision.path.head.slot),
            decisions.word.length.eq(decision.path.length),
            results.put.eq(result.valid),
            results.word.eq(result.hits),
        ]

        # The sum of a path, then its key.
        path, hits = decisions.words.p, results.words.p
        summed, moves, may_go = Signal(), Signal(2), Signal()
        total = Signal(max(VALUE_BITS, self.hits_bits + HIT_BITS) + 1, reset_less=True)
        kept = Signal(word, reset_less=True)
        collides = Signal(reset_less=True)
        key = Signal(evaluated.p.shape(), reset_less=True)
        m.d.comb += [
            evaluated.p.eq(key),
            moves[1].eq(~evaluated.valid | evaluated.ready),
            moves[0].eq(~summed | moves[1]),
            may_go.eq(decisions.words.valid & (~path.walked | results.words.valid)),
            decisions.words.ready.eq(moves[0] & may_go),
            results.words.ready.eq(moves[0] & may_go & path.walked),
        ]
        with m.If(moves[0]):
            m.d.sync += [
                summed.eq(may_go),
                kept.eq(path),
                collides.eq(path.walked & (hits != 0)),
                total.eq(
                    Mux(path.infeasible, path.value, 0) + (Mux(path.walked, hits, 0) << HIT_BITS)
                ),
            ]
        most = (1 << VALUE_BITS) - 1
        penalty = Mux(total[VALUE_BITS:].any(), most, total[:VALUE_BITS])
        infeasible = kept.infeasible | collides
        with m.If(moves[1]):
            m.d.sync += [
                evaluated.valid.eq(summed),
                key.key.eq(
                    Cat(
                        Mux(infeasible, penalty, kept.value),
                        Mux(
                            infeasible,
                            PathClass.INFEASIBLE.value,
                            Mux(kept.walked, PathClass.FEASIBLE.value, PathClass.GIVEN_UP.value),
                        )[:2],
                    )
                ),
                key.slot.eq(kept.slot),
                key.length.eq(kept.length),
            ]

        return m

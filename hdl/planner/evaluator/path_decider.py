"""Decision on a path by its score: walked or not."""

from amaranth import *
from amaranth.lib.wiring import In, Out

from pathgene.hdl.planner.evaluator.layouts import decision_layout, kept_layout
from pathgene.hdl.planner.scorer.scorer import score_layout
from pathgene.hdl.primitives.unit import Unit, Width


__all__ = ["PathDecider"]


class PathDecider(Unit):
    """Decides by the score and the head of a path; the decision follows by a cycle.

    While the best path of its population is feasible, a path is not walked if it is infeasible by
    its score, or if its value is not below its limit. Every other path is walked.

    Members
    -------
    score : In(score_layout)
    path : In(kept_layout)
        The path scored, with ``score.valid``.
    decision : Out(decision_layout)
    """

    slot_bits: Width(1)
    length_bits: Width(1)

    def interface(self):
        return {
            "score": In(score_layout()),
            "path": In(kept_layout(self.slot_bits, self.length_bits)),
            "decision": Out(decision_layout(self.slot_bits, self.length_bits)),
        }

    def elaborate(self, platform):
        m = Module()
        score, head = self.score, self.path.head

        decision = Signal(self.decision.shape(), reset_less=True)
        valid = Signal()
        m.d.comb += [self.decision.eq(decision), self.decision.valid.eq(valid)]
        given_up = head.limited & (score.value >= head.limit)
        m.d.sync += [
            valid.eq(score.valid),
            decision.walked.eq(~head.first | ~(score.infeasible | given_up)),
            decision.infeasible.eq(score.infeasible),
            decision.value.eq(score.value),
            decision.path.eq(self.path),
        ]

        return m

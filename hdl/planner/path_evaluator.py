"""Evaluator of paths: from points to keys by score, decision and walk."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import head_layout, member_layout, problem_layout
from pathgene.hdl.planner.path_store import (
    PLACE_BITS,
    PLACES,
    PathStore,
    decision_layout,
    kept_layout,
)
from pathgene.hdl.planner.population_memory import decided_layout, margin_layout
from pathgene.hdl.planner.scorer.scorer import Scorer, score_layout
from pathgene.hdl.planner.walker.path_walker import PathWalker, result_layout
from pathgene.hdl.planner.walker.segment_source import SegmentSource, queued_layout
from pathgene.hdl.primitives.buffers import ResultQueue
from pathgene.hdl.primitives.unit import Count, InstanceOf, PowerOfTwo, Unit, Width
from pathgene.hdl.protocol.planner import HIT_BITS, MEMO_ROWS, VALUE_BITS, PathClass


__all__ = ["KeyMaker", "PathDecider", "PathEvaluator"]


class PathDecider(Unit):
    """Decides by the score and the head of a path; the decision follows one cycle later.

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


#: A colliding corner counts in the penalty as four cells of length.


class KeyMaker(Unit):
    """Assigns each path its key, in the order of the decisions.

    The key of a path follows its decision, or the result of its walk if it is walked, by 3 cycles;
    or it follows the previous key by one cycle if that is later. It waits while the previous key is
    not taken.

    A path that is not walked is infeasible or given up, with the value of its score. A walked path
    is infeasible if it collides or has a penalty: its value is the penalty plus four cells for each
    colliding corner, clamped to the maximum value. Otherwise it is feasible, and its value is its
    cost.

    Members
    -------
    decision : In(decision_layout)
        At most 16 decisions without a key are pending.
    result : In(result_layout)
        Walk of each walked path, in the order of the decisions and after its decision.
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


#: Number of heads that can wait for the points of their paths. The breeder is ahead by fewer: by 16
#: points, at least four per path.
_HEADS = 8
#: Members of the walker that are passed on.
_PASSED = ("clear", "busy", "writes", "row", "corners")


class PathEvaluator(Unit):
    """Scores paths, walks the promising ones, and outputs all keys in order.

    A path of m points, including entry and exit, takes m cycles, or 2 m if ``config.point_cycles``
    is 2, and the next path follows immediately. The scorer is never stopped inside a path. Sixteen
    paths may be inside; the first point of another path is taken at the earliest in the cycle after
    the key of the first path is taken.

    A path is decided one cycle after its score. If it is not walked, its key is offered 3 cycles
    later, or in the cycle after the previous key. If it is walked, its first segment is offered to
    the walker 3 cycles after the decision, and its key 3 cycles after the result of the walk, or in
    the cycle after the previous key is taken. Cycles equal
    :func:`pathgene.sim.model.planner.cycles.enter`, keys
    :func:`pathgene.sim.model.planner.evaluation.evaluate`.

    At least 3 cycles before the key of a path is offered, the path is ``decided`` and, if it is
    walked, its last ``margin`` is output.

    Members
    -------
    problem : In(problem_layout)
        Steady while paths are inside.
    phase : In(1)
        1 in the second cycle of every time slot of the scorer; alternates in every cycle. Ignored
        if a slot is one cycle.
    paths : In(stream.Signature(head_layout))
        A head for each path, in order. Up to 8 wait for their points. The first point of a path is
        taken at the earliest in the cycle after its head.
    points : In(stream.Signature(point_layout))
        Points of the paths: start corner, waypoints, goal corner; ``last`` marks the goal. A path
        has two or more points. All paths inside begin at the same corner.
    evaluated : Out(stream.Signature(member_layout))
        Key, slot and length of each path, in order.
    decided : Out(decided_layout)
        ``valid``: the path in ``slot`` is decided, to be ``walked`` or not. In the order of paths.
    margin : Out(margin_layout)
        ``valid``: the margin of a waypoint. All margins of each walked path are output in order.
    idle : Out(1)
        No path is inside and no head is waiting.
    clear_counters : In(1)
        Pulse: set both counters to 0 in the cycle after the next. No path is inside.
    score : Out(32)
        Cycles in which the scorer had a point: ``config.point_cycles`` for each point, including
        entries and exits.
    walk : Out(32)
        Cycles in which the walker was busy with segments: the sum of their costs.
    clear : In(1)
        Clear the memo, because the map has changed. Only while no path is inside and ``busy`` is
        low.
    busy : Out(1)
        The rows of the memo are being cleared and no path is walked: after a reset, and rarely
        after ``clear``.
    writes : In(stream.Signature(cell_layout))
    row : In(row_layout)
    corners : Out(config.altitude_bits).array(config.lanes)
        See :class:`pathgene.hdl.planner.walker.segment_walker.SegmentWalker`.
    """

    config: InstanceOf(Config)
    slots: Count(2, text="Paths of the population.")
    memo_rows: PowerOfTwo(2, 1 << 16, "Segments of the memo.", name="Rows", also=(0,)) = MEMO_ROWS

    def interface(self):
        config = self.config
        self.slot_bits = (self.slots - 1).bit_length()
        self.walker = PathWalker(config, self.memo_rows)
        self.scorer = Scorer(config)
        sizes = (config.coordinate_bits, config.altitude_bits)
        member = member_layout(self.slot_bits, config.length_bits)
        passed = self.walker.signature.members
        return {
            "problem": In(problem_layout(config)),
            "phase": In(1),
            "paths": In(stream.Signature(head_layout(self.slot_bits))),
            "points": In(stream.Signature(point_layout(*sizes))),
            "evaluated": Out(stream.Signature(member)),
            "decided": Out(decided_layout(self.slots)),
            "margin": Out(margin_layout(self.slots, config.max_waypoints, config.altitude_bits)),
            "idle": Out(1),
            "clear_counters": In(1),
            "score": Out(32),
            "walk": Out(32),
            **{name: passed[name] for name in _PASSED},
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config
        sizes = (config.coordinate_bits, config.altitude_bits)

        m.submodules.scorer = self.scorer
        m.submodules.store = store = PathStore(config.max_waypoints, *sizes, self.slot_bits)
        m.submodules.decider = decider = PathDecider(self.slot_bits, config.length_bits)
        m.submodules.source = source = SegmentSource(*sizes, PLACE_BITS, store.row_bits)
        m.submodules.walker = walker = self.walker
        m.submodules.keys = keys = KeyMaker(self.slot_bits, config.length_bits, walker.hits_bits)
        self._take(m, store, source)
        m.d.comb += [
            store.has_entry.eq(self.problem.has_entry),
            store.record.eq(self.scorer.chord),
            store.scored.eq(self.scorer.score.valid),
            store.read.eq(source.read),
            source.row.eq(store.row),
            decider.score.eq(self.scorer.score),
            decider.path.eq(store.path),
            keys.decision.eq(decider.decision),
            keys.result.eq(walker.result),
        ]
        connect(m, source.segments, walker.segments)
        connect(m, keys.evaluated, flipped(self.evaluated))
        connect(m, flipped(self.writes), walker.writes)
        m.d.comb += [
            walker.clear.eq(self.clear),
            self.busy.eq(walker.busy),
            walker.row.eq(self.row),
            *(own.eq(corner) for own, corner in zip(self.corners, walker.corners, strict=True)),
        ]

        # Paths to be walked wait for the source, and their slots wait for the margins.
        decision = decider.decision
        goes = decision.valid & decision.walked
        m.submodules.walks = walks = ResultQueue(queued_layout(PLACE_BITS, store.row_bits), PLACES)
        m.submodules.walked_slots = slots = ResultQueue(self.slot_bits, PLACES)
        connect(m, walks.words, source.paths)
        m.d.comb += [
            walks.put.eq(goes),
            walks.word.place.eq(decision.path.place),
            walks.word.goal.eq(decision.path.length + 1),
            walks.word.enters.eq(decision.path.enters),
            walks.word.first.eq(decision.path.head.first),
            slots.put.eq(goes),
            slots.word.eq(decision.path.head.slot),
            slots.words.ready.eq(walker.result.valid),
            self.decided.valid.eq(decision.valid),
            self.decided.slot.eq(decision.path.head.slot),
            self.decided.walked.eq(decision.walked),
            self.margin.valid.eq(walker.margin.valid),
            self.margin.place.slot.eq(slots.words.p),
            self.margin.place.index.eq(walker.margin.index),
            self.margin.margin.eq(walker.margin.margin),
        ]

        # One cycle later, because the pulse arrives late.
        clears = Signal()
        m.d.sync += clears.eq(self.clear_counters)
        counted = ((self.score, self.scorer.launcher.valid), (self.walk, walker.launching))
        for counter, counts in counted:
            m.d.sync += counter.eq(Mux(clears, 0, counter + counts))

        return m

    def _take(self, m, store, source):
        """Take heads, and points as the scorer takes them, while there is a place for the path."""
        paths, points, scorer = self.paths, self.points, self.scorer

        m.submodules.heads = heads = ResultQueue(paths.p.shape(), _HEADS)
        waiting = Signal(range(_HEADS + 1))
        inside = Signal(range(PLACES + 1))
        begins, may_pass = Signal(init=1), Signal()
        first, taken = Signal(), Signal()
        left = Signal()  # The head has left; a path has two points, so there is time.
        m.d.comb += [
            paths.ready.eq(waiting != _HEADS),
            heads.put.eq(paths.valid & paths.ready),
            heads.word.eq(paths.p),
            heads.words.ready.eq(left),
            may_pass.eq(~begins | (heads.words.valid & (inside != PLACES))),
            scorer.problem.eq(self.problem),
            scorer.phase.eq(self.phase),
            scorer.room.eq(1),
            scorer.points.valid.eq(points.valid & may_pass),
            scorer.points.p.eq(points.p),
            points.ready.eq(scorer.points.ready & may_pass),
            taken.eq(points.valid & points.ready),
            first.eq(taken & begins),
            store.head.eq(heads.words.p),
            store.taken.valid.eq(taken),
            store.taken.point.eq(points.p),
            self.idle.eq((waiting == 0) & (inside == 0)),
        ]
        m.d.sync += [
            left.eq(first),
            waiting.eq(waiting + heads.put - left),
            inside.eq(inside + first - (self.evaluated.valid & self.evaluated.ready)),
        ]
        with m.If(taken):
            m.d.sync += begins.eq(points.p.last)
        start = Signal(source.start.shape(), reset_less=True)
        m.d.comb += source.start.eq(start)
        with m.If(first):
            m.d.sync += [start[axis].eq(points.p[axis]) for axis in ("x", "y", "altitude")]

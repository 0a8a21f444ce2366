"""Scores of paths: costs, penalties and chords."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import Config
from hdl.feasibility.result_queue import ResultQueue
from hdl.layouts import point_layout
from hdl.planner.layouts import problem_layout
from hdl.planner.scorer.arc_fitter import ArcFitter
from hdl.planner.scorer.arc_measurer import ArcMeasurer
from hdl.planner.scorer.arc_placer import ArcPlacer
from hdl.planner.scorer.chord_queue import ChordQueue, chord_layout
from hdl.planner.scorer.path_pricer import PathPricer
from hdl.planner.scorer.penalty_counter import PenaltyCounter
from hdl.planner.scorer.point_launcher import PointLauncher
from hdl.planner.scorer.schedule import Schedule, Timed
from hdl.planner.scorer.segment_measurer import SegmentMeasurer
from hdl.planner.scorer.slope_comparator import SlopeComparator
from hdl.planner.scorer.turn_measurer import TurnMeasurer
from hdl.planner.scorer.widths import SHARE_BITS, Widths
from hdl.protocol.planner import POSITION_FRACTION, VALUE_BITS


__all__ = ["CHORDS", "RESULTS", "Scorer", "score_layout"]

#: A length of one cell: arcs with longer tangents have their chords walked.
CELL = 1 << POSITION_FRACTION
#: Chords and results that wait or are on their way; the chords' ends fill a block RAM of 512 rows.
CHORDS, RESULTS = 256, 32

#: The submodules in the order of the pipeline; all but the first and the last have its phase.
UNITS = (
    "launcher",
    "segments",
    "turns",
    "slopes",
    "fitter",
    "arcs",
    "placer",
    "arc_slopes",
    "pricer",
    "penalties",
    "chord_queue",
    "score_queue",
)


def score_layout() -> data.StructLayout:
    """Return the layout of a path's score.

    ``infeasible``: a slope is too steep or an arc does not fit. ``value``: if so, the penalty, else
    the cost, as the value of a key. ``unlimited``: the cost is not below ``4 << VALUE_BITS``, a key
    above all others, and so not below any limit.
    """
    return data.StructLayout({"infeasible": 1, "unlimited": 1, "value": VALUE_BITS})


class Scorer(wiring.Component):
    """Scores paths, a segment every two cycles.

    A path of n points takes 2 n cycles, and the next one follows at once. The stages do not wait
    for each other: a path enters if the queues at their ends have room for all of it. Chords and
    scores are offered in the order of waypoints and paths; both must be taken, or no further path
    enters. In the default sizes, and where nothing waits, the chord of a waypoint is offered 90
    cycles after the point behind it is taken, and the score of a path 145 cycles after its goal.

    A score has what :meth:`sim.model.planner.definition.evaluation.Evaluator.evaluate` needs
    besides the walk. The entry and the exit of a record are to come: ``has_entry`` and ``has_exit``
    must be 0.

    Source: ``docs/chip_planner.md``, "The score".

    Parameters
    ----------
    config : Config

    Members
    -------
    problem : In(problem_layout)
        Steady while there are paths inside. No scale is above 1.
    gives_up : In(1)
        Steep arcs count only in paths without another penalty: the best path of the population is
        feasible. Steady likewise.
    points : In(stream.Signature(point_layout))
        Points of paths, one path after the other: start corner, waypoints, goal corner. A path has
        three points or more, and at most those of its configuration.
    chords : Out(stream.Signature(chord_layout))
        For each waypoint, the chord of its arc.
    scores : Out(stream.Signature(score_layout))
        For each path.
    """

    def __init__(self, config: Config):
        self.config = config
        self.widths = widths = Widths.of(config)
        sizes = config.coordinate_bits, config.altitude_bits
        self.launcher = PointLauncher(widths)
        self.segments = SegmentMeasurer(widths)
        self.turns = TurnMeasurer(widths)
        self.slopes = SlopeComparator(widths.length, widths.part + 1, 0)
        self.fitter = ArcFitter(widths)
        self.arcs = ArcMeasurer(widths)
        self.placer = ArcPlacer(widths)
        self.arc_slopes = SlopeComparator(widths.arc, widths.part + SHARE_BITS + 2, SHARE_BITS)
        self.pricer = PathPricer(widths)
        self.penalties = PenaltyCounter(widths)
        self.chord_queue = ChordQueue(*sizes, CHORDS)
        self.score_queue = ResultQueue(score_layout(), RESULTS)
        super().__init__(
            {
                "problem": In(problem_layout(config)),
                "gives_up": In(1),
                "points": In(stream.Signature(point_layout(*sizes))),
                "chords": Out(stream.Signature(chord_layout(*sizes))),
                "scores": Out(stream.Signature(score_layout())),
            }
        )

    def elaborate(self, platform):
        m = Module()

        for name in UNITS:
            m.submodules[name] = getattr(self, name)
        stages = Schedule(m, self.launcher.phase)
        for name in UNITS[1:-1]:
            m.d.comb += getattr(self, name).phase.eq(self.launcher.phase)
        fields = {
            self.segments: ("x_scale", "y_scale"),
            self.turns: ("radius",),
            self.slopes: ("climb", "descent"),
            self.arcs: ("radius",),
            self.arc_slopes: ("climb", "descent"),
            self.pricer: ("rise", "base", "drag", "fuel", "fuel_shift", "key_shift"),
        }
        for unit, names in fields.items():
            m.d.comb += [getattr(unit, name).eq(self.problem[name]) for name in names]

        self._launch(m)
        self._measure(m, stages)
        self._lay_arcs(m, stages)

        return m

    def _launch(self, m):
        """Take points while the queues have room, and send what is in the queues."""
        launcher = self.launcher
        connect(m, flipped(self.points), launcher.points)
        for end in ("start", "goal"):
            m.d.comb += [
                getattr(launcher, end)[axis].eq(self.problem[f"{end}_{axis}"])
                for axis in ("x", "y", "altitude")
            ]
        connect(m, self.chord_queue.chords, flipped(self.chords))
        connect(m, self.score_queue.words, flipped(self.scores))

        # Waypoints and paths that are in the stages or wait in the queues.
        chords, scores = Signal(range(CHORDS + 1)), Signal(range(RESULTS + 1))
        m.d.sync += [
            chords.eq(chords + launcher.launches_inner - (self.chords.valid & self.chords.ready)),
            scores.eq(scores + launcher.launches - (self.scores.valid & self.scores.ready)),
            launcher.room.eq((chords <= CHORDS - self.config.max_waypoints) & (scores < RESULTS)),
        ]

    def _measure(self, m, stages):
        """Add the way of a point to the fitter; a slot has the segment that ends at its point."""
        launcher, segments, turns, slopes = self.launcher, self.segments, self.turns, self.slopes
        fitter = self.fitter
        measured = segments.latency
        fitting = measured + turns.latency
        valid = self._flags(m, launcher.valid, fitting // 2, "valid")
        first, last = Timed(launcher.first, 0), Timed(launcher.last, 0)
        length = Timed(segments.length, measured)
        steep, excess = (
            Timed(each, measured + slopes.latency) for each in (slopes.steep, slopes.excess)
        )
        m.d.comb += [
            segments.valid.eq(launcher.valid),
            segments.place.eq(launcher.place),
            turns.valid.eq(valid[measured // 2]),
            turns.first.eq(stages.at(first, measured)),
            turns.dx.eq(segments.dx),
            turns.dy.eq(segments.dy),
            turns.length.eq(segments.length),
            slopes.length.eq(segments.length),
            slopes.rise.eq(segments.rise),
            fitter.valid.eq(valid[fitting // 2]),
            fitter.turn.first.eq(stages.at(first, fitting)),
            fitter.turn.last.eq(stages.at(last, fitting)),
            fitter.turn.steep.eq(stages.at(steep, fitting)),
            fitter.turn.excess.eq(stages.at(excess, fitting)),
            fitter.turn.length.eq(stages.at(length, fitting)),
            fitter.turn.half_turn.eq(turns.half_turn),
            fitter.turn.tangent.eq(turns.tangent),
        ]

    def _lay_arcs(self, m, stages):
        """Add the way from the fitter to the chords, and to the cost."""
        launcher, fitter, arcs, placer = self.launcher, self.fitter, self.arcs, self.placer
        fitting = self.segments.latency + self.turns.latency
        fitted_at = fitting + fitter.latency
        placing = fitted_at + arcs.latency
        laid_at = placing + placer.latency
        curves = Timed(fitter.fitted.tangent.any(), fitted_at)
        corner = [Timed(each, 0) for each in (launcher.x, launcher.y, launcher.place.altitude)]
        x, y, altitude = stages.together(placing, *corner)
        m.d.comb += [
            *(
                getattr(arcs, name).eq(fitter.fitted[name])
                for name in ("half_turn", "tangent", "length", "next_length")
            ),
            placer.moves.eq(stages.at(Timed(fitter.moves, fitting), placing)),
            placer.corner.x.eq(x.value),
            placer.corner.y.eq(y.value),
            placer.corner.altitude.eq(altitude.value),
            placer.curves.eq(stages.at(curves, placing)),
            placer.back.eq(arcs.back),
            placer.on.eq(arcs.on),
        ]

        flags = {name: fitter.fitted[name] for name in ("first", "last", "steep", "fits")}
        flags |= {"curves": curves.value, "chord": fitter.fitted.tangent > CELL}
        laid = {name: stages.at(Timed(each, fitted_at), laid_at) for name, each in flags.items()}
        sizes = {
            name: Timed(fitter.fitted[name], fitted_at) for name in ("length", "tangent", "excess")
        }
        delayed = stages.together(laid_at, *sizes.values())
        laid |= {name: each.value for name, each in zip(sizes, delayed, strict=True)}
        laid["arc_length"] = stages.at(Timed(arcs.arc_length, placing), laid_at)
        laid |= {name: getattr(placer, name) for name in ("start_altitude", "before", "after")}
        valid = self._flags(m, fitter.fitted_valid, (laid_at - fitted_at) // 2, "laid")[-1]
        queue, pricer = self.chord_queue, self.pricer
        m.d.comb += [
            pricer.valid.eq(valid),
            *(pricer.laid[name].eq(laid[name]) for name, _ in pricer.laid.shape()),
            queue.put.eq(valid & ~laid["last"]),
            queue.chord.exists.eq(laid["chord"]),
            *(queue.chord.ends[end].eq(placer.ends[end]) for end in range(2)),
        ]
        self._judge(m, stages, valid, laid)

    def _judge(self, m, stages, valid, laid):
        """Add what makes a score; times begin with the slot of ``laid``."""
        slopes, penalties, queue = self.arc_slopes, self.penalties, self.score_queue
        judging = slopes.latency
        wrong = {
            "sharp": ~laid["fits"] & ~laid["last"],
            **{
                name: laid[name]
                for name in ("first", "last", "steep", "excess", "length", "arc_length")
            },
        }
        wrong = {name: stages.at(Timed(each, 0), judging) for name, each in wrong.items()}
        curves = stages.at(Timed(laid["curves"], 0), judging)
        scored = self.pricer.latency
        ends = self._flags(m, valid & laid["last"], scored // 2, "ended")[-1]
        penalty = stages.at(Timed(penalties.penalty, judging + penalties.latency), scored)
        m.d.comb += [
            slopes.length.eq(laid["arc_length"]),
            slopes.rise.eq(self.placer.rise),
            penalties.gives_up.eq(self.gives_up),
            penalties.valid.eq(self._flags(m, valid, judging // 2, "judged")[-1]),
            *(penalties.judged[name].eq(each) for name, each in wrong.items()),
            penalties.judged.steep_arc.eq(slopes.steep & curves),
            queue.put.eq(ends & self.launcher.phase),
            queue.word.infeasible.eq(penalty.any()),
            queue.word.unlimited.eq(self.pricer.unlimited),
            queue.word.value.eq(Mux(penalty.any(), penalty, self.pricer.value)),
        ]

    def _flags(self, m, flag, slots, name):
        """Return ``flag`` and what it was in each of so many slots before, cleared by a reset."""
        earlier = Signal(slots, name=f"{name}_flags")
        with m.If(self.launcher.phase):
            m.d.sync += earlier.eq(Cat(flag, earlier))
        return [flag, *earlier]

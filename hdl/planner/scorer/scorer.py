"""Scores of paths: costs, penalties and chords."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import point_layout
from pathgene.hdl.planner.layouts import problem_layout
from pathgene.hdl.planner.scorer.arc_fitter import ArcFitter
from pathgene.hdl.planner.scorer.arcs import ArcMeasurer, ArcPlacer
from pathgene.hdl.planner.scorer.measurers import SegmentMeasurer, TurnMeasurer
from pathgene.hdl.planner.scorer.path_pricer import PathPricer
from pathgene.hdl.planner.scorer.penalty_counter import PenaltyCounter, SlopeComparator
from pathgene.hdl.planner.scorer.point_launcher import PointLauncher
from pathgene.hdl.planner.scorer.schedule import Schedule, Timed
from pathgene.hdl.planner.scorer.widths import Widths
from pathgene.hdl.planner.walker.layouts import corner_layout
from pathgene.hdl.primitives.logic import fanout
from pathgene.hdl.primitives.unit import InstanceOf, Unit
from pathgene.hdl.protocol.planner import POSITION_FRACTION, SHARE_BITS, VALUE_BITS


__all__ = ["Scorer", "chord_record_layout", "score_layout"]

#: A length of one cell: the chords of arcs with longer tangents are walked.
CELL = 1 << POSITION_FRACTION

#: The submodules in the order of the pipeline.
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
)


def score_layout() -> data.StructLayout:
    """Return the layout of a path's score, which is ``valid`` for one cycle.

    ``infeasible``: a slope is too steep or an arc does not fit. ``value``: the penalty in that
    case, otherwise the cost, in the form of a key's value.
    """
    return data.StructLayout({"valid": 1, "infeasible": 1, "value": VALUE_BITS})


def chord_record_layout(coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the chord at a segment's end, which is ``valid`` for one cycle.

    ``last``: the segment is the last of its path. ``present``: there is a chord, from ``start`` to
    ``stop``; never at the end of the last segment.
    """
    corner = corner_layout(coordinate_bits, altitude_bits)
    return data.StructLayout({"valid": 1, "last": 1, "present": 1, "start": corner, "stop": corner})


class Scorer(Unit):
    """Scores paths, a point in every slot of c = ``config.point_cycles`` cycles.

    The entry of the record is the first point of every path, before the points that arrive, and the
    exit is the last. A path of m points, including these, takes c m cycles, and the next path
    follows immediately. Nothing inside waits, and every output must be taken.

    *Launch.* ``launches`` is set for a path in the first cycle that is the last of a slot and in
    which its first point has been taken in an earlier cycle, its second is offered, there was
    ``room`` in the previous cycle, and the previous path, if it had m points, was launched at least
    c m cycles ago. The first slot of the path begins in the next cycle. The scorer stores one
    point, which leaves in the cycle before its slot: ``L + c (i + has_entry)`` for arriving point
    i, counted from 0, of a path launched in cycle L. In that cycle the next point is taken, unless
    it is late; if no point is stored, it is taken immediately.

    *Results.* If no point of a path is late, and the path is launched in cycle L, the record of
    segment j, counted from 0, is output in cycle ``L + chord_latency + c j``, and the score
    ``score_latency`` cycles after the record of the last segment. With the default sizes these are
    73 and 50 cycles: a path of m points is scored in cycle ``L + m + 121``. With two cycles a point
    they are 87 and 56 cycles, and it is scored in cycle ``L + 2 m + 139``. A late point delays its
    slot and all later slots by a multiple of c.
    ``sim/model/planner/evaluator_cycles.py`` has the same counts.

    A score and a walk are everything that :func:`pathgene.sim.model.planner.evaluation.evaluate`
    needs.

    Source: ``docs/chip_planner.md``, "The score".

    Attributes
    ----------
    chord_latency : int
        Cycles from ``launches`` to the record of the path's first segment.
    score_latency : int
        Cycles from the record of a path's last segment to its score.

    Members
    -------
    problem : In(problem_layout)
        Steady from the cycle in which a path's first point is taken until its score. No scale is
        above 1.
    phase : In(1)
        1 in the second cycle of every slot: alternates in every cycle, starting at 0 after a reset.
        Ignored if a slot is one cycle.
    room : In(1)
        A path may begin in the next slot. Sampled in the cycle before the last one of a slot.
    points : In(stream.Signature(point_layout))
        Points of paths, path after path: start corner, waypoints, goal corner. A path has at least
        two points, and at most the maximum of the configuration.
    launches : Out(1)
        Pulse in the last cycle of a slot: a path begins in the next slot.
    chord : Out(chord_record_layout)
        For each segment of a path, in order, the chord of the arc at its end.
    score : Out(score_layout)
        For each path, after all its chords.
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.widths = widths = Widths.of(config)
        sizes = config.coordinate_bits, config.altitude_bits
        cycles = config.point_cycles
        self.launcher = PointLauncher(widths)
        self.segments = SegmentMeasurer(widths, cycles)
        self.turns = TurnMeasurer(widths, cycles)
        self.slopes = SlopeComparator(widths.length, widths.part + 1, 0, cycles)
        self.fitter = ArcFitter(widths, cycles)
        self.arcs = ArcMeasurer(widths, cycles)
        self.placer = ArcPlacer(widths, cycles)
        arc_rise = widths.part + SHARE_BITS + 2
        self.arc_slopes = SlopeComparator(widths.arc, arc_rise, SHARE_BITS, cycles)
        self.pricer = PathPricer(widths, cycles)
        self.penalties = PenaltyCounter(widths, cycles)
        # A segment is sent by the second slot after its own, and that is the second slot of a path.
        laying = self.arcs.latency + self.placer.latency
        self._fitting = self.segments.latency + self.turns.latency
        self.chord_latency = 1 + 3 * cycles + self._fitting + self.fitter.latency + laying
        self.score_latency = self.pricer.latency
        return {
            "problem": In(problem_layout(config)),
            "phase": In(1),
            "room": In(1),
            "points": In(stream.Signature(point_layout(*sizes))),
            "launches": Out(1),
            "chord": Out(chord_record_layout(*sizes)),
            "score": Out(score_layout()),
        }

    def elaborate(self, platform):
        m = Module()

        # A register for each unit, because a shared register would be far from most of them. Every
        # cycle is the last one of a slot of one cycle.
        stages = Schedule(m, self.phase, self.config.point_cycles)
        phases = [stages.ends] * len(UNITS)
        if self.config.point_cycles == 2:
            phases = fanout(m, *[~self.phase] * len(UNITS), name="phase")
        for name, phase in zip(UNITS, phases, strict=True):
            m.submodules[name] = getattr(self, name)
            m.d.comb += getattr(self, name).phase.eq(phase)
        fields = {
            self.launcher: ("has_entry", "has_exit", "x_limit", "y_limit"),
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
        """Take points while there is room."""
        launcher = self.launcher
        connect(m, flipped(self.points), launcher.points)
        for end in ("start", "goal", "entry", "exit"):
            m.d.comb += [
                getattr(launcher, end)[axis].eq(self.problem[f"{end}_{axis}"])
                for axis in ("x", "y", "altitude")
            ]
        m.d.comb += [launcher.room.eq(self.room), self.launches.eq(launcher.launches)]

    def _measure(self, m, stages):
        """Add the stages from a point to the fitter; a slot has the segment up to its point."""
        launcher, segments, turns, slopes = self.launcher, self.segments, self.turns, self.slopes
        fitter = self.fitter
        measured, fitting = segments.latency, self._fitting
        valid = self._flags(m, stages, launcher.valid, fitting, "valid")
        first, last = Timed(launcher.first, 0), Timed(launcher.last, 0)
        length = Timed(segments.length, measured)
        steep, excess = (
            Timed(each, measured + slopes.latency) for each in (slopes.steep, slopes.excess)
        )
        m.d.comb += [
            segments.valid.eq(launcher.valid),
            segments.place.eq(launcher.place),
            turns.valid.eq(valid[stages.slots(measured)]),
            turns.first.eq(stages.at(first, measured)),
            turns.dx.eq(segments.dx),
            turns.dy.eq(segments.dy),
            turns.length.eq(segments.length),
            slopes.length.eq(segments.length),
            slopes.rise.eq(segments.rise),
            fitter.valid.eq(valid[stages.slots(fitting)]),
            fitter.turn.first.eq(stages.at(first, fitting)),
            fitter.turn.last.eq(stages.at(last, fitting)),
            fitter.turn.steep.eq(stages.at(steep, fitting)),
            fitter.turn.excess.eq(stages.at(excess, fitting)),
            fitter.turn.length.eq(stages.at(length, fitting)),
            fitter.turn.half_turn.eq(turns.half_turn),
            fitter.turn.tangent.eq(turns.tangent),
        ]

    def _lay_arcs(self, m, stages):
        """Add the stages from the fitter to the chords, and to the cost."""
        launcher, fitter, arcs, placer = self.launcher, self.fitter, self.arcs, self.placer
        fitted_at = self._fitting + fitter.latency
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
            placer.moves.eq(stages.at(Timed(fitter.moves, self._fitting), placing)),
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
        valid = self._flags(m, stages, fitter.fitted_valid, laid_at - fitted_at, "laid")[-1]
        pricer, chord = self.pricer, self.chord
        m.d.comb += [
            pricer.valid.eq(valid),
            *(pricer.laid[name].eq(laid[name]) for name, _ in pricer.laid.shape()),
            chord.valid.eq(valid & stages.begins),
            chord.last.eq(laid["last"]),
            chord.present.eq(laid["chord"]),
            chord.start.eq(placer.ends[0]),
            chord.stop.eq(placer.ends[1]),
        ]
        self._judge(m, stages, valid, laid)

    def _judge(self, m, stages, valid, laid):
        """Add the stages from arcs to a score; times begin with the slot of ``laid``."""
        slopes, penalties = self.arc_slopes, self.penalties
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
        ends = self._flags(m, stages, valid & laid["last"], scored, "ended")[-1]
        penalty = Timed(penalties.penalty, judging + penalties.latency)
        infeasible = stages.compute_held("infeasible", lambda penalty: penalty.any(), penalty)
        penalty, infeasible = (stages.at(each, scored) for each in (penalty, infeasible))
        m.d.comb += [
            slopes.length.eq(laid["arc_length"]),
            slopes.rise.eq(self.placer.rise),
            penalties.valid.eq(self._flags(m, stages, valid, judging, "judged")[-1]),
            *(penalties.judged[name].eq(each) for name, each in wrong.items()),
            penalties.judged.steep_arc.eq(slopes.steep & curves),
            self.score.valid.eq(ends & stages.begins),
            self.score.infeasible.eq(infeasible),
            self.score.value.eq(Mux(infeasible, penalty, self.pricer.value)),
        ]

    def _flags(self, m, stages, flag, time, name):
        """Return ``flag`` and its values in the slots of the last ``time`` cycles, with resets."""
        earlier = Signal(stages.slots(time), name=f"{name}_flags")
        with m.If(stages.ends):
            m.d.sync += earlier.eq(Cat(flag, earlier))
        return [flag, *earlier]

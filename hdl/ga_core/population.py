"""The population: all chromosomes, read in lock step, and its update in one clock."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import Config, MutationKind
from hdl.ga_core.chromosome import (
    Chromosome,
    ReadIndex,
    half_bits,
    half_signature,
    pending_layout,
    position_bits,
)
from hdl.ga_core.crossover import Crossover, parents_of
from hdl.ga_core.layouts import mutation_layout, read_layout, waypoint_layout, write_layout
from hdl.ga_core.multiplexer import chosen
from hdl.ga_core.readout import ReadOut
from hdl.ga_core.slot_mapping import carrier_layout, carriers


__all__ = ["Population"]


class Population(wiring.Component):
    """All chromosomes, and the ports through which their waypoints pass.

    The paths are read in lock step. While ``on``, each port gets the next waypoint of its path
    every clock: that of ``position`` is in ``waypoints`` while ``carrying``, from the second clock
    on. Elites and survivors are copied to the first slots as they pass; the crossover modules write
    their children to the last ones. All is written to the banks that are not read; ``update`` swaps
    the banks in one clock (*allaire-2008*, section 4.4). The first waypoints are read ahead, so
    that no clock is lost.

    After reset every path has two waypoints, which are 0 when the chip has been configured.

    Source: *allaire-2008*, section 4.4. Differs: the children are in their slots already when the
    others are, so that the update is a change of bank.

    Parameters
    ----------
    config : Config

    Members
    -------
    carried : In(carrier_layout).array(carriers)
        Slot and length of the path of each port: elites, survivors, parents.
    on : In(1)
        Pass the next waypoints. May rise only while ``settled``.
    waypoints : Out(waypoint_bits).array(carriers)
    position : Out(index_bits)
    carrying : Out(1)
    over : Out(1)
        In the last clock of the crossover: that after the last waypoint of the longest path.
    patches : In(waypoint_bits).array(patches)
        New waypoints of the mutators. Those of the present population must stay until its last
        reading; those of the next come before ``update``.
    mutations : In(mutation_layout).array(mutators)
        With ``update``: what becomes of the children.
    update : In(1)
        Make the next population the present one: it can be addressed from the next clock on.
    lengths : Out(length_bits).array(population)
        Length of the path in each slot, mutations included.
    settled : Out(1)
        No read or write is under way, and the first waypoints have been read: 3 clocks after the
        latest of them or of ``update``.
    allow : In(1)
        Whether ``reads`` and ``writes`` are taken; low while ``on`` and until ``update``.
    writes : In(stream.Signature(write_layout))
        Waypoints for the present population.
    reads : In(stream.Signature(read_layout))
    read_waypoints : Out(stream.Signature(waypoint_layout))
        See :class:`hdl.ga_core.readout.ReadOut`. A waypoint is offered 5 clocks after a read is
        taken.
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        ports = carriers(config)
        super().__init__(
            {
                "carried": In(carrier_layout(config)).array(ports),
                "on": In(1),
                "waypoints": Out(config.waypoint_bits).array(ports),
                "position": Out(config.index_bits),
                "carrying": Out(1),
                "over": Out(1),
                "patches": In(config.waypoint_bits).array(config.patches),
                "mutations": In(mutation_layout(config)).array(config.mutators),
                "update": In(1),
                "lengths": Out(config.length_bits, init=config.MIN_WAYPOINTS).array(
                    config.population
                ),
                "settled": Out(1),
                "allow": In(1),
                "writes": In(stream.Signature(write_layout(config))),
                "reads": In(stream.Signature(read_layout(config))),
                "read_waypoints": Out(stream.Signature(waypoint_layout(config))),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        kept = config.elites + config.survivors
        half = half_bits(config)

        bank = Signal()
        with m.If(self.update):
            m.d.sync += bank.eq(~bank)

        # Host writes pass through the ports too: each memory then has one writer.
        write = self.writes.p
        writing = Signal()
        written_slot = Signal(config.slot_bits)
        written_tail = Signal()
        written_at = Signal(half)
        taken = Signal()
        m.submodules.readout = readout = ReadOut(config)
        connect(m, flipped(self.reads), readout.reads)
        connect(m, readout.waypoints, flipped(self.read_waypoints))
        m.d.comb += [
            readout.allow.eq(self.allow),
            readout.length.eq(chosen(readout.slot, self.lengths)),
            readout.waypoint.eq(self.waypoints[0]),
            self.writes.ready.eq(self.allow & ~readout.active),
            taken.eq(self.writes.valid & self.writes.ready),
        ]
        m.d.sync += writing.eq(taken)
        with m.If(taken):
            m.d.sync += [
                written_slot.eq(write.slot),
                written_tail.eq(write.index >= config.head_size),
                written_at.eq(
                    Mux(
                        write.index >= config.head_size,
                        write.index - config.head_size,
                        write.index,
                    )
                ),
            ]

        # Position to be read next. At 2, that of 0 is in the slots' registers: primed.
        ahead = Signal(position_bits(config))
        rewind = Signal()
        advance = Signal()
        step = Signal()
        m.d.comb += [
            rewind.eq(self.update | writing | readout.rewind),
            readout.primed.eq(ahead >= 2),
            step.eq(self.on | readout.step),
            advance.eq(step | ~readout.primed),
            self.settled.eq((ahead == 2) & ~writing & ~readout.active),
        ]
        with m.If(rewind):
            m.d.sync += ahead.eq(0)
        with m.Elif(advance):
            m.d.sync += ahead.eq(ahead + 1)

        begun = Signal()
        m.d.sync += begun.eq(self.on)
        m.d.comb += self.carrying.eq(self.on & begun)
        with m.If(self.carrying):
            m.d.sync += self.position.eq(self.position + 1)
        with m.Else():
            m.d.sync += self.position.eq(0)

        overs = [self.position + 1 >= path.length for path in self.carried[:kept]]
        heads = []
        tails = []
        for number in range(config.crossovers):
            m.submodules[f"crossover_{number}"] = module = Crossover(config)
            m.d.comb += [module.on.eq(self.carrying), module.position.eq(self.position)]
            parents = parents_of(config, 2 * number)
            for port, parent in zip(module.parents, parents, strict=True):
                m.d.comb += [
                    port.waypoint.eq(self.waypoints[kept + parent]),
                    port.length.eq(self.carried[kept + parent].length),
                ]
            overs.append(module.over)
            heads += module.heads
            tails += module.tails
        m.d.comb += self.over.eq(self.carrying & Cat(overs).all())

        # All slots but the children's keep their paths in order: one index serves them.
        m.submodules.kept_index = kept_index = ReadIndex(config)
        m.d.comb += [
            kept_index.advance.eq(advance),
            kept_index.position.eq(ahead),
            kept_index.head.eq(config.head_size),
        ]

        ended = Signal()
        m.d.comb += ended.eq(taken & write.last)

        slots = []
        for number in range(config.population):
            m.submodules[f"slot_{number}"] = slot = Chromosome(config)
            slots.append(slot)

            rewritten = Signal(name=f"rewritten_{number}")
            m.d.comb += rewritten.eq(ended & (write.slot == number))
            with m.If(rewritten):
                m.d.sync += self.lengths[number].eq(write.index + 1)
            if number < kept:
                index = kept_index
                head, tail = self._copy(m, number)
            else:
                index = self._child(m, number - kept, rewritten)
                m.d.comb += [index.advance.eq(advance), index.position.eq(ahead)]
                head, tail = heads[number - kept], tails[number - kept]

            addressed = Signal(name=f"addressed_{number}")
            m.d.comb += [
                addressed.eq(writing & (written_slot == number)),
                slot.advance.eq(advance),
                slot.bank.eq(bank),
                slot.source.eq(index.source),
                slot.written.eq(bank ^ ~writing),
            ]
            for target, patch in zip(slot.patches, self.patches, strict=True):
                m.d.comb += target.eq(patch)
            for target, source, addressed_half in (
                (slot.head, head, ~written_tail),
                (slot.tail, tail, written_tail),
            ):
                m.d.comb += [
                    target.valid.eq(Mux(writing, addressed & addressed_half, source.valid)),
                    target.at.eq(Mux(writing, written_at, source.at)),
                    target.waypoint.eq(source.waypoint),
                ]

        for number, waypoint in enumerate(self.waypoints):
            port = Signal(config.waypoint_bits, name=f"port_{number}", reset_less=True)
            m.d.comb += waypoint.eq(port)
            selected = Signal(config.slot_bits, name=f"selected_{number}")
            m.d.comb += selected.eq(self.carried[number].slot)
            if number == 0:
                with m.If(readout.active):
                    m.d.comb += selected.eq(readout.slot)
            with m.If(taken):
                m.d.sync += port.eq(write.waypoint)
            with m.Elif(step):
                m.d.sync += port.eq(chosen(selected, [slot.waypoint for slot in slots]))

        return m

    def _copy(self, m, number):
        """Copy the path of a port to the slot of the same number."""
        config, carried = self.config, self.carried[number]

        head = half_signature(config).create(path=(f"head_{number}",))
        tail = half_signature(config).create(path=(f"tail_{number}",))
        m.d.comb += [
            head.valid.eq(
                self.carrying
                & (self.position < carried.length)
                & (self.position < config.head_size)
            ),
            head.at.eq(self.position),
            head.waypoint.eq(self.waypoints[number]),
            tail.valid.eq(
                self.carrying
                & (self.position < carried.length)
                & (self.position >= config.head_size)
            ),
            tail.at.eq(self.position - config.head_size),
            tail.waypoint.eq(self.waypoints[number]),
        ]
        with m.If(self.update):
            m.d.sync += self.lengths[number].eq(carried.length)
        return head, tail

    def _child(self, m, child, rewritten):
        """Keep the length, the middle and the pending mutation of a child; return its index."""
        config = self.config
        kept = config.elites + config.survivors
        mutations = list(zip(config.mutations, self.mutations, strict=True))
        head_parent, tail_parent = (
            self.carried[kept + parent].length for parent in parents_of(config, child)
        )

        # At most one mutator works on a child.
        bred = Signal(pending_layout(config), name=f"bred_{child}")
        hits = Signal(config.mutators, name=f"hits_{child}")
        for number, (kind, mutation) in enumerate(mutations):
            m.d.comb += hits[number].eq(mutation.applied & (mutation.child == child))
            with m.If(hits[number]):
                m.d.comb += [
                    bred[kind.name.lower()].eq(1),
                    bred.at.eq(mutation.index),
                ]
                if kind is not MutationKind.DELETE:
                    m.d.comb += bred.patch.eq(number)

        head = Signal(
            range(config.head_size + 1),
            init=config.head_size,
            name=f"middle_{child}",
        )
        pending = Signal(pending_layout(config), name=f"pending_{child}")
        length = self.lengths[kept + child]
        with m.If(self.update):
            m.d.sync += [
                head.eq(head_parent >> 1),
                length.eq(
                    (head_parent >> 1) + ((tail_parent + 1) >> 1) + bred.insert - bred.delete
                ),
                pending.eq(bred),
            ]
        with m.Elif(rewritten):
            m.d.sync += [
                head.eq(config.head_size),
                pending.eq(0),
            ]

        m.submodules[f"index_{child}"] = index = ReadIndex(config)
        m.d.comb += [index.head.eq(head), index.pending.eq(pending)]
        return index

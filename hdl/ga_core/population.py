"""The population: all chromosomes, read in lock step, and its update in one clock."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out, connect, flipped

from hdl.config import CheckerBuild, Config, MutationKind
from hdl.ga_core.chromosome import (
    Chromosome,
    ReadIndex,
    half_signature,
    pending_layout,
    place_shape,
)
from hdl.ga_core.crossover import Crossover, parents_of
from hdl.ga_core.layouts import mutation_layout
from hdl.ga_core.path_reader import PathReader
from hdl.ga_core.position_counter import PositionCounter
from hdl.ga_core.read_crossbar import ReadCrossbar
from hdl.ga_core.read_pointer import ReadPointer
from hdl.ga_core.slot_mapping import carrier_layout
from hdl.layouts import read_layout, waypoint_layout, write_layout
from hdl.primitives.fanout import fanout
from hdl.primitives.multiplexer import one_hot_multiplex


__all__ = ["Population"]

#: Slots that are controlled by the same registers; the population is a multiple.
_SLOTS_OF_PART = 4


class Population(wiring.Component):
    """All chromosomes, and the ports through which their waypoints pass.

    The paths are read in lock step. From ``starts`` on each port gets the next waypoint of its path
    every clock: that of ``position`` is in ``waypoints`` while ``carrying``, from the third clock
    after ``starts`` to that with ``over``. Elites and survivors are copied to the first slots as
    they pass; the crossover modules write their children to the last ones. All is written to the
    banks that are not read; ``update`` swaps the banks in one clock (*allaire-2008*, section 4.4).
    The first waypoints are read ahead, so that no clock is lost.

    After reset every path has two waypoints, which are 0 when the chip has been configured.

    Source: *allaire-2008*, section 4.4. Differs: the children are in their slots already when the
    others are, so that the update is a change of bank.

    Parameters
    ----------
    config : Config

    Members
    -------
    carried : In(carrier_layout).array(carriers)
        Slot and length of the path of each port: elites, survivors, parents. Steady from a clock
        before the crossover begins, and while ``peek``.
    starts : In(1)
        Pulse: the crossover begins with the second clock after it. Only while ``settled``.
    waypoints : Out(waypoint_bits).array(carriers)
    position : Out(index_bits)
    carrying : Out(1)
    over : Out(1)
        In the last clock of the crossover: that after the last waypoint of the longest path.
    patches : In(waypoint_bits).array(patches)
        New waypoints of the mutators. Those of the present population must stay until its last
        reading; those of the next come before ``update``.
    mutations : In(mutation_layout).array(mutators)
        In the clock before ``update``: what becomes of the children.
    update : In(1)
        Make the next population the present one: it can be addressed from the next clock on.
    lengths : Out(length_bits).array(population)
        Length of the path in each slot, mutations included.
    settled : Out(1)
        No read or write is under way, and the first waypoints have been read: at most 4 clocks
        after the latest of them or of ``update``. Means nothing from ``starts`` to ``update``.
    allow : In(1)
        Whether ``reads`` and ``writes`` are taken; low from the clock after ``starts`` to
        ``update``.
    writes : In(stream.Signature(write_layout))
        Waypoints for the present population.
    reads : In(stream.Signature(read_layout))
    read_waypoints : Out(stream.Signature(waypoint_layout))
        See :class:`hdl.ga_core.path_reader.PathReader`. A waypoint is offered 5 clocks after a read
        is taken.
    peeks : In(1)
        Only with a map: ``peek`` may come. No read is taken meanwhile, nor for 3 clocks after the
        last one.
    peek : In(1)
        Only while ``peeks``: pass the waypoints at ``peek_position``, which are in ``waypoints``
        :data:`hdl.ga_core.read_pointer.PEEK_LATENCY` clocks later. May rise only while ``settled``,
        and stays for all positions that are wanted; 6 clocks after the last of them the population
        is ``settled`` again.
    peek_position : In(index_bits)
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        ports = config.elites + config.survivors + config.crossovers
        carrier = carrier_layout(config.population, config.max_waypoints)
        mutation = mutation_layout(config.children, config.max_waypoints)
        peeks = {"peeks": In(1), "peek": In(1), "peek_position": In(config.index_bits)}
        super().__init__(
            {
                "carried": In(carrier).array(ports),
                "launch": In(1),
                "waypoints": Out(config.waypoint_bits).array(ports),
                "position": Out(config.index_bits),
                "carrying": Out(1),
                "done": Out(1),
                "patches": In(config.waypoint_bits).array(config.patches),
                "mutations": In(mutation).array(config.mutators),
                "update": In(1),
                "lengths": Out(config.length_bits, init=config.MIN_WAYPOINTS).array(
                    config.population
                ),
                "settled": Out(1),
                "allow": In(1),
                "writes": In(
                    stream.Signature(
                        write_layout(config.slot_bits, config.index_bits, config.waypoint_bits)
                    )
                ),
                "reads": In(stream.Signature(read_layout(config.slot_bits))),
                "read_waypoints": Out(stream.Signature(waypoint_layout(config.waypoint_bits))),
                **(peeks if config.checker is not CheckerBuild.NONE else {}),
            }
        )

    def elaborate(self, platform):
        m = Module()
        config = self.config
        kept = config.elites + config.survivors
        ports = len(self.carried)

        # Slots that share a copy of what all of them need.
        parts = config.population // _SLOTS_OF_PART
        bank = Signal()
        banks = fanout(m, *[bank ^ self.update] * parts, name="bank")
        m.d.comb += bank.eq(banks[0])
        begin, *begins = fanout(m, *[self.launch] * (1 + parts), name="begin")

        # Host writes pass through the ports too: each memory then has one writer. What reaches all
        # slots comes from registers, here and below: so long a wire leaves no time for more.
        write = self.writes.p
        written = Signal(write.shape(), reset_less=True)
        addressed = Signal(config.population, reset_less=True)
        written_length = Signal(config.length_bits, reset_less=True)
        written_tail = Signal()
        closing = Signal()  # The waypoint that is written ends its path.
        written_at = Signal(place_shape(config.max_waypoints))
        taken = Signal()
        read_slot = Signal(config.population, reset_less=True)
        read_length = Signal(config.length_bits, reset_less=True)
        peeks = Signal()
        m.submodules.read_pointer = pointer = ReadPointer(
            max_waypoints=config.max_waypoints,
            parts=parts,
            peeks=config.checker is not CheckerBuild.NONE,
        )
        m.submodules.path_reader = reader = PathReader(
            slot_bits=config.slot_bits,
            waypoint_bits=config.waypoint_bits,
            max_waypoints=config.max_waypoints,
        )
        connect(m, flipped(self.reads), reader.reads)
        connect(m, reader.waypoints, flipped(self.read_waypoints))
        m.d.sync += [
            read_slot.eq(1 << reader.slot),
            read_length.eq(one_hot_multiplex(read_slot, self.lengths)),
        ]
        m.d.comb += [
            reader.allow.eq(self.allow & ~peeks),
            reader.length.eq(read_length),
            reader.waypoint.eq(self.waypoints[0]),
            self.writes.ready.eq(self.allow & ~reader.active),
            taken.eq(self.writes.valid & self.writes.ready),
        ]
        writing, *writings = fanout(
            m, *[taken] * (1 + ReadCrossbar.parts_of(ports)), name="writing"
        )
        m.d.sync += [
            closing.eq(taken & write.last),
            addressed.eq(1 << write.slot),
            written.eq(write),
            written_length.eq(write.index + 1),
            written_tail.eq(write.index >= config.head_size),
            written_at.eq(
                Mux(
                    write.index >= config.head_size,
                    write.index - config.head_size,
                    write.index,
                )
            ),
        ]

        m.d.comb += [
            pointer.taken.eq(taken),
            pointer.writing.eq(writing),
            pointer.update.eq(self.update),
            pointer.rewinds.eq(reader.rewind),
            reader.primes.eq(pointer.primes),
            self.settled.eq(pointer.primed & ~reader.active),
        ]
        if config.checker is not CheckerBuild.NONE:
            m.d.comb += [
                peeks.eq(self.peeks | pointer.peeking),
                pointer.peek.eq(self.peek),
                pointer.peek_position.eq(self.peek_position),
            ]

        m.submodules.position_counter = counter = PositionCounter(
            ports=ports, max_waypoints=config.max_waypoints
        )
        running, following = counter.running, counter.following
        m.d.comb += [
            counter.begin.eq(begin),
            *(
                target.eq(path.length)
                for target, path in zip(counter.lengths, self.carried, strict=True)
            ),
            self.carrying.eq(counter.carrying),
            self.position.eq(counter.position),
            self.done.eq(counter.done),
            pointer.passes.eq(counter.goes_on | reader.steps),
            *(target.eq(copy) for target, copy in zip(pointer.begin, begins, strict=True)),
        ]

        heads = []
        tails = []
        for number in range(config.crossovers):
            m.submodules[f"crossover_{number}"] = module = Crossover(
                config.waypoint_bits, config.max_waypoints
            )
            m.d.comb += [module.on.eq(running), module.position.eq(following)]
            parents = parents_of(2 * number, config.crossovers)
            for port, parent in zip(module.parents, parents, strict=True):
                m.d.comb += [
                    port.waypoint.eq(self.waypoints[kept + parent]),
                    port.length.eq(self.carried[kept + parent].length),
                ]
            heads += module.heads
            tails += module.tails

        # All slots but the children's keep their paths in order: one index serves them.
        m.submodules.kept_index = kept_index = ReadIndex(
            max_waypoints=config.max_waypoints, patch_count=config.patches
        )
        m.d.comb += [
            kept_index.advance.eq(pointer.advance[0]),
            kept_index.position.eq(pointer.ahead),
            kept_index.head.eq(config.head_size),
        ]

        # What becomes of the children is known a clock before the update.
        indices = []
        for number, mutation in enumerate(self.mutations):
            index = Signal(config.index_bits, name=f"index_of_{number}", reset_less=True)
            m.d.sync += index.eq(mutation.index)
            indices.append(index)

        written_banks = fanout(m, *[bank ^ ~writing] * parts, name="written_bank")

        slots = []
        for number in range(config.population):
            m.submodules[f"slot_{number}"] = slot = Chromosome(
                waypoint_bits=config.waypoint_bits,
                max_waypoints=config.max_waypoints,
                patch_count=config.patches,
            )
            slots.append(slot)
            part = number // _SLOTS_OF_PART
            advance = pointer.advance[part]

            rewritten = Signal(name=f"rewritten_{number}")
            m.d.comb += rewritten.eq(closing & addressed[number])
            with m.If(rewritten):
                m.d.sync += self.lengths[number].eq(written_length)
            if number < kept:
                index = kept_index
                head, tail = self._copy(m, number, running, following)
            else:
                index = self._child(m, number - kept, rewritten, indices)
                m.d.comb += [index.advance.eq(advance), index.position.eq(pointer.ahead)]
                head, tail = heads[number - kept], tails[number - kept]

            m.d.comb += [
                slot.advance.eq(advance),
                slot.bank.eq(banks[part]),
                slot.source.eq(index.source),
                slot.written.eq(written_banks[part]),
            ]
            for target, patch in zip(slot.patches, self.patches, strict=True):
                m.d.comb += target.eq(patch)
            for target, source, addressed_half in (
                (slot.head, head, ~written_tail),
                (slot.tail, tail, written_tail),
            ):
                m.d.comb += target.waypoint.eq(source.waypoint)
                m.d.sync += [
                    target.valid.eq(Mux(writing, addressed[number] & addressed_half, source.valid)),
                    target.at.eq(Mux(writing, written_at, source.at)),
                ]

        # Only the first port, from which the host reads, has to hold a waypoint.
        m.submodules.crossbar = crossbar = ReadCrossbar(
            ports=ports, population=config.population, waypoint_bits=config.waypoint_bits
        )
        m.d.comb += [
            crossbar.step.eq(pointer.step),
            *(target.eq(copy) for target, copy in zip(crossbar.writing, writings, strict=True)),
            crossbar.written.eq(written.waypoint),
            *(
                target.eq(path.select)
                for target, path in zip(crossbar.selects, self.carried, strict=True)
            ),
            *(target.eq(slot.waypoint) for target, slot in zip(crossbar.slots, slots, strict=True)),
            *(
                target.eq(port)
                for target, port in zip(self.waypoints, crossbar.waypoints, strict=True)
            ),
        ]
        with m.If(reader.active):
            m.d.comb += crossbar.selects[0].eq(read_slot)

        return m

    def _copy(self, m, number, running, following):
        """Copy the path of a port to the slot of the same number.

        Whether and where to write is that of the next clock's waypoint.
        """
        config, carried = self.config, self.carried[number]

        half = half_signature(config.waypoint_bits, config.max_waypoints)
        head = half.create(path=(f"head_{number}",))
        tail = half.create(path=(f"tail_{number}",))
        inside = Signal(name=f"inside_{number}")
        m.d.comb += [
            inside.eq(running & (following < carried.length)),
            head.valid.eq(inside & (following < config.head_size)),
            head.at.eq(following),
            head.waypoint.eq(self.waypoints[number]),
            tail.valid.eq(inside & (following >= config.head_size)),
            tail.at.eq(following - config.head_size),
            tail.waypoint.eq(self.waypoints[number]),
        ]
        with m.If(self.update):
            m.d.sync += self.lengths[number].eq(carried.length)
        return head, tail

    def _child(self, m, child, rewritten, indices):
        """Keep the length, the middle and the pending mutation of a child; return its index."""
        config = self.config
        kept = config.elites + config.survivors
        head_parent, tail_parent = (
            self.carried[kept + parent].length for parent in parents_of(child, config.crossovers)
        )

        # At most one mutator works on a child.
        bred = Signal(pending_layout(config.max_waypoints, config.patches), name=f"bred_{child}")
        hits = Signal(config.mutators, name=f"hits_{child}", reset_less=True)
        patches = [C(number, len(bred.patch)) for number in range(config.patches)]
        m.d.sync += hits.eq(Cat(each.applied & (each.child == child) for each in self.mutations))
        m.d.comb += [
            bred.at.eq(one_hot_multiplex(hits, indices)),
            bred.patch.eq(one_hot_multiplex(hits[: config.patches], patches)),
        ]
        for kind in MutationKind:
            of_kind = Cat(hit for hit, of in zip(hits, config.mutations, strict=True) if of is kind)
            m.d.comb += bred[kind.name.lower()].eq(of_kind.any())

        head = Signal(
            range(config.head_size + 1),
            init=config.head_size,
            name=f"middle_{child}",
        )
        pending = Signal(
            pending_layout(config.max_waypoints, config.patches), name=f"pending_{child}"
        )
        joined = Signal(config.length_bits, name=f"joined_{child}", reset_less=True)
        m.d.sync += joined.eq((head_parent >> 1) + ((tail_parent + 1) >> 1))
        length = self.lengths[kept + child]
        with m.If(self.update):
            m.d.sync += [
                head.eq(head_parent >> 1),
                # One less is all ones more.
                length.eq(joined + (bred.insert | bred.delete.replicate(len(length)))),
                pending.eq(bred),
            ]
        with m.Elif(rewritten):
            m.d.sync += [
                head.eq(config.head_size),
                *(pending[kind.name.lower()].eq(0) for kind in MutationKind),
            ]

        m.submodules[f"index_{child}"] = index = ReadIndex(
            max_waypoints=config.max_waypoints, patch_count=config.patches
        )
        m.d.comb += [index.head.eq(head), index.pending.eq(pending)]
        return index

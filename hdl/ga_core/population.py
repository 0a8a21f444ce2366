"""The population: all chromosomes, which are read in lockstep and updated in one cycle."""

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out, connect, flipped

from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.ga_core.chromosome import ChildIndex, Chromosome, ReadIndex
from pathgene.hdl.ga_core.crossover import Crossover, parents_of
from pathgene.hdl.ga_core.layouts import mutation_layout
from pathgene.hdl.ga_core.read_ports import PathReader, PositionCounter, ReadCrossbar, ReadPointer
from pathgene.hdl.ga_core.slot_mapping import carrier_layout
from pathgene.hdl.ga_core.write_ports import PathCopier, WriteDecoder
from pathgene.hdl.layouts import read_layout, waypoint_layout, write_layout
from pathgene.hdl.primitives.logic import assign_each, fanout, one_hot_multiplex
from pathgene.hdl.primitives.unit import InstanceOf, Unit


__all__ = ["Population"]

#: Number of slots controlled by the same registers. The population is a multiple of it.
_SLOTS_OF_PART = 4


class Population(Unit):
    """All chromosomes, and the ports through which their waypoints pass.

    The paths are read in lockstep. After ``launch``, each port gets the next waypoint of its path
    in every cycle: ``waypoints`` are the waypoints at ``position`` while ``carrying``, from the
    third cycle after ``launch`` to the cycle of ``done``. Elites and survivors are copied to the
    first slots while they pass; the crossover modules write their children to the last slots. All
    writes go to the banks that are not being read; ``update`` swaps the banks in one cycle
    (*allaire-2008*, section 4.4). The first waypoints are read ahead, so that no cycle is lost.

    After reset every path has two waypoints, which are 0 after configuration of the chip.

    Source: *allaire-2008*, section 4.4. Difference: children are written to their slots while
    elites and survivors are copied, so that the update only swaps banks.

    Members
    -------
    carried : In(carrier_layout).array(ports)
        Slot and length of the path of each port: elites, survivors, parents. Steady from the cycle
        before the crossover begins, and while ``peek``.
    launch : In(1)
        Pulse: the crossover begins in the second cycle after it. Only while ``settled``.
    waypoints : Out(waypoint_bits).array(ports)
    position : Out(index_bits)
    carrying : Out(1)
    done : Out(1)
        Last cycle of the crossover: the last waypoint of the longest path passes.
    patches : In(waypoint_bits).array(patches)
        New waypoints of the mutators. They stay until the current population is last read; new
        waypoints of the next population arrive before ``update``.
    mutations : In(mutation_layout).array(mutators)
        In the cycle before ``update``: work of each mutator.
    update : In(1)
        Make the next population the current one, which can be addressed from the next cycle on.
    lengths : Out(length_bits).array(population)
        Length of the path in each slot, including mutations.
    settled : Out(1)
        No read or write is in flight, and the first waypoints have been read: at most 4 cycles
        after the latest read, write or ``update``. Undefined from ``launch`` to ``update``.
    allow : In(1)
        ``reads`` and ``writes`` are accepted. Low from the cycle after ``launch`` to ``update``.
    writes : In(stream.Signature(write_layout))
        Waypoints for the current population.
    reads : In(stream.Signature(read_layout))
    read_waypoints : Out(stream.Signature(waypoint_layout))
        See :class:`pathgene.hdl.ga_core.read_ports.PathReader`. A waypoint is offered 5 cycles
        after a read is accepted.
    peeks : In(1)
        Only with a map: ``peek`` may be raised. No read is accepted while this is high, nor for 3
        cycles after the last peek.
    peek : In(1)
        Only while ``peeks``: pass the waypoints at ``peek_position``, which appear in ``waypoints``
        :data:`pathgene.hdl.ga_core.read_ports.PEEK_LATENCY` cycles later. May rise only while
        ``settled``, and stays high for all positions; the population is ``settled`` again 6 cycles
        after the last.
    peek_position : In(index_bits)
    """

    config: InstanceOf(Config)

    def interface(self):
        config = self.config
        self.kept = config.elites + config.survivors
        self.peeks_ahead = config.checker is not CheckerBuild.NONE
        ports = self.kept + config.crossovers
        carrier = carrier_layout(config.population, config.max_waypoints)
        mutation = mutation_layout(config.children, config.max_waypoints)
        peeks = {"peeks": In(1), "peek": In(1), "peek_position": In(config.index_bits)}
        return {
            "carried": In(carrier).array(ports),
            "launch": In(1),
            "waypoints": Out(config.waypoint_bits).array(ports),
            "position": Out(config.index_bits),
            "carrying": Out(1),
            "done": Out(1),
            "patches": In(config.waypoint_bits).array(config.patches),
            "mutations": In(mutation).array(config.mutators),
            "update": In(1),
            "lengths": Out(config.length_bits, init=config.MIN_WAYPOINTS).array(config.population),
            "settled": Out(1),
            "allow": In(1),
            "writes": In(
                stream.Signature(
                    write_layout(config.slot_bits, config.index_bits, config.waypoint_bits)
                )
            ),
            "reads": In(stream.Signature(read_layout(config.slot_bits))),
            "read_waypoints": Out(stream.Signature(waypoint_layout(config.waypoint_bits))),
            **(peeks if self.peeks_ahead else {}),
        }

    def elaborate(self, platform):
        m = Module()
        config = self.config
        ports = len(self.carried)
        parts = config.population // _SLOTS_OF_PART

        # Host writes go through the ports too, so that each memory has one writer. Every signal
        # that reaches all slots comes from a register, because such long wires leave no time for
        # logic.
        m.submodules.write_decoder = decoder = WriteDecoder(
            population=config.population,
            waypoint_bits=config.waypoint_bits,
            max_waypoints=config.max_waypoints,
            parts=1 + ReadCrossbar.parts_of(ports),
        )
        m.submodules.path_reader = reader = PathReader(
            slot_bits=config.slot_bits,
            waypoint_bits=config.waypoint_bits,
            max_waypoints=config.max_waypoints,
        )
        m.submodules.read_pointer = pointer = ReadPointer(
            max_waypoints=config.max_waypoints, parts=parts, peeks=self.peeks_ahead
        )
        m.submodules.position_counter = counter = PositionCounter(
            ports=ports, max_waypoints=config.max_waypoints
        )
        m.submodules.crossbar = crossbar = ReadCrossbar(
            ports=ports, population=config.population, waypoint_bits=config.waypoint_bits
        )
        connect(m, flipped(self.writes), decoder.writes)
        m.d.comb += [
            decoder.allow.eq(self.allow & ~reader.active),
            self.settled.eq(pointer.primed & ~reader.active),
        ]

        begin, *begins = fanout(m, *[self.launch] * (1 + parts), name="begin")
        m.d.comb += [
            counter.begin.eq(begin),
            assign_each(counter.lengths, (path.length for path in self.carried)),
            self.carrying.eq(counter.carrying),
            self.position.eq(counter.position),
            self.done.eq(counter.done),
            pointer.taken.eq(decoder.taken),
            pointer.writing.eq(decoder.writing[0]),
            pointer.update.eq(self.update),
            pointer.rewinds.eq(reader.rewind),
            assign_each(pointer.begin, begins),
            pointer.passes.eq(counter.goes_on | reader.steps),
        ]
        if self.peeks_ahead:
            m.d.comb += [
                pointer.peek.eq(self.peek),
                pointer.peek_position.eq(self.peek_position),
            ]

        # Only the first port, which the host reads, must hold a waypoint.
        m.d.comb += [
            crossbar.step.eq(pointer.step),
            assign_each(crossbar.writing, decoder.writing[1:]),
            crossbar.written.eq(decoder.waypoint),
            assign_each(crossbar.selects, (path.select for path in self.carried)),
            assign_each(self.waypoints, crossbar.waypoints),
        ]
        self._read(m, reader, pointer, crossbar)

        # Signals that all slots need have a register for each group of slots.
        bank = Signal()
        banks = fanout(m, *[bank ^ self.update] * parts, name="bank")
        m.d.comb += bank.eq(banks[0])
        written_banks = fanout(m, *[bank ^ ~decoder.writing[0]] * parts, name="written_bank")
        sources = [
            *self._copy(m, decoder, pointer, counter),
            *self._breed(m, decoder, pointer, counter),
        ]
        for number, (source, head, tail) in enumerate(sources):
            part = number // _SLOTS_OF_PART
            m.submodules[f"slot_{number}"] = slot = Chromosome(
                waypoint_bits=config.waypoint_bits,
                max_waypoints=config.max_waypoints,
                patch_count=config.patches,
            )
            m.d.comb += [
                slot.advance.eq(pointer.advance[part]),
                slot.bank.eq(banks[part]),
                slot.source.eq(source),
                assign_each(slot.patches, self.patches),
                slot.written.eq(written_banks[part]),
                crossbar.slots[number].eq(slot.waypoint),
            ]
            for half, write, addressed in (
                (slot.head, head, ~decoder.in_tail),
                (slot.tail, tail, decoder.in_tail),
            ):
                m.d.comb += half.waypoint.eq(write.waypoint)
                m.d.sync += [
                    half.valid.eq(
                        Mux(decoder.writing[0], decoder.slots[number] & addressed, write.valid)
                    ),
                    half.at.eq(Mux(decoder.writing[0], decoder.at, write.at)),
                ]

        return m

    def _read(self, m, reader, pointer, crossbar):
        """Add reading of slots by the host, through the first port."""
        slot = Signal(self.config.population, name="read_slot", reset_less=True)
        length = Signal(self.config.length_bits, name="read_length", reset_less=True)
        peeks = Signal()
        if self.peeks_ahead:
            m.d.comb += peeks.eq(self.peeks | pointer.peeking)
        connect(m, flipped(self.reads), reader.reads)
        connect(m, reader.waypoints, flipped(self.read_waypoints))
        m.d.sync += [
            slot.eq(1 << reader.slot),
            length.eq(one_hot_multiplex(slot, self.lengths)),
        ]
        m.d.comb += [
            reader.allow.eq(self.allow & ~peeks),
            reader.length.eq(length),
            reader.primes.eq(pointer.primes),
            reader.waypoint.eq(self.waypoints[0]),
        ]
        with m.If(reader.active):
            m.d.comb += crossbar.selects[0].eq(slot)

    def _copy(self, m, decoder, pointer, counter):
        """Copy elites and survivors; yield the source and the writes to the halves of each slot."""
        config = self.config

        # Their paths are stored in order, so one index serves all of them.
        m.submodules.kept_index = index = ReadIndex(
            max_waypoints=config.max_waypoints, patch_count=config.patches
        )
        m.d.comb += [
            index.advance.eq(pointer.advance[0]),
            index.position.eq(pointer.ahead),
            index.head.eq(config.head_size),
        ]
        for number in range(self.kept):
            m.submodules[f"copier_{number}"] = copier = PathCopier(
                config.waypoint_bits, config.max_waypoints
            )
            m.d.comb += [
                copier.on.eq(counter.running),
                copier.position.eq(counter.following),
                copier.length.eq(self.carried[number].length),
                copier.waypoint.eq(self.waypoints[number]),
            ]
            with m.If(decoder.completed[number]):
                m.d.sync += self.lengths[number].eq(decoder.length)
            with m.If(self.update):
                m.d.sync += self.lengths[number].eq(self.carried[number].length)
            yield index.source, copier.head, copier.tail

    def _breed(self, m, decoder, pointer, counter):
        """Breed children; yield the source and the writes to the halves of each slot."""
        config = self.config
        parents = self.carried[self.kept :]

        heads = []
        tails = []
        for number in range(config.crossovers):
            m.submodules[f"crossover_{number}"] = module = Crossover(
                config.waypoint_bits, config.max_waypoints
            )
            m.d.comb += [module.on.eq(counter.running), module.position.eq(counter.following)]
            for port, parent in zip(
                module.parents, parents_of(2 * number, config.crossovers), strict=True
            ):
                m.d.comb += [
                    port.waypoint.eq(self.waypoints[self.kept + parent]),
                    port.length.eq(parents[parent].length),
                ]
            heads += module.heads
            tails += module.tails

        # The mutations are known in the cycle before the update.
        indices = []
        for number, mutation in enumerate(self.mutations):
            index = Signal(config.index_bits, name=f"index_of_{number}", reset_less=True)
            m.d.sync += index.eq(mutation.index)
            indices.append(index)

        for child, (head, tail) in enumerate(zip(heads, tails, strict=True)):
            number = self.kept + child
            m.submodules[f"index_{child}"] = index = ChildIndex(
                config.mutations,
                min_waypoints=config.MIN_WAYPOINTS,
                max_waypoints=config.max_waypoints,
            )
            first, second = parents_of(child, config.crossovers)
            m.d.comb += [
                index.advance.eq(pointer.advance[number // _SLOTS_OF_PART]),
                index.position.eq(pointer.ahead),
                index.bred_head.eq(parents[first].length >> 1),
                index.bred_length.eq(
                    (parents[first].length >> 1) + ((parents[second].length + 1) >> 1)
                ),
                index.applied.eq(
                    Cat(each.applied & (each.child == child) for each in self.mutations)
                ),
                assign_each(index.indices, indices),
                index.update.eq(self.update),
                index.rewrite.eq(decoder.completed[number]),
                index.rewritten_length.eq(decoder.length),
                self.lengths[number].eq(index.length),
            ]
            yield index.source, head, tail

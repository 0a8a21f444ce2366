"""The detailed map in banks, with comparators for the cells of the lanes."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from pathgene.hdl.primitives.logic import delay_line, multiplex
from pathgene.hdl.primitives.storage import MapMemory
from pathgene.hdl.primitives.unit import Count, Flag, PowerOfTwo, Unit, Width


__all__ = ["TerrainMemory", "lane_layout", "lane_row_bits"]


def lane_row_bits(lanes: int, coordinate_bits: int) -> int:
    """Return the width of a major coordinate divided by ``lanes``; 1 if that is always 0."""
    return max(1, coordinate_bits - exact_log2(lanes))


def lane_layout(lanes: int, coordinate_bits: int, altitude_bits: int) -> data.StructLayout:
    """Return the layout of the cell of one lane.

    ``valid`` (there is a cell), ``row`` (its major coordinate divided by the number of lanes; the
    remainder is the number of the lane), ``minor`` (its other coordinate), and ``ceiling``: the
    cell collides if the ground is at this altitude or above; with half steps, only if it is above.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "row": lane_row_bits(lanes, coordinate_bits),
            "minor": coordinate_bits,
            "ceiling": altitude_bits,
        }
    )


class TerrainMemory(Unit):
    """Map in which each lane tests a cell in every cycle.

    Cell (x, y) lies in bank (x mod B, y mod B), with B = ``bank_edge``. Lane c has cells whose
    coordinate along the major axis of the segment is congruent to c mod ``lane_count``. In a cycle,
    the first B lanes use the first port of the banks, each in a different column of banks (or row,
    if the segment is steep), and the last B lanes use the second port in the same way. Lanes never
    wait for each other, and each bank port serves one of two lanes.

    A bank compares its data with the altitude of the lane that reads it, if any. The latency from a
    cell to ``hits`` is ``memory_latency + 3``: bank, address, comparison, and gathering of each
    lane's banks. Without comparators, the lanes get the ground itself with the same latency: first
    along each axis from the banks that the lane may read, then from the selected axis. In this case
    a row of neighbours, one cell per lane, can be looked up instead of single cells.

    The banks are spread over the device; the block RAMs of a bank lie side by side if the
    platform's cells assign sites (:class:`pathgene.hdl.primitives.storage.BlockMemory`). Each bank
    has registers for its addresses, with only wires from them to its block RAMs.

    Source: *allaire two-tier*, section 5.3.

    Attributes
    ----------
    bank_edge : int
        Banks along x and along y.

    Members
    -------
    steep : In(1)
        High if the major axis is y, low if it is x.
    lanes : In(lane_layout).array(lane_count)
    walking : In(1)
        The lanes have cells, and writes and look-ups do not reach the memory.
    hits : Out(lane_count)
        With ``compare``: lanes whose cell collides.
    blocked : Out(lane_count)
        With ``compare``: lanes whose cell has the top altitude and therefore also collides.
    grounds : Out(altitude_bits).array(lane_count)
        Without ``compare``: altitudes of the lanes' cells or of the row's cells.
    row_x : In(lane_row_bits(lane_count, coordinate_bits))
    row_y : In(coordinate_bits)
        Without ``compare``: row of cells to be looked up while not ``walking``, and not in the
        cycle of a write. Lane c has cell (``row_x * lane_count + c``, ``row_y``).
    write_enable : In(1)
    write_x, write_y : In(coordinate_bits)
    write_altitude : In(altitude_bits)
        Cell to be written; reads see it from the next cycle on.
    lookup_valid : In(1)
    lookup_x, lookup_y : In(coordinate_bits)
        With ``compare``: cell to be looked up; not in the cycle of a write.
    lookup_altitude : Out(altitude_bits)
        Its altitude, ``memory_latency + 2`` cycles later, through one small multiplexer after
        registers. Writes and look-ups reach the memory one cycle after they are given.
    """

    lane_count: PowerOfTwo(1, "1 << coordinate_bits", "Cells compared in a cycle.", name="Lanes")
    coordinate_bits: Width(1, text="The map has two to their power cells along each edge.")
    altitude_bits: Width(1, text="The top value marks ground that no path may cross.")
    memory_latency: Count(1, 2, "Cycles from an address to its data.")
    compare: Flag(
        "The banks compare; else ``grounds`` takes the place of ``hits`` and ``blocked``."
    ) = True

    def interface(self):
        self.bank_edge = max(1, self.lane_count // 2)
        lane = lane_layout(self.lane_count, self.coordinate_bits, self.altitude_bits)
        xy, z = self.coordinate_bits, self.altitude_bits
        lookup = {
            "lookup_valid": In(1),
            "lookup_x": In(xy),
            "lookup_y": In(xy),
            "lookup_altitude": Out(z),
        }
        row = {"row_x": In(lane_row_bits(self.lane_count, xy)), "row_y": In(xy)}
        compared = {"hits": Out(self.lane_count), "blocked": Out(self.lane_count)}
        given = {"grounds": Out(z).array(self.lane_count)}
        return {
            "steep": In(1),
            "lanes": In(lane).array(self.lane_count),
            "walking": In(1),
            **(compared if self.compare else given),
            "write_enable": In(1),
            "write_x": In(xy),
            "write_y": In(xy),
            "write_altitude": In(z),
            **(lookup if self.compare else row),
        }

    def elaborate(self, platform):
        m = Module()
        latency, top = self.memory_latency, (1 << self.altitude_bits) - 1
        edge, ports = self.bank_edge, min(2, self.lane_count)
        bank_bits = exact_log2(edge)
        row_bits = self.coordinate_bits - bank_bits
        answer = latency + 1  # Cycles from a cell to its ground.

        # Writes and look-ups pass one register, at the banks.
        if self.compare:
            asked_x = Mux(self.lookup_valid, self.lookup_x, self.write_x)
            asked_y = Mux(self.lookup_valid, self.lookup_y, self.write_y)
        else:
            # x of a port's first cell in the row; its further cells have the same place in their
            # banks.
            firsts = [
                Cat(Const(port * edge, exact_log2(self.lane_count)), self.row_x)
                for port in range(ports)
            ]
            firsts = [first[: self.coordinate_bits] for first in firsts]
            asked_x = Mux(self.write_enable, self.write_x, firsts[0])
            asked_y = Mux(self.write_enable, self.write_y, self.row_y)
        access = Cat(asked_x[bank_bits:], asked_y[bank_bits:])

        # Each lane's row in its bank, and its side of the comparison, in time for the last register
        # before the comparison, which is at the bank.
        across, along, ceilings, valids = [], [], [], []
        for number, lane in enumerate(self.lanes):
            major = Cat(Const(number, exact_log2(self.lane_count)), lane.row)[bank_bits:][:row_bits]
            minor = lane.minor[bank_bits:]
            across.append(Cat(major, minor))
            along.append(Cat(minor, major))
            ceilings.append(delay_line(m, lane.ceiling, answer - 1, f"ceiling_{number}"))
            valids.append(delay_line(m, lane.valid, 1, f"valid_{number}"))
        steep = [self.steep]
        for cycle in range(1, answer + 2):
            steep.append(delay_line(m, steep[-1], 1, f"steep_{cycle}"))

        # Outputs of the bank in column x and row y: data of the first port, and the comparisons of
        # both ports, which are 0 if no lane reads there.
        ground = [[None] * edge for _ in range(edge)]
        found = [[[None] * edge for _ in range(edge)] for _ in range(ports)]
        hits, tops = ([[[None] * edge for _ in range(edge)] for _ in range(ports)] for _ in "ht")
        for x in range(edge):
            for y in range(edge):
                m.submodules[f"bank_{x}_{y}"] = bank = MapMemory(
                    rows=max(2, 1 << 2 * row_bits),
                    width=self.altitude_bits,
                    latency=latency,
                    ports=ports,
                    number=x * edge + y,
                )
                written_here = Signal(name=f"written_{x}_{y}")
                written = Signal(self.altitude_bits, name=f"altitude_{x}_{y}", reset_less=True)
                is_here = (self.write_x[:bank_bits] == x) & (self.write_y[:bank_bits] == y)
                m.d.sync += written_here.eq(self.write_enable & is_here)
                # A register near each bank.
                with m.If(is_here):
                    m.d.sync += written.eq(self.write_altitude)
                m.d.comb += [bank.a.write_enable.eq(written_here), bank.a.write_data.eq(written)]
                for port, member in enumerate([bank.a, bank.b] if ports == 2 else [bank.a]):
                    by_x, by_y = port * edge + x, port * edge + y
                    address = Mux(self.steep, along[by_y], across[by_x])
                    if port == 0:
                        address = Mux(self.walking, address, access)
                        ground[x][y] = member.data
                    elif not self.compare:
                        rows = Cat(firsts[1][bank_bits:], self.row_y[bank_bits:])
                        address = Mux(self.walking, address, rows)
                    name = f"{x}_{y}_{port}"
                    m.d.comb += member.address.eq(delay_line(m, address, 1, f"row_{name}"))
                    found[port][x][y] = member.data
                    if not self.compare:
                        continue

                    # Whether the selected one of the two lanes reads here.
                    would = Mux(
                        self.steep,
                        self.lanes[by_y].minor[:bank_bits] == x,
                        self.lanes[by_x].minor[:bank_bits] == y,
                    )
                    does = Mux(steep[1], valids[by_y], valids[by_x])
                    looks = delay_line(m, would, 1, f"would_look_{name}") & does
                    looked = delay_line(m, looks, answer - 1, f"looked_{name}")
                    ceiling = Signal(self.altitude_bits, name=f"at_{name}", reset_less=True)
                    hit = Signal(name=f"hit_{name}", reset_less=True)
                    is_top = Signal(name=f"top_{name}", reset_less=True)
                    m.d.sync += [
                        ceiling.eq(Mux(steep[answer - 1], ceilings[by_y], ceilings[by_x])),
                        hit.eq(looked & (member.data >= ceiling)),
                        is_top.eq(looked & (member.data == top)),
                    ]
                    hits[port][x][y], tops[port][x][y] = hit, is_top

        if not self.compare:
            self._give_grounds(m, found)
            return m
        for number in range(self.lane_count):
            port, column = divmod(number, edge)
            for flags, out in ((hits[port], self.hits), (tops[port], self.blocked)):
                level = Cat(flags[column]).any()
                upright = Cat(flags[x][column] for x in range(edge)).any()
                m.d.sync += out[number].eq(Mux(steep[answer + 1], upright, level))

        # The banks of a column are near each other; the column is selected in the next cycle.
        bank_x = delay_line(m, asked_x[:bank_bits], 1, "bank_x")
        bank_y = delay_line(m, asked_y[:bank_bits], 1, "bank_y")
        at_x = delay_line(m, bank_x, latency + 1, "at_x")
        at_y = delay_line(m, bank_y, latency, "at_y")
        looked_up = []
        for x, column in enumerate(ground):
            altitude = Signal(self.altitude_bits, name=f"looked_up_{x}", reset_less=True)
            m.d.sync += altitude.eq(multiplex(at_y, column))
            looked_up.append(altitude)
        m.d.comb += self.lookup_altitude.eq(multiplex(at_x, looked_up))

        return m

    def _give_grounds(self, m, found):
        """Select each lane's data from the banks' data ``found``, indexed by port, x and y."""
        edge, cycles = self.bank_edge, self.memory_latency + 1
        bank_bits = exact_log2(edge)
        # A row of cells is level.
        steep = delay_line(m, self.steep & self.walking, cycles + 1, "upright")
        for number, (lane, ground) in enumerate(zip(self.lanes, self.grounds, strict=True)):
            port, at = divmod(number, edge)
            column, row = found[port][at], [found[port][x][at] for x in range(edge)]
            minor = Mux(self.walking, lane.minor, self.row_y)[:bank_bits]
            minor = delay_line(m, minor, cycles, f"minor_{number}")
            level, upright = (
                Signal(self.altitude_bits, name=f"{name}_{number}", reset_less=True)
                for name in ("level", "upright")
            )
            m.d.sync += [
                level.eq(multiplex(minor, column)),
                upright.eq(multiplex(minor, row)),
                ground.eq(Mux(steep, upright, level)),
            ]

"""No two lanes of the parallel checker ever address the same port of the same bank."""

from amaranth import *
from amaranth.hdl import Assert, Cover

from pathgene.hdl.config import Config
from pathgene.hdl.feasibility.parallel.terrain_memory import TerrainMemory
from tests.formal.parts import Opened, free
from tools.formal import Proof


class Banks(Elaboratable):
    """Proved for all time, for 1, 2, 4, 8 and 16 lanes on a map of 32 x 32 cells.

    The proof holds for all time, because in any cycle the addresses of the banks only depend on the
    lanes in the previous cycle. ``walking`` is assumed. Lane c has a cell whose coordinate along
    the major axis is c modulo the number of lanes, as its ``row`` always implies, and any other
    coordinate; any subset of the lanes may have a cell.

    - Cell (x, y) is read in bank (x mod B, y mod B), through the first port for the first B lanes
      and through the second port for the remaining lanes, in the row of that cell, one cycle later.
    - At most one lane reads a cell in a bank through a port.
    """

    LANES = (1, 2, 4, 8, 16)

    def __init__(self, unit):
        self.unit = unit

    def elaborate(self, platform):
        m = Module()
        for lanes in self.LANES:
            config = Config(lanes=lanes, map_size=32, altitude_bits=4)
            m.submodules[f"lanes_{lanes}"] = self._build(config)
        return m

    def _build(self, config):
        m = Module()
        terrain = self.unit(TerrainMemory)(
            config.lanes, config.coordinate_bits, config.altitude_bits, config.memory_latency
        )
        edge = terrain.bank_edge
        m.submodules.dut = dut = Opened(terrain)
        m.d.comb += terrain.walking.eq(1)
        free(m, terrain.steep, terrain.write_enable, terrain.write_x, terrain.write_y)
        free(m, terrain.write_altitude, terrain.lookup_x, terrain.lookup_y, terrain.lookup_valid)

        users = {}  # For each port of each bank, the lanes that use it, each with its row.
        for number, lane in enumerate(terrain.lanes):
            free(m, lane.valid, lane.row, lane.minor, lane.ceiling)
            major = Signal(config.coordinate_bits, name=f"major_{number}")
            x, y = (Signal(config.coordinate_bits, name=f"{axis}_{number}") for axis in "xy")
            m.d.comb += [
                major.eq(lane.row * config.lanes + number),
                x.eq(Mux(terrain.steep, lane.minor, major)),
                y.eq(Mux(terrain.steep, major, lane.minor)),
            ]
            for column in range(edge):
                for row in range(edge):
                    users.setdefault((column, row, number // edge), []).append(
                        (
                            lane.valid & (x % edge == column) & (y % edge == row),
                            x // edge + (config.map_size // edge) * (y // edge),
                        )
                    )
        for (column, row, port), lanes in users.items():
            bank = dut.submodules[f"bank_{column}_{row}"]
            address = (bank.b if port else bank.a).address
            used = Cat(uses for uses, _ in lanes)
            m.d.comb += Assert((used & (used - 1)[: len(used)]) == 0)
            for uses, at in lanes:
                used_then, at_then = Signal(), Signal.like(address)
                m.d.sync += [used_then.eq(uses), at_then.eq(at)]
                m.d.comb += Assert(~used_then | (address == at_then))
        m.d.comb += Cover(Cat(lane.valid for lane in terrain.lanes).all() & terrain.steep)
        return m


PROOF = Proof(
    claim=Banks,
    depth=2,
    long=True,
    induction=1,
    faults={
        "the axes are not exchanged": (
            TerrainMemory,
            ("Mux(self.steep, along[by_y], across[by_x])", "across[by_x]"),
        ),
        "the ports are exchanged": (
            TerrainMemory,
            ("by_x, by_y = port * edge + x", "by_x, by_y = (ports - 1 - port) * edge + x"),
        ),
        "a bank is one column further": (
            TerrainMemory,
            ("by_x, by_y = port * edge + x", "by_x, by_y = port * edge + (x + 1) % edge"),
        ),
    },
)

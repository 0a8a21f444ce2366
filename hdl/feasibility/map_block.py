"""Part of a memory of altitudes that one block RAM of a target is deep enough for."""

from amaranth import *
from amaranth.lib import memory, wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import ceil_log2


__all__ = ["MapBlock", "block_members"]


def block_members(*, rows, width, ports):
    """Return the members of a memory.

    Members
    -------
    a : In(Signature({address, write_enable, write_data, data}))
        ``address``: row to be read, or with ``write_enable`` to be written. ``data``: what is in
        the row that was addressed as many clocks ago as the latency says.
    b : In(Signature({address, data}))
        The second port, with ``ports`` of 2.
    """
    read = {"address": Out(ceil_log2(rows)), "data": In(width)}
    write = {"write_enable": Out(1), "write_data": Out(width)}
    members = {"a": In(wiring.Signature({**read, **write}))}
    if ports == 2:
        members["b"] = In(wiring.Signature(read))
    return members


class MapBlock(wiring.Component):
    """Memory that is read through one or two ports, and written through the first.

    With a latency of 2, data come out of registers. An ECP5 has them in its block RAMs; elsewhere
    they are any that follow.

    Parameters
    ----------
    rows, width, latency, ports : int
        As of :class:`hdl.feasibility.map_memory.MapMemory`.
    place : int or None
        Number of this block among those of its map, all of the same size, which says where on the
        device it lies; None where that does not matter.

    Members
    -------
    a, b
        See :func:`block_members`.
    """

    def __init__(self, *, rows, width, latency, ports, place=None):
        self.rows = rows
        self.width = width
        self.latency = latency
        self.ports = ports
        self.place = place
        super().__init__(block_members(rows=rows, width=width, ports=ports))

    def elaborate(self, platform):
        m = Module()

        device = getattr(platform, "device", "")
        if self.latency == 2 and device.startswith("LFE5U"):
            from hdl.boards.ecp5_memory import Ecp5Memory

            m.submodules.twin = twin = Ecp5Memory(
                rows=self.rows,
                width=self.width,
                ports=self.ports,
                place=self.place if device.endswith("-85F") else None,
            )
            for name in ("a", "b")[: self.ports]:
                connect(m, flipped(getattr(self, name)), getattr(twin, name))
            return m

        m.submodules.rows = rows = memory.Memory(
            shape=self.width, depth=self.rows, init=[], attrs={"no_rw_check": 1}
        )
        write = rows.write_port()
        m.d.comb += [
            write.addr.eq(self.a.address),
            write.data.eq(self.a.write_data),
            write.en.eq(self.a.write_enable),
        ]
        for name in ("a", "b")[: self.ports]:
            port, read = getattr(self, name), rows.read_port()
            m.d.comb += read.addr.eq(port.address)
            data = read.data
            if self.latency == 2:
                data = Signal(self.width, name=f"out_{name}", reset_less=True)
                m.d.sync += data.eq(read.data)
            m.d.comb += port.data.eq(data)

        return m

"""Drivers of streams for cocotb benches.

Ports are driven at falling edges, in the middle of a cycle, and a transfer is observed at its
rising edge; no Python runs while a stream waits.
"""

from cocotb.triggers import ClockCycles, FallingEdge, RisingEdge


async def pause(clk, cycles):
    """Wait for ``cycles`` falling edges."""
    if cycles:
        await ClockCycles(clk, cycles, FallingEdge)


class Stream:
    """A stream of a design.

    Parameters
    ----------
    dut : cocotb handle
    name : str
        Name of the stream; its ports are ``name__payload``, ``name__valid`` and ``name__ready``.
    layout : amaranth.lib.data.Layout
        Layout of the payload.
    clk : cocotb handle
    pauses : callable
        Returns the cycles to wait before the next word.
    """

    def __init__(self, dut, name, layout, clk, pauses=lambda: 0):
        self._payload, self._valid, self._ready = (
            getattr(dut, f"{name}__{part}") for part in ("payload", "valid", "ready")
        )
        self._layout = layout
        self._clk = clk
        self.pauses = pauses

    def idle(self, *, driven):
        """Reset the ports that the bench drives: of a stream it writes (``driven``) or reads."""
        if driven:
            self._valid.value = 0
            self._payload.value = 0
        else:
            self._ready.value = 0

    async def put(self, *words):
        """Transfer ``words``, mappings of the payload's fields."""
        for word in words:
            await pause(self._clk, self.pauses())
            self._payload.value = self._layout.const(word).as_value().value
            self._valid.value = 1
            await self._transfer(self._ready)
            await FallingEdge(self._clk)
            self._valid.value = 0

    async def get(self):
        """Read a word; return a constant of the layout."""
        await pause(self._clk, self.pauses())
        self._ready.value = 1
        await self._transfer(self._valid)
        word = self._layout.from_bits(self._payload.value.to_unsigned())
        await FallingEdge(self._clk)
        self._ready.value = 0
        return word

    async def _transfer(self, answer):
        """Wait for the rising edge at which ``answer`` is high."""
        await RisingEdge(self._clk)
        while not answer.value:
            await RisingEdge(answer)
            await RisingEdge(self._clk)

    async def get_until(self, field):
        """Read words up to the first whose ``field`` is set."""
        words = [await self.get()]
        while not words[-1][field]:
            words.append(await self.get())
        return words

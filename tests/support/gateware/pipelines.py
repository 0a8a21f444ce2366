"""Driver of pipelines that take inputs in every cycle, in the Amaranth simulator."""

from tests.support.gateware.streams import simulate


__all__ = ["outputs"]


def outputs(dut, output, inputs):
    """Return the output that each of ``inputs``, ports with their values, has ``latency`` later."""
    seen = []

    async def bench(ctx):
        for ports in inputs:
            for port, value in ports.items():
                ctx.set(getattr(dut, port), value)
            seen.append(ctx.get(getattr(dut, output)))
            await ctx.tick()
        for _ in range(dut.latency):
            seen.append(ctx.get(getattr(dut, output)))
            await ctx.tick()

    simulate(dut, bench)
    return seen[dut.latency :]

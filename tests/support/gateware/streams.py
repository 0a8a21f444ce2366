"""Drivers of streams for test benches in the Amaranth simulator."""

import itertools

from amaranth.sim import Simulator


__all__ = ["collect", "put", "simulate"]


async def put(ctx, stream, payload, limit=10_000):
    """Transfer ``payload`` to ``stream``, waiting at most ``limit`` cycles."""
    ctx.set(stream.payload, payload)
    ctx.set(stream.valid, 1)
    for _ in range(limit):
        _, _, ready = await ctx.tick().sample(stream.ready)
        if ready:
            ctx.set(stream.valid, 0)
            return
    raise TimeoutError(f"No transfer to {stream!r} within {limit} cycles")


async def collect(ctx, stream, into, pauses=(0,)):
    """Append every payload of ``stream`` to ``into``, after ``pauses`` cycles, repeated."""
    for pause in itertools.cycle(pauses):
        for _ in range(pause):
            await ctx.tick()
        ctx.set(stream.ready, 1)
        while True:
            _, _, valid, payload = await ctx.tick().sample(stream.valid, stream.payload)
            if valid:
                break
        ctx.set(stream.ready, 0)
        into.append(payload)


def simulate(dut, *benches, background=()):
    """Run ``benches`` on ``dut`` until all have ended; ``background`` benches end then."""
    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    for bench in benches:
        simulator.add_testbench(bench)
    for bench in background:
        simulator.add_testbench(bench, background=True)
    simulator.run()

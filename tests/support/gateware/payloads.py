"""Driver of a payload parser of ``pathgene.hdl.command``, in place of the command receiver."""

from pathgene.hdl.protocol.codes import Status
from tests.support.gateware.streams import simulate


def hand_over(unit, payloads, fields=None, *, repeated=False, collectors=(), limit=20_000):
    """Return the status and the cycles of each of ``payloads``, parsed in order.

    Cycles count from the first in which the parser is on to the cycle in which it is done.
    ``fields`` are inputs to set first. Bytes are offered without pauses.
    """
    outcomes = []

    async def bench(ctx):
        for name, value in (fields or {}).items():
            ctx.set(getattr(unit, name), value)
        ctx.set(unit.repeated, repeated)
        for payload in payloads:
            outcomes.append(await one(ctx, payload))
            # The parser resets while it is off.
            ctx.set(unit.on, 0)
            await ctx.tick().repeat(2)
            assert not ctx.get(unit.done)

    async def one(ctx, payload):
        at = 0
        ctx.set(unit.on, 1)
        for cycle in range(limit):
            ctx.set(unit.ended, at == len(payload))
            ctx.set(unit.bytes.valid, at < len(payload))
            ctx.set(unit.bytes.payload, payload[at] if at < len(payload) else 0x5A)
            _, _, taken, done, status = await ctx.tick().sample(
                unit.bytes.valid & unit.bytes.ready, unit.done, unit.status
            )
            if done:
                status = Status(status)
                assert status is not Status.OK or at == len(payload)
                return status, cycle + 1
            at += taken
        raise TimeoutError(f"Not done in {limit} cycles")

    simulate(unit, bench, background=collectors)
    return outcomes

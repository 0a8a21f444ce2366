"""Hands a payload to a unit of hdl.command as the receiving unit does."""

from hdl.protocol import Status
from tests.streams import simulate


__all__ = ["hand_over"]


def hand_over(unit, payloads, fields=None, *, repeated=False, collectors=(), limit=20_000):
    """Return status and cycles of each of ``payloads``, one after the other.

    Clocks are from the first in which the unit is on to that in which it is over. ``fields`` are
    inputs to be set before. Every byte is offered as soon as it may be.
    """
    outcomes = []

    async def bench(ctx):
        for name, value in (fields or {}).items():
            ctx.set(getattr(unit, name), value)
        ctx.set(unit.repeated, repeated)
        for payload in payloads:
            outcomes.append(await one(ctx, payload))
            # As after reset: nothing of the last one is left.
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
        raise TimeoutError(f"Not done in {limit} clocks")

    simulate(unit, bench, background=collectors)
    return outcomes

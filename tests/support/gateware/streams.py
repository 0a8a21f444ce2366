"""Drivers of streams and of pipelines for test benches in the Amaranth simulator."""

import functools
import inspect
import itertools

from amaranth.hdl import ResetInserter, Signal
from amaranth.sim import Simulator


async def pulse(ctx, signal):
    """Set ``signal`` for a cycle."""
    ctx.set(signal, 1)
    await ctx.tick()
    ctx.set(signal, 0)


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


def collect(stream, into, pauses=(0,)):
    """Return a bench that appends the payloads of ``stream``, each after the next of ``pauses``."""

    async def bench(ctx):
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

    return bench


@functools.cache
def shared(make, *sizes, **named):
    """Return ``make(*sizes, **named)``, the same design in every call.

    Its simulations need one elaboration, which takes longer than most of them run.
    """
    return make(*sizes, **named)


@functools.cache
def resettable(dut):
    """Return a top level in which a signal resets a shared design, and the signal."""
    reset = Signal()
    return ResetInserter(reset)(dut), reset


#: Maximum number of simulators that are kept; a module uses few at a time.
_KEPT = 8


@functools.lru_cache(_KEPT)
def _simulator(dut, front, back):
    """Return a simulator of ``dut`` and the list of its benches, the last ``back`` in background.

    The list is empty; a run fills it.
    """
    simulator, benches = Simulator(dut), []
    simulator.add_clock(1e-8, if_exists=True)
    for number in range(front + back):

        async def bench(ctx, number=number):
            await benches[number](ctx)

        simulator.add_testbench(bench, background=number >= front)
    return simulator, benches


def simulate(dut, *benches, background=()):
    """Run ``benches`` on ``dut`` until all have ended; ``background`` benches end then.

    Each simulation begins with the initial values of all signals and memories.
    """
    simulator, running = _simulator(dut, len(benches), len(background))
    if running:
        simulator.reset()
    running[:] = *benches, *background
    try:
        simulator.run()
    except BaseException:
        # The triggers of an interrupted step would act in the next simulation.
        _simulator.cache_clear()
        raise


def as_test(run):
    """Make a test of an async bench, which ``run`` executes.

    Parameters of the bench other than ``unit``, ``ctx`` and ``dut`` are parameters of the test.
    """

    def decorate(bench):
        def test(**given):
            run(functools.partial(bench, **given))

        own = inspect.signature(bench).parameters.values()
        given = [each for each in own if each.name not in ("unit", "ctx", "dut")]
        functools.update_wrapper(test, bench).__signature__ = inspect.Signature(given)
        return test

    return decorate


def on(make):
    """Make a test of an async bench of ``ctx`` and ``dut``, a design that ``make`` returns."""

    def run(bench):
        dut = shared(make)
        simulate(dut, functools.partial(bench, dut=dut))

    return as_test(run)


def outputs(dut, output, inputs):
    """Return the output for each of ``inputs``, ports with values, ``latency`` cycles later."""
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


async def drive(ctx, stream, words, pauses=(0,), limit=100_000):
    """Offer ``words`` one by one, each after the next of ``pauses`` in idle cycles."""
    for word, pause in zip(words, itertools.cycle(pauses), strict=False):
        if pause:
            await ctx.tick().repeat(pause)
        await put(ctx, stream, word, limit)


def watch(stream, words, pauses=(0,)):
    """Return a background process that appends every word to ``words``, with its cycle.

    It checks that an offer stays until it is accepted.
    """

    async def process(ctx):
        pause = itertools.cycle(pauses)
        left = next(pause)
        offered = None
        cycle = 0
        while True:
            ctx.set(stream.ready, left == 0)
            *_, valid, word = await ctx.tick().sample(stream.valid, stream.payload)
            assert offered is None or (valid and word == offered), "an offer was taken back"
            offered = word if valid and left else None
            if valid and left == 0:
                words.append((cycle, word))
                left = next(pause)
            elif left:
                left -= 1
            cycle += 1

    return process


def pass_through(dut, words, drive_pauses, watch_pauses):
    """Send ``words`` through a unit with one stream in and out; return each with its cycle."""
    passed = []

    async def feed(ctx):
        await drive(ctx, dut.words, words, drive_pauses)
        await ctx.tick().repeat(6)

    simulate(dut, feed, background=[watch(dut.passed, passed, watch_pauses)])
    return passed

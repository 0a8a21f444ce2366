"""Parts of claims: free values, opened units, scoreboards, the cells of a segment."""

import inspect

from amaranth import *
from amaranth.hdl import Assert, Assume, Cover, Fragment
from amaranth.hdl._ast import AnyConst, AnySeq
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.protocol.codes import ChipState
from tools.formal import altered


def any_constant(m, shape, name):
    """Return a signal that has any value, the same in every cycle."""
    return _set(m, Signal(shape, name=name), AnyConst)


def free(m, *signals):
    """Let inputs have any value in every cycle."""
    for signal in signals:
        _set(m, signal, AnySeq)


def comes_back(m, states, earlier, age, away, limit, *, most):
    """Claim that a control unit returns to LISTEN at most ``most * limit`` cycles after leaving it.

    Parameters
    ----------
    states : (Signal, Signal)
        The state in the previous cycle, and in this one.
    earlier : dict of ChipState to int
        Every other state, and the maximum number of states before it.
    age, away : Signal
        Cycles in the state, and outside LISTEN.
    limit : Signal
        Maximum time in a state.
    """
    before, state = states
    with m.Switch(state):
        with m.Case(ChipState.LISTEN):
            pass
        for at, count in earlier.items():
            with m.Case(at):
                m.d.comb += [Assert(age < limit), Assert(away <= count * limit + age)]
        with m.Default():
            m.d.comb += Assert(0)
    with m.If((state == ChipState.LISTEN) & (before != ChipState.LISTEN)):
        m.d.comb += [
            Assert(away <= most * limit),
            Cover((away == most * limit) & (limit == 2)),
        ]


def made_of(component, **units):
    """Return a component's class from a copy of its module with other classes as its parts."""
    copy = altered(component, ("__all__", "__all__"))
    if missing := units.keys() - vars(inspect.getmodule(component)).keys():
        raise ValueError(f"{component.__name__} uses no {', '.join(missing)}")
    copy.elaborate.__globals__.update(units)
    return copy


def _set(m, signal, source):
    value = Value.cast(signal)
    m.d.comb += value.eq(source(value.shape()))
    return signal


class Opened(Elaboratable):
    """A component whose internals are visible, as a proof by induction needs.

    Attributes
    ----------
    submodules
        The submodules of the component, by name.
    """

    def __init__(self, component):
        component._MustUse__used = True
        self._module = component.elaborate(None)
        self._fragment = None
        self.submodules = self._module.submodules

    def memory(self, m, name, address):
        """Return row ``address`` of a memory that is a submodule; call it before `signal`."""
        port = self.submodules[name].read_port(domain="comb")
        m.d.comb += port.addr.eq(address)
        return Value.cast(port.data)

    def open(self, name):
        """Return the submodule of that name, also opened; call it before `signal`."""
        component, where = self._module._named_submodules[name]
        inner = Opened(component)
        self._module._named_submodules[name] = inner, where
        return inner

    def signal(self, name, domain=None):
        """Return the signal of that name that the component drives, in a given or any domain."""
        if self._fragment is None:
            self._fragment = Fragment.get(self._module, None)
        found = {
            id(signal): signal
            for driver, statements in self._fragment.statements.items()
            for signal in statements._lhs_signals()
            if signal.name == name and domain in (None, driver)
        }
        (signal,) = found.values()
        return signal

    def elaborate(self, platform):
        return self._module if self._fragment is None else self._fragment


class Scoreboard(Elaboratable):
    """Asserts that words leave as they entered: in order, none lost, none invented.

    It watches an arbitrary word: the word whose number, modulo ``2**bits``, is ``watched``. A claim
    about this word is a claim about every word.

    Parameters
    ----------
    bits : int
        Width of the counters; ``2**bits`` exceeds the number of words that can be in flight.

    Attributes
    ----------
    put, put_word, take, take_word
        A word enters or leaves in this cycle, and that word.
    inside : Signal(bits)
        Number of words that entered and have not left.
    watched, value : Signal
        Number of the watched word, and the word itself once it has entered.
    taken : Signal(bits)
        Number of words that left.
    """

    def __init__(self, shape, bits):
        self.put, self.take = Signal(), Signal()
        self.put_word, self.take_word = Signal(shape), Signal(shape)
        self.inside, self.taken, self.watched = (Signal(bits) for _ in range(3))
        self.given = Signal(bits)
        self.value = Signal(shape)

    def elaborate(self, platform):
        m = Module()
        m.d.comb += [
            self.watched.eq(AnyConst(self.watched.shape())),
            self.inside.eq(self.given - self.taken),
        ]
        m.d.sync += [
            self.given.eq(self.given + self.put),
            self.taken.eq(self.taken + self.take),
        ]
        with m.If(self.put & (self.given == self.watched)):
            m.d.sync += Value.cast(self.value).eq(Value.cast(self.put_word))
        # A word may leave in the cycle in which it enters.
        known = Mux(
            self.put & (self.given == self.watched),
            Value.cast(self.put_word),
            Value.cast(self.value),
        )
        with m.If(self.take):
            m.d.comb += Assert((self.inside != 0) | self.put)
            with m.If(self.taken == self.watched):
                m.d.comb += Assert(Value.cast(self.take_word) == known)
        with m.If(self.put):
            m.d.comb += Assert(self.inside != (1 << len(self.given)) - 1)
        return m


class FreeCrc(wiring.Component):
    """A CRC unit that may compute anything: a new value after each byte and each start."""

    def __init__(self):
        super().__init__({"data": In(8), "valid": In(1), "start": In(1), "crc": Out(32)})

    def create(self):
        return self

    def elaborate(self, platform):
        m = Module()
        steady, before = Signal(), Signal(32)
        free(m, self.crc)
        m.d.sync += [steady.eq(~self.valid & ~self.start), before.eq(self.crc)]
        m.d.comb += Assume(~steady | (self.crc == before))
        return m


class FreeEncoder(wiring.Component):
    """A COBS encoder that takes bytes and sends arbitrary bytes at any time."""

    def __init__(self):
        layout = data.StructLayout({"data": 8, "last": 1})
        super().__init__(
            {
                "frames": In(stream.Signature(layout)),
                "encoded": Out(stream.Signature(8)),
            }
        )

    def elaborate(self, platform):
        m = Module()
        free(m, self.frames.ready, self.encoded.valid, self.encoded.payload)
        return m


class Segment:
    """A segment between two points, with its cells.

    Cell k of 0..n, where n is the longer side, is ``start + floor((2 k d + n) / (2 n))`` along an
    axis on which it gains d; a quotient's floor q is checked as
    ``2 n q <= 2 k d + n < 2 n (q + 1)``.

    Parameters
    ----------
    start, stop : StructLayout with x, y and altitude
    """

    def __init__(self, m, start, stop):
        self.start, self.stop = start, stop
        xy = len(start.x)
        self.gain = {a: Signal(signed(xy + 1), name=f"gain_{a}") for a in "xy"}
        self.side = {a: Signal(xy, name=f"side_{a}") for a in "xy"}
        self.rise = Signal(signed(len(start.altitude) + 1))
        self.steep = Signal()
        self.length = Signal(xy)
        for a in "xy":
            gain = self.gain[a]
            m.d.comb += [
                gain.eq(stop[a] - start[a]),
                self.side[a].eq(Mux(gain < 0, -gain, gain)),
            ]
        m.d.comb += [
            self.rise.eq(stop.altitude - start.altitude),
            self.steep.eq(self.side["y"] > self.side["x"]),
            self.length.eq(Mux(self.steep, self.side["y"], self.side["x"])),
        ]

    def is_at(self, axis, k, coordinate):
        """Return whether cell ``k`` has this coordinate."""
        n = self.length
        steps = coordinate - self.start[axis]
        doubled = 2 * k * self.gain[axis] + n
        # A segment of one cell has n = 0, and its only cell is its start.
        inside = (2 * n * steps <= doubled) & (doubled < 2 * n * (steps + 1))
        return Mux(n == 0, steps == 0, inside)

    def lowest(self):
        """Return the lower of the altitudes of both ends."""
        return Mux(self.rise < 0, self.stop.altitude, self.start.altitude)

    def is_ceiling(self, k, altitude):
        """Return whether exactly the ground at or above ``altitude`` collides with cell ``k``."""
        n = self.length
        scaled = self.start.altitude * n + k * self.rise
        inside = (scaled <= altitude * n) & (scaled > altitude * n - n)
        return Mux(n == 0, altitude == self.lowest(), inside)

"""Crossover module: two parents swap their tails past the middle."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.config import Config
from hdl.ga_core.chromosome import half_signature


__all__ = ["Crossover", "parent_signature", "parents_of"]


def parent_signature(config: Config) -> wiring.Signature:
    """Return the signature of a parent that passes by: its present waypoint and its length."""
    return wiring.Signature(
        {"waypoint": Out(config.waypoint_bits), "length": Out(config.length_bits)}
    )


def parents_of(config: Config, child: int) -> tuple[int, int]:
    """Return which parent a child has its head of, and which its tail."""
    first = child // 2
    second = (first + 1) % config.crossovers
    return (second, first) if child % 2 else (first, second)


class Crossover(wiring.Component):
    """One of the crossover modules: breeds two children of two parents.

    The parents pass by in lock step, one waypoint of each a clock. Those before the middle of a
    parent, rounded down, go to the head of one child; the others to the tail of the other. As a
    child keeps its halves apart, both parents are always taken, and no half is written twice in a
    clock. No clocks of its own: the children are written with the waypoints that pass.

    Source: *allaire-2008*, section 4.5.

    Parameters
    ----------
    config : Config

    Members
    -------
    on : In(1)
        Waypoints pass.
    position : In(index_bits)
        Position of the waypoints in their paths.
    parents : In(parent_signature).array(2)
    heads, tails : Out(half_signature).array(2)
        Written to each child: the first gets the head of the first parent and the tail of the
        second, the second the others. Combinational; ``valid`` and ``at`` depend on ``on``,
        ``position`` and the lengths alone, so that they can be worked out before the waypoints are
        there.
    """

    def __init__(self, config):
        if not isinstance(config, Config):
            raise TypeError(f"Config must be a Config, not {config!r}")

        self.config = config
        super().__init__(
            {
                "on": In(1),
                "position": In(config.index_bits),
                "parents": In(parent_signature(config)).array(2),
                "heads": Out(half_signature(config)).array(2),
                "tails": Out(half_signature(config)).array(2),
            }
        )

    def elaborate(self, platform):
        m = Module()

        for number in range(2):
            parent = self.parents[number]
            head = self.heads[number]
            tail = self.tails[1 - number]

            middle = Signal(self.config.length_bits - 1, name=f"middle_{number}")
            m.d.comb += [
                middle.eq(parent.length >> 1),
                head.valid.eq(self.on & (self.position < middle)),
                head.at.eq(self.position),
                head.waypoint.eq(parent.waypoint),
                tail.valid.eq(
                    self.on & (self.position >= middle) & (self.position < parent.length)
                ),
                tail.at.eq(self.position - middle),
                tail.waypoint.eq(parent.waypoint),
            ]

        return m

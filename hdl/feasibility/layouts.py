"""Payloads between the units of the checker, and the ports of a walker."""

from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from pathgene.hdl.config import Config
from pathgene.hdl.layouts import cell_layout, point_layout


__all__ = ["count_layout", "step_layout", "verdict_layout", "walker_signature"]


#: Width of a count of cycles.
CYCLES_BITS = 24


def verdict_layout(
    coordinate_bits: int, segment_bits: int, path_cells_bits: int
) -> data.StructLayout:
    """Return the layout of the verdict on one path.

    ``collision`` (otherwise the path is clear); ``segment``, ``x``, ``y`` of the first colliding
    cell, in cells of its map, and ``coarse`` if that is the coarse map: these four are 0 if there
    is no collision. ``cells``, from the path's first to the colliding one; ``reads``, the number of
    addresses given to the memory; ``cycles``; and ``entries``, the number of items in the stream of
    counts (:func:`count_layout`).
    """
    return data.StructLayout(
        {
            "collision": 1,
            "segment": segment_bits,
            "x": coordinate_bits,
            "y": coordinate_bits,
            "coarse": 1,
            "cells": path_cells_bits,
            "reads": path_cells_bits + 1,
            "cycles": CYCLES_BITS,
            "entries": segment_bits + 1,
        }
    )


def count_layout(coordinate_bits: int, segment_bits: int) -> data.StructLayout:
    """Return the layout of one segment's counts of colliding cells: terrain and blocked.

    Each ranges from 0 to the number of cells along an edge of the map.
    """
    return data.StructLayout(
        {"segment": segment_bits, "terrain": coordinate_bits + 1, "nofly": coordinate_bits + 1}
    )


def step_layout(coordinate_bits: int, segment_bits: int, path_cells_bits: int) -> data.StructLayout:
    """Return the layout of a step, which is the progress of one cycle.

    ``valid``
        There is a step; all other fields are only valid then.
    ``first``, ``ends_segment``, ``ends_path``
        The step is the first of its path, the last of its segment, the last of its path. The last
        step of a path also ends a segment.
    ``segment``
        Number of the segment in its path.
    ``cells``
        Cells of the path in this step, from 0 to the number of cells along an edge of the map.
    ``hit``, ``until``
        One of these cells collides; number of cells up to and including the first colliding one.
    ``x``, ``y``, ``coarse``
        The first colliding cell, in cells of its map, and whether that is the coarse map.
    ``terrain``, ``nofly``
        Number of cells that collide with terrain, and with blocked ground.
    ``reads``
        Number of addresses given to the memories for this path, if this is its last step or the
        cycle of its ``drop``.
    """
    return data.StructLayout(
        {
            "valid": 1,
            "first": 1,
            "ends_segment": 1,
            "ends_path": 1,
            "segment": segment_bits,
            "cells": coordinate_bits + 1,
            "hit": 1,
            "until": coordinate_bits + 1,
            "x": coordinate_bits,
            "y": coordinate_bits,
            "coarse": 1,
            "terrain": coordinate_bits + 1,
            "nofly": coordinate_bits + 1,
            "reads": path_cells_bits + 1,
        }
    )


def walker_signature(config: Config) -> wiring.Signature:
    """Return the signature of a walker, which turns paths into map reads and reads into steps.

    Members
    -------
    count : In(1)
        Walk each path to its end, even after a hit. Steady while a path is in flight.
    points : In(stream.Signature(point_layout))
        The points of the paths, path after path.
    room, segment_room : In(1)
        There is a place for the verdict of one more path, and for the count of one more segment.
    begins, segment_begins : Out(1)
        A place is taken; only while there is one. It happens once for each path and segment, no
        later than the cycle before its first step. All segments of a path that is not dropped
        begin.
    step : Out(step_layout)
        Progress. There is no back-pressure.
    drop : In(1)
        In the cycle of a step: discard the rest of its path. More steps of the path may follow and
        are ignored. An address given for it in this cycle counts towards ``reads``; no address is
        given for it later.
    writes : In(stream.Signature(cell_layout))
        Cells of the map, see :class:`pathgene.hdl.feasibility.checker.Checker`. They only arrive
        while no path is in flight.
    lookup_valid : In(1)
    lookup_x, lookup_y : In(coordinate_bits)
        With ``lookup_valid``, cell to be looked up: only while no path is in flight, and neither in
        the cycle of a write nor in the next cycle.
    lookup_altitude : Out(altitude_bits)
        Its altitude, ``config.lookup_latency`` cycles later.
    """
    step = step_layout(config.coordinate_bits, config.segment_bits, config.path_cells_bits)
    points = point_layout(config.coordinate_bits, config.altitude_bits)
    cells = cell_layout(config.coordinate_bits, config.altitude_bits)
    return wiring.Signature(
        {
            "count": In(1),
            "points": In(stream.Signature(points)),
            "room": In(1),
            "segment_room": In(1),
            "begins": Out(1),
            "segment_begins": Out(1),
            "step": Out(step),
            "drop": In(1),
            "writes": In(stream.Signature(cells)),
            "lookup_valid": In(1),
            "lookup_x": In(config.coordinate_bits),
            "lookup_y": In(config.coordinate_bits),
            "lookup_altitude": Out(config.altitude_bits),
        }
    )

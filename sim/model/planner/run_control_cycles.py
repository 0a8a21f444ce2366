"""Cycles between the steps of a run, as in the gateware.

The scan of the blocks begins in cycle 0. Random source and memo are ready long before
the scan ends.
"""

from __future__ import annotations


__all__ = [
    "AIMED",
    "BEGIN",
    "END",
    "EVALUATED",
    "MERGED",
    "NEXT_ISLAND",
    "POPULATION",
    "ROUTED",
    "SCANNED",
    "SPLIT",
    "SPLIT_TO_AIM",
]

#: From cycle 0 to the begin of the first route, or of the paths of a warm run, without the cycles
#: of the scan.
SCANNED = 2
#: From the begin of a route to the begin of its seeds, without the cycles of the route.
ROUTED = 2
#: From the first cycle without a path that is made or evaluated to the store of the population.
EVALUATED = 1
#: From the first cycle with a whole first population to the begin of the next paths or route; with
#: the last one, to the split, or to the aim if there is only one island.
POPULATION = 1
#: From the split, whose cycle is the one that parts are computed from, to the first aim.
SPLIT, SPLIT_TO_AIM = POPULATION, 7
#: From an aim, whose cycle an island's limit is counted from, to the first cycle in which a
#: generation may be ready to begin.
AIMED = 1
#: From the first cycle of a ready population, which limits are compared with, to the begin of a
#: generation, or to the finish of the last one.
BEGIN = 1
#: From that cycle without a generation to finish: to the aim of the next island, to the merge, and
#: from there to the aim; and to the number of cycles of the run.
NEXT_ISLAND, MERGED, END = 2, (2, 1), 3

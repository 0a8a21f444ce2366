"""Units whose netlists are compared with their Verilog, at the sizes of the small chip."""

import functools

from pathgene.hdl.primitives.unit import Unit
from tests.support.gateware.unit_pool import components_of_chips
from tools.equivalence import PAGE, rows_of_page


_ROOMS = ("pathgene.hdl.link.", "pathgene.hdl.planner.", "pathgene.hdl.primitives.")

#: Units whose check takes seconds, with each substitution.
QUICK = (
    "SkidBuffer",
    "UartTransmitter",
    "RunLimits",
    "Multiplier",
    "PathReducer",
    "CobsDecoder",
    "SegmentMeasurer",
)


def units():
    """Return a function that makes each unit of the small chip with a planner core, by name."""
    found = {}
    for kind, instances in components_of_chips().items():
        if issubclass(kind, Unit) and kind.__module__.startswith(_ROOMS):
            given = {name: getattr(instances[-1], name) for name in kind.parameters}
            found[kind.__name__] = functools.partial(kind, **given)
    return dict(sorted(found.items()))


def rows_of_the_page():
    """Return the cells of each row of the page's table, by unit."""
    return rows_of_page(PAGE.read_text(encoding="utf-8"))

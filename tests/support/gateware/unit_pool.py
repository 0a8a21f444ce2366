"""All units of the gateware: their classes, and the instances in chips."""

import functools
import gc
import importlib
import pkgutil

from amaranth.hdl import Fragment
from amaranth.lib import wiring

from pathgene import hdl
from pathgene.hdl.config import CheckerBuild, Config
from pathgene.hdl.primitives.unit import Unit
from pathgene.hdl.top import Chip
from tests.support.gateware.chips import SMALL


#: Chips that together have every build of every part.
CHIPS = (
    SMALL,
    SMALL.replace(checker=CheckerBuild.TWO_TIER, lanes=1),
    SMALL.replace(checker=CheckerBuild.PARALLEL, lanes=4),
    Config(core="none"),
    SMALL.replace(core="planner", checker=CheckerBuild.PARALLEL, lanes=4, point_cycles=2),
    SMALL.replace(core="planner", checker=CheckerBuild.PARALLEL, lanes=4, clocks_per_bit=0),
)


def unit_classes():
    """Return the classes of all units, in the order of their modules and names."""
    for module in pkgutil.walk_packages(hdl.__path__, f"{hdl.__name__}."):
        importlib.import_module(module.name)
    found = list(Unit.__subclasses__())
    for each in found:
        found += each.__subclasses__()
    shipped = (each for each in found if each.__module__.startswith(f"{hdl.__name__}."))
    return sorted(shipped, key=lambda each: (each.__module__, each.__name__))


@functools.cache
def components_of_chips():
    """Return the components of all chips by their class."""
    found = {}
    for config in CHIPS:
        others = _alive()
        fragment = Fragment.get(Chip(config), None)
        for number, each in _alive().items():
            if number not in others:
                found.setdefault(type(each), []).append(each)
        del fragment
    return found


def _alive():
    """Return the existing components of the gateware by identity.

    They are tested by type, because ``isinstance`` fails for a weak proxy of a lost object.
    """
    return {
        id(each): each
        for each in gc.get_objects()
        if issubclass(type(each), wiring.Component)
        and type(each).__module__.startswith(f"{hdl.__name__}.")
    }

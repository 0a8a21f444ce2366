"""Parameters of all units: stored, checked and documented as declared."""

import gc
import inspect
import re

import pytest
from amaranth.hdl import Fragment

from pathgene.hdl.boards import find_board
from pathgene.hdl.primitives.buffers import SkidBuffer
from pathgene.hdl.primitives.unit import Choice, Count, InstanceOf, PowerOfTwo, Unit
from tests.formal import netlists
from tests.support.gateware.unit_pool import CHIPS, components_of_chips, unit_classes


#: Rules of the parameters by name, for the units that the next table does not list.
RULES = {
    "altitude_bits": "Altitude width must be 1 or more",
    "best_of": "Draws for one number must be 1 or 2",
    "box_cells": "Box width must be 1 or more",
    "box_steps": "Box height must be 1 or more",
    "candidates": "Candidates must be 1 or more",
    "capacity": "Capacity must be 2 or more",
    "checked_paths": "Paths of a check must be 1 or more",
    "children": "Children must be from 1 to population - 1",
    "clocks_per_bit": "Clocks per bit must be from 4 to 65535",
    "coarse_bits": "Coarse width must be from 1 to coordinate_bits - 1",
    "coordinate_bits": "Coordinate width must be 1 or more",
    "count": "Count must be from 1 to total",
    "count_places": "Places for counts must be 1 or more",
    "counter_bits": "Counter width must be 1 or more",
    "crossovers": "Crossovers must be 2 or more",
    "depth": "Depth must be 1 or more",
    "detailed_segments": "Detailed segments must be 1 or more",
    "divisor_bits": "Divisor width must be 1 or more",
    "draw_bits": "Draw width must be 2 or more",
    "elite_ports": "Elite ports must be 1 or more",
    "elites": "Elites must be from 0 to population - 2",
    "epoch_bits": "Epoch width must be 1 or more",
    "first": "First number must be 0 or more",
    "fraction": "Fraction must be 0 or more",
    "history_entry_bits": "History entry width must be max(type(initial)).bit_length() or more",
    "history_length": "History must be 1 or more",
    "hits_bits": "Hits width must be 1 or more",
    "index_bits": "Index width must be 1 or more",
    "islands": "Islands must be from 1 to 2",
    "iv": "IV must be from 0 to 2**80 - 1",
    "key_bits": "Key width must be 1 or more",
    "lane_count": "Lanes must be a power of two from 1 to 1 << coordinate_bits",
    "lanes": "Lanes must be a power of two from 1 to 1 << coordinate_bits",
    "latency": "Latency must be 1 or 2",
    "length_bits": "Length width must be 1 or more",
    "lookup_latency": "Lookup latency must be 1 or more",
    "map_size": "Map size must be a power of two from 2 to 65536",
    "max_segments": "Segments of a path must be 1 or more",
    "max_waypoints": "Max waypoints must be 3 or more",
    "memo_rows": "Rows must be a power of two from 2 to 65536",
    "memory_latency": "Memory latency must be from 1 to 2",
    "min_waypoints": "Min waypoints must be 1 or more",
    "mutators": "Mutators must be 1 or more",
    "parent_ports": "Parent ports must be 1 or more",
    "parts": "Parts must be 1 or more",
    "patch_count": "Patch count must be 1 or more",
    "path_cells_bits": "Width of a path's cells must be 1 or more",
    "place_bits": "Place width must be 1 or more",
    "population": "Population must be 2 or more",
    "ports": "Ports must be 1 or 2",
    "quotient_bits": "Quotient width must be 1 or more",
    "rank_bits": "Rank width must be from 1 to 5",
    "read_latency": "Read latency must be 1 or more",
    "receive_buffer": "Receive buffer must be a power of two from 8 to 32768",
    "rise_bits": "Rise width must be fraction + 1 or more",
    "row_bits": "Row width must be 1 or more",
    "rows": "Rows must be a power of two from 2 on",
    "scan_latency": "Latency of a scan must be 1 or more",
    "segment_bits": "Segment width must be 1 or more",
    "share_bits": "Share width must be 1 or more",
    "shift": "Shift must be 0 or more",
    "slot_bits": "Slot width must be 1 or more",
    "slot_count": "Slots must be 2 or more",
    "slots": "Slots must be 2 or more",
    "steps": "Steps must be 2 or more",
    "survivor_ports": "Survivor ports must be 1 or more",
    "survivors": "Survivors must be from 1 to population - elites - 1",
    "tag_bits": "Tag width must be 1 or more",
    "total": "Total must be 2 or more",
    "verdict_places": "Places for verdicts must be 1 or more",
    "waypoint_bits": "Waypoint width must be 1 or more",
    "width": "Width must be 1 or more",
}
#: Rules of other units, by unit and parameter.
EXCEPTIONS = {
    ("BestReader", "max_waypoints"): "Max waypoints must be 2 or more",
    ("BlockMap", "lanes"): "Lanes must be a power of two from 1 to min(64, 1 << coordinate_bits)",
    ("Breeder", "islands"): "Islands must be 1 or more",
    ("CoarseMap", "coordinate_bits"): "Coordinate width must be 2 or more",
    ("Collector", "population"): "Population must be a power of two from 2 to 256",
    ("CommitRing", "depth"): "Depth must be a power of two from 2 on",
    ("Ecp5Memory", "rows"): "Rows of a block must be a power of two from 2 to 16384",
    ("FieldDecoder", "altitude_bits"): "Altitude width must be from 1 to 16",
    ("FieldDecoder", "population"): "Population must be from 2 to 256",
    ("FieldDecoder", "max_waypoints"): "Max waypoints must be from 2 to 255",
    ("FirstPaths", "max_waypoints"): "Max waypoints must be 2 or more",
    ("LowestCorner", "lanes"): "Lanes must be a power of two from 1 to 64",
    ("MarginReducer", "lanes"): "Lanes must be a power of two from 1 to 16",
    ("MemberReader", "max_waypoints"): "Max waypoints must be 2 or more",
    ("Memo", "rows"): "Rows must be a power of two from 2 to 65536",
    ("PathParser", "max_waypoints"): "Max waypoints must be 2 or more",
    ("PathParser", "population"): "Population must be from 2 to 256",
    ("PathSource", "max_waypoints"): "Max waypoints must be 1 or more",
    ("PathSource", "population"): "Population must be from 2 to 256",
    ("PathStore", "max_waypoints"): "Max waypoints must be 2 or more",
    ("PointParser", "max_waypoints"): "Max waypoints must be 1 or more",
    ("PopulationMemory", "max_waypoints"): "Max waypoints must be 2 or more",
    ("PositionCounter", "ports"): "Ports must be 1 or more",
    ("Ranking", "islands"): "Islands must be a power of two from 1 to 16",
    ("Ranking", "population"): "Population must be a power of two from 2 to 256",
    ("RankingParser", "population"): "Population must be from 2 to 256",
    ("ReadCrossbar", "ports"): "Ports must be 1 or more",
    (
        "SegmentWalker",
        "lanes",
    ): "Lanes must be a power of two from 1 to min(16, 1 << coordinate_bits)",
    ("Route", "max_waypoints"): "Max waypoints must be 2 or more",
    ("SlotPool", "total"): "Slots must be 2 or more",
    ("SquareRoot", "width"): "Root width must be 1 or more",
    ("TwoTierSegmentSetup", "coordinate_bits"): "Coordinate width must be 2 or more",
    ("WideMultiplier", "shift"): "Shift must be from 0 to 18",
}


#: Arguments of the units that no chip of the tests has.
ARGUMENTS = {
    "BoardTop": {"board": find_board("ulx3s-85f")},
    "Ecp5AddSubtract": {"width": 4},
    "Ecp5Memory": {"rows": 2048, "width": 9, "ports": 1, "sites": ()},
    "Ecp5Multiplier": {"signs": (True, False)},
    "Feasibility": {"config": CHIPS[1]},
    "PaperCoreTop": {"config": CHIPS[0]},
    "Harness": {"unit": SkidBuffer(4)},
    "Uart": {"clocks_per_bit": 8},
}


@pytest.fixture(autouse=True)
def collected():
    """Collect the units that a test builds, while their warnings are ignored."""
    yield
    gc.collect()


@pytest.fixture(scope="module")
def arguments():
    """Return arguments that build each unit, by its class."""
    found = {
        kind: {name: getattr(instances[-1], name) for name in kind.parameters}
        for kind, instances in components_of_chips().items()
        if issubclass(kind, Unit)
    }
    return found | {
        each: ARGUMENTS[each.__name__] for each in unit_classes() if each.__name__ in ARGUMENTS
    }


def numbers(kind):
    """Return the parameters of a unit that are integers within bounds, by name."""
    return {name: each for name, each in kind.parameters.items() if isinstance(each, Count)}


def allowing(kind, given, name, value):
    """Return the arguments with one changed; those whose bounds it moves are clamped."""
    values = given | {name: value}
    for other, parameter in numbers(kind).items():
        if parameter.depends and other != name:
            low, high = parameter.bounds(values)
            values[other] = max(low, values[other] if high is None else min(values[other], high))
    return values


def refusal(kind, values):
    """Return the error that a unit raises for wrong arguments; None if it raises none."""
    try:
        kind(**values)
    except (TypeError, ValueError) as error:
        return f"{type(error).__name__}: {error}"
    return None


def cases(arguments):
    """Return each unit that can be built, its bounded parameters, and valid arguments."""
    return [
        (kind, name, parameter, given)
        for kind, given in arguments.items()
        for name, parameter in numbers(kind).items()
    ]


def test_every_unit_has_arguments(arguments):
    abstract = {"SegmentShaper"}
    assert {each.__name__ for each in unit_classes()} == {
        each.__name__ for each in arguments
    } | abstract
    assert len(arguments) > 120


def test_every_netlist_has_a_row_on_its_page():
    """The test stands here because ``arguments`` has built the same chips."""
    assert netlists.rows_of_the_page().keys() == netlists.units().keys()


def test_parameters_are_kept(arguments):
    for kind, given in arguments.items():
        made = kind(*given.values())
        assert {name: getattr(made, name) for name in given} == given, kind


def test_rules():
    """The bounds are stated a second time here, so that none changes by mistake."""
    found = {
        (each.__name__, name): f"{parameter.title(name)} must be {parameter.rule()}"
        for each in unit_classes()
        for name, parameter in each.parameters.items()
        if parameter.rule()
    }
    wrong = {
        place: rule
        for place, rule in found.items()
        if rule != EXCEPTIONS.get(place, RULES.get(place[1], rule))
    }
    assert wrong == {}
    assert found.keys() >= EXCEPTIONS.keys()
    assert {name for _, name in found} >= RULES.keys()
    assert len(found) > 200


def test_bounds_are_allowed_and_numbers_beyond_are_not(arguments):
    count = 0
    for kind, name, parameter, given in cases(arguments):
        for place in range(2):
            bound = parameter.bounds(given)[place]
            if bound is None:
                continue
            values = allowing(kind, given, name, bound)
            kind(**values)
            beyond = (bound - 1, bound + 1)[place]
            message = f"{parameter.title(name)} must be {parameter.rule(values)}, not {beyond}"
            if beyond not in parameter.also:
                assert refusal(kind, values | {name: beyond}) == f"ValueError: {message}", kind
                count += 1
        if isinstance(parameter, PowerOfTwo):
            message = f"{parameter.title(name)} must be {parameter.rule(given)}, not 3"
            assert refusal(kind, given | {name: 3}) == f"ValueError: {message}", kind
        for wrong in ("3", 2.0, True):
            message = f"{parameter.title(name)} must be an integer, not {wrong!r}"
            assert refusal(kind, given | {name: wrong}) == f"TypeError: {message}", kind
    assert count > 200


@pytest.mark.ci
def test_units_with_the_lowest_numbers_are_gateware(arguments):
    """A minimum is more than a claim: the unit elaborates with it."""
    for kind, name, parameter, given in cases(arguments):
        values = allowing(kind, given, name, parameter.bounds(given)[0])
        Fragment.get(kind(**values), None)


def test_choices_are_allowed_and_no_other_number(arguments):
    for kind, given in arguments.items():
        for name, parameter in kind.parameters.items():
            if isinstance(parameter, Choice):
                for choice in parameter.choices:
                    kind(**given | {name: choice})
                message = f"{parameter.title(name)} must be {parameter.rule()}, not 3"
                assert refusal(kind, given | {name: 3}) == f"ValueError: {message}", kind


def test_objects_are_checked(arguments):
    count = 0
    for kind, given in arguments.items():
        for name, parameter in kind.parameters.items():
            if isinstance(parameter, InstanceOf):
                message = f"{parameter.title(name)} must be {parameter.phrase}, not 'big'"
                assert refusal(kind, given | {name: "big"}) == f"TypeError: {message}", kind
                count += 1
    assert count > 20


def test_docstrings_have_the_parameters():
    for kind in unit_classes():
        lines = inspect.getdoc(kind)
        found = re.search(r"\n\nParameters\n-{10}\n(.*?)(\n\n|$)", lines, re.DOTALL)
        entries = re.findall(r"^(\w+) : ", found[1], re.MULTILINE) if found else []
        assert entries == list(kind.parameters), kind

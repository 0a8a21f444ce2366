"""Docstrings of components list all their ports, with directions and widths."""

import inspect
import re
import sys

import pytest
from amaranth.hdl import Shape

from pathgene.hdl.command.layouts import payload_members
from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.layouts import generation_signature
from tests.support.gateware.unit_pool import CHIPS, components_of_chips


#: Names of ports, then one type for all of them or one for each.
ENTRY = re.compile(r"(?P<names>\w+(?:, \w+)*)(?: : (?P<types>\S.*))?")
TYPE = re.compile(r"(?P<flow>In|Out)(?:\((?P<shape>.*)\))?")


@pytest.fixture(scope="module")
def components():
    """Return the components of all chips by their class."""
    return components_of_chips()


def documented(kind):
    """Return the ports that the docstring of a component lists, each with its type."""
    section = (inspect.getdoc(kind) or "").partition("\nMembers\n-------\n")[2]
    return ports_in(re.split(r"\n\n\w+\n-+\n", section)[0])


def ports_in(text):
    """Return the ports that some lines list, each with its type."""
    ports = {}
    for line in text.splitlines():
        for entry in map(ENTRY.fullmatch, re.split(r"(?<=In|ut|.\)), (?=\w+ : )", line)):
            if entry is None:
                continue
            names = entry["names"].split(", ")
            types = re.split(r", (?=In\b|Out\b)", entry["types"] or "")
            assert len(types) in (1, len(names)), entry[0]
            ports |= zip(names, types * len(names) if len(types) == 1 else types, strict=True)
    return ports


def width_of(text, names):
    """Return the width of a shape as written in a docstring; None if it is more than a number."""
    try:
        return Shape.cast(eval(text, names)).width
    except (NameError, SyntaxError, TypeError, AttributeError):
        return None


def compare(members, ports, names):
    """Return the documented ``ports`` that differ, and the number of widths compared."""
    wrong, compared = [], 0
    for name, member in members.items():
        if not ports.get(name):
            continue
        written = TYPE.match(re.sub(r"\.array\(.*", "", ports[name]))
        width = width_of(written["shape"] or "", names) if member.is_port else None
        compared += width is not None
        same = width is None or width == Shape.cast(member.shape).width
        if written["flow"] != member.flow.name or not same:
            wrong.append((name, ports[name]))
    return wrong, compared


@pytest.mark.ci
def test_every_port_is_documented(components):
    wrong = []
    for kind, instances in components.items():
        if "Those of :func:" in kind.__doc__ or "    See :func:" in kind.__doc__:
            continue
        ports = {name for each in instances for name in each.signature.members}
        if ports != documented(kind).keys():
            wrong.append((kind.__name__, sorted(ports ^ documented(kind).keys())))
    assert wrong == []
    assert len(components) > 60


def test_directions_and_widths_are_as_documented(components):
    wrong, compared = [], 0
    for kind, instances in components.items():
        for component in instances:
            names = {**vars(sys.modules[kind.__module__]), **vars(component)}
            found, number = compare(component.signature.members, documented(kind), names)
            wrong += [(kind.__name__, *each) for each in found]
            compared += number
    assert wrong == []
    # Layouts that a docstring names by the function that makes them are not compared.
    assert compared > 600


@pytest.mark.parametrize("config", CHIPS[:3], ids=["core", "two-tier", "parallel"])
def test_shared_members_are_as_documented(config):
    sizes = {name: getattr(config, name) for name in ("mutators", "patches", "candidates")}
    optional = {"redrawn", "left_out"} if config.checker is CheckerBuild.NONE else set()
    for members, function, missing in (
        (generation_signature(config).members, generation_signature, optional),
        (payload_members(), payload_members, set()),
    ):
        ports = ports_in(inspect.getdoc(function))
        assert ports.keys() - missing == set(members)
        wrong, compared = compare(members, ports, sizes)
        assert wrong == []
        assert compared >= len(members) - 1

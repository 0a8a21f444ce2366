"""Whose route a plan of ``ga-chip`` has, in words."""

import pytest

from pathgene.host.cli.compare import _explanation
from pathgene.host.report.routes import route_from, route_note, route_pairs
from pathgene.host.web.desk.results import _column
from pathgene.host.web.figures import captions
from tests.support.host.web_plans import planned


def of(route, chip=1.5, astar=1.52):
    return {"hardware": {"route_from": route, "routes": {"chip": chip, "astar": astar}}}


@pytest.mark.parametrize(
    ("summary", "found", "note"),
    [
        (of("chip"), "chip", ""),
        (of("astar"), "astar", "route of astar"),
        (of(None), None, ""),
        ({"hardware": None}, None, ""),
        ({"hardware": {"plan_us": 1.0}}, None, ""),
        ({"hardware": None, "legs": [of("astar"), of("astar")]}, "astar", "route of astar"),
        (
            {"hardware": None, "legs": [of("astar"), of("chip"), {}, of(None)]},
            "chip and astar",
            "route of chip and astar",
        ),
    ],
)
def test_the_route_of_a_plan_and_of_a_mission(summary, found, note):
    assert route_from(summary) == found
    assert route_note(found) == note


@pytest.mark.parametrize(
    ("summary", "rows"),
    [
        (of("astar"), ["of astar; the chip's own has fitness 1.5000"]),
        (of("astar", chip=None), ["of astar; the chip's own is not feasible"]),
        (of("chip"), ["of the chip; astar's has fitness 1.5200"]),
        (of("chip", astar=None), ["of the chip"]),
        (of(None), []),
        ({"hardware": None}, []),
        (of("chip") | {"legs": [of("chip")]}, []),
    ],
)
def test_the_row_of_the_command(summary, rows):
    assert route_pairs(summary) == [("route", text) for text in rows]


def test_page_and_desk_name_the_route():
    summary = planned("plain").summary | {"planner": "ga-chip"} | of("astar")
    assert "planned by ga-chip, route of astar" in captions(summary)[1]
    assert _column(summary, is_earlier=False)["Planner"] == "ga-chip, route of astar"


def test_a_comparison_counts_the_routes_of_astar():
    runs = [of("astar"), of("chip"), of("astar"), {"hardware": None}]
    report = {"seeds": [0, 3], "pairs": [], "planners": [{"label": "ga-chip", "runs": runs}]}
    assert _explanation(report).splitlines()[-1] == (
        "ga-chip: the path is the route of astar in 2 of 4 runs; :polish=chip compares "
        "the chip's own."
    )
    report["planners"][0]["runs"] = [of("chip")]
    assert "astar" not in _explanation(report)

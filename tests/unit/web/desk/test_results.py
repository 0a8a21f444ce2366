"""The table of figures of two plans."""

from pathlib import Path

from pathgene.host.web.desk.results import PlanView, rows_of
from tests.support.host.web_plans import planned


def view(kind, **changes):
    return PlanView(planned(kind).summary | changes, {}, Path(), "saved")


def test_figures_of_two_plans_stand_in_one_row():
    one = view("plain")
    other = view("mission", fallback="astar", hardware={"plan_us": 62_400.0})
    rows = dict(rows_of([one, other]))
    assert rows["Planner"][1].endswith(", then astar")
    assert rows["Verdict"][0] == "✓ feasible"
    assert rows["Fitness"] == [f"{each.summary['fitness']:.4f}" for each in (one, other)]
    # A value that one of them lacks is left blank.
    assert rows["Time of the chip"] == ["–", "62.4 ms"]
    assert rows["Leg 1"][0] == "–"
    assert all(len(texts) == 2 for texts in rows.values())


def test_a_plan_alone_has_no_open_places():
    assert all("–" not in texts for _, texts in rows_of([view("plain")]))

"""The table of replans in flight."""

from bench.replan_report import report


TOLD = {"alive": True, "ended": "arrived", "zone": None, "clearance": 30.0, "changes": []}


def change(active_ms, *attempts, at_once=True, needed=True, held=False):
    """Return a change; an attempt is a planner and its milliseconds on chip and line."""
    return {
        "at_s": 50.0,
        "what": "a zone appears",
        "needed": needed,
        "active_ms": active_ms,
        "flown_m": 0.3,
        "held": held,
        "fitness": 1.4,
        "measured_ms": 7.0,
        "at_once": at_once,
        "attempts": [[*attempt, 3.0, 7.0, 0.0, None] for attempt in attempts],
    }


def cells(flights, yardstick):
    table = report({"chip": flights}, yardstick, len(flights))
    return dict(zip(table.columns, table.rows[0], strict=True)), table.data["failures"]


def test_what_cannot_be_survived_does_not_count():
    arrived, holding, dead = TOLD, TOLD | {"ended": "holding"}, TOLD | {"alive": False}
    yardstick = {0: arrived, 1: holding, 2: dead, 3: arrived}
    row, failures = cells({0: arrived, 1: holding, 2: dead, 3: holding}, yardstick)
    assert row["survived, of the yardstick's survivals"] == "2 of 3 (66.7 %)"
    assert [failure["scenario"] for failure in failures] == [3]


def test_where_there_is_a_path_at_once():
    changes = [
        change(12.0, ("ga-chip", 2.0)),
        change(30.0, ("ga-chip", 4.0), ("ga-chip", 1.0)),
        # No ample search finds one at that instant; the board is lost; not needed.
        change(99.0, ("ga-chip", 90.0), at_once=False),
        change(300.0, ("ga-chip", 0.0), ("astar", 0.0)),
        change(99.0, ("ga-chip", 90.0), needed=False),
        # The aircraft waits on a circle, or there never is a path.
        change(700.0, ("ga-chip", 80.0), held=True),
        change(None, ("ga-chip", 3.0), held=True),
    ]
    row, _ = cells({0: TOLD | {"changes": changes}}, {0: TOLD})
    assert row["where there is a path at once"] == "4 of 6"
    assert row["chip and line ms there"] == "5.00 / never / never / never"
    assert row["new path there after ms"] == "30.0 / never / never / never"

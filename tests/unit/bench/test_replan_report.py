"""The table of replans in flight."""

from bench.replan_report import report


TOLD = {"alive": True, "ended": "arrived", "zone": None, "clearance": 30.0, "changes": []}


def change(active_ms, *attempts, at_s=50.0, needed=True, held=False):
    """Return a change; an attempt is a planner and its milliseconds of chip and line."""
    return {
        "at_s": at_s,
        "what": "a zone appears",
        "needed": needed,
        "active_ms": active_ms,
        "flown_m": 0.3,
        "held": held,
        "fitness": 1.4,
        "measured_ms": 7.0,
        "attempts": [[*attempt, 3.0, 7.0, 0.0, None] for attempt in attempts],
    }


def cells(flights, yardstick):
    table = report({"chip": flights}, yardstick, len(flights))
    return dict(zip(table.columns, table.rows[0], strict=True)), table.data["failures"]


def test_what_cannot_be_survived_does_not_count():
    arrived, holding, dead = TOLD, TOLD | {"ended": "holding"}, TOLD | {"alive": False}
    yardstick = {0: arrived, 1: holding, 2: dead, 3: arrived}
    row, failures = cells({0: arrived, 1: holding, 2: dead, 3: holding}, yardstick)
    assert row["survived of what the yardstick survives"] == "2 of 3 (66.7 %)"
    assert [failure["scenario"] for failure in failures] == [3]


def test_where_the_yardstick_has_a_path_at_once():
    def flown(*changes):
        return TOLD | {"changes": list(changes)}

    at_once = change(0.0, ("astar", 0.0))
    late = change(900.0, ("astar", 0.0), ("astar", 0.0))
    yardstick = {
        0: flown(at_once),
        1: flown(change(None, at_s=20.0, needed=False), at_once, at_once),
        2: flown(late),
        3: flown(at_once),
        4: flown(at_once),
        5: flown(at_once),
    }
    chip = {
        0: flown(change(12.0, ("ga-chip", 2.0)), change(99.0, ("ga-chip", 90.0))),
        1: flown(change(30.0, ("ga-chip", 4.0), ("ga-chip", 1.0))),
        2: flown(change(99.0, ("ga-chip", 90.0))),
        # The board is lost; a circle; of another moment.
        3: flown(change(300.0, ("ga-chip", 0.0), ("astar", 0.0))),
        4: flown(change(700.0, ("ga-chip", 80.0), held=True)),
        5: flown(change(99.0, ("ga-chip", 90.0), at_s=51.0)),
    }
    row, _ = cells(chip, yardstick)
    assert row["where there is a path at once: chip and line ms"] == "3.50 / 4.85 / 4.97 / 5.00"
    assert row["and new path after ms"] == "21.0 / 29.1 / 29.8 / 30.0"

"""Names of the points of a mission."""

import numpy as np

from pathgene.host.report.marks import mark_names, marked_waypoints


A, B, C, D = (0.0, 0.0, 1.0), (9.0, 0.0, 2.0), (9.0, 9.0, 3.0), (5.0, 5.0, 4.0)


def test_names_every_mission():
    assert mark_names((A, B)) == ("Start", "Goal")
    assert mark_names((A, B, C)) == ("Start", "Via 1", "Goal")
    assert mark_names((A, B, C, D)) == ("Start", "Via 1", "Via 2", "Goal")
    assert mark_names((A, B, A)) == ("Start", "Goal", "Return")
    assert mark_names((A, B, C, A)) == ("Start", "Via 1", "Goal", "Return")


def test_finds_the_waypoints_in_the_order_of_the_mission():
    path = np.array([A, D, B, D, C, A])
    assert marked_waypoints(path, (A, B, D, C, A)) == {
        0: "Start",
        2: "Via 1",
        3: "Via 2",
        4: "Goal",
        5: "Return",
    }
    assert marked_waypoints(path, (A, A)) == {0: "Start", 5: "Goal"}


def test_a_point_that_is_missed_has_no_waypoint():
    path = np.array([A, (9.0, 0.0, 2.02), C, D])
    assert marked_waypoints(path, (A, B, C, D)) == {0: "Start", 2: "Via 2", 3: "Goal"}

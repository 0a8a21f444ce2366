"""Pictures of checked missions: every fault is marked at its place, with its number."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.text import Text

from pathgene.host.mission.foreign.drawn import drawn_flight
from pathgene.host.mission.foreign.picture import draw
from pathgene.host.problem.zones import Circle
from pathgene.host.report.style import TROUBLE
from tests.support.host.foreign import PLAIN, item
from tests.support.host.pictures import assert_texts_apart
from tests.support.host.planted_missions import CELL_M, LOITER_TURNS


# A peak on the leg east, a zone on the leg north.
PEAK, ZONE = (2400.0, 1500.0), (4500.0, 3000.0)
ITEMS = [item(16, (900, 1500), 420), item(16, (4500, 1500), 420), item(16, (4500, 4500), 420)]


@pytest.fixture
def two(check):
    """Return the check of a mission with a peak on its first leg and a zone on its second."""
    heights = PLAIN.copy()
    row, column = round(PEAK[1] / CELL_M), round(PEAK[0] / CELL_M)
    heights[row - 2 : row + 3, column - 2 : column + 3] = 460.0
    heights[row, column] = 480.0
    return check(ITEMS, heights, zones=(Circle(*ZONE, 200.0, name="mast"),))


def marks(axes):
    """Return the places of the marks of faults, in kilometres."""
    return [
        tuple(float(each[0]) for each in line.get_data())
        for line in axes.get_lines()
        if line.get_marker() == "o" and to_hex(line.get_markerfacecolor()) == TROUBLE
    ]


def numbers(axes):
    """Return the texts of the marks with their middles in pixels."""
    return {
        text.get_text(): np.mean(Text.get_window_extent(text), axis=0)
        for text in axes.texts
        if text.get_text()[:1].isdigit()
    }


def red(axes):
    """Return the points of lines that break a limit, in kilometres."""
    lines = [line for line in axes.get_lines() if line.get_color() == TROUBLE]
    points = np.concatenate([line.get_xydata() for line in lines if len(line.get_xdata()) > 1])
    return points[np.isfinite(points).all(axis=1)]


def test_faults_are_marked_on_the_map_with_the_numbers_of_the_list(two):
    figure = draw(two, "m.plan")
    figure.canvas.draw()
    assert_texts_apart(figure)
    plan = figure.axes[0]
    assert [line[:2] for line in two.lines] == ["1.", "2."]
    assert [line.split(": ")[1].split()[0] for line in two.lines] == ["clearance", "zone"]
    peak, zone = marks(plan)
    assert peak == pytest.approx(np.divide(PEAK, 1000), abs=0.09)
    assert zone == pytest.approx(np.divide(ZONE, 1000), abs=0.21)
    texts = numbers(plan)
    assert set(texts) == {"1", "2"}
    for text, place in (("1", peak), ("2", zone)):
        assert np.hypot(*(texts[text] - plan.transData.transform(place))) < 0.7 * figure.dpi


def test_faults_are_marked_in_the_profile_where_they_are_flown(two):
    profile = draw(two, "m.plan").axes[2]
    peak, zone = marks(profile)
    # Straight to the peak; the corner before the zone is rounded with a radius of 150 m.
    corner_m = 2 * 150 - 150 * np.pi / 2
    assert peak == pytest.approx((1.5, 420), abs=0.09)
    assert zone[0] == pytest.approx((3600 - corner_m + ZONE[1] - 1500) / 1000, abs=0.21)
    assert zone[1] == pytest.approx(420)
    assert set(numbers(profile)) == {"1", "2"}


def test_red_lines_are_the_stretches_of_the_faults(two):
    plan = draw(two, "m.plan").axes[0]
    points = red(plan) * 1000
    first = points[points[:, 1] < 1600]
    second = points[points[:, 1] > 1600]
    ends = [
        (points.min() - begin, points.max() - begin)
        for points, begin in ((first[:, 0], 900), (second[:, 1], 1500))
    ]
    assert ends == [pytest.approx(fault.span_m, abs=3) for fault in two.faults]
    # Around the peak, and the zone with its margin.
    assert ends[0] == pytest.approx((1500 - 100, 1500 + 100), abs=40)
    assert ends[1] == pytest.approx((1500 - 215, 1500 + 215), abs=10)


def test_neighbouring_faults_share_a_text_and_keep_their_marks(check):
    items = [item(16, (900, 1500), 420), *(item(16, (3000 + 8 * i, 1500), 380) for i in range(4))]
    heights = PLAIN.copy()
    heights[:, round(2900 / CELL_M) :] = 400.0
    found = check([*items, item(16, (6000, 1500), 450)], heights)
    assert len(found.faults) > 3
    plan = draw(found, "m.plan").axes[0]
    assert len(marks(plan)) == len(found.faults)
    assert any("-" in text for text in numbers(plan))


def test_a_flight_of_two_parts_is_interrupted_between_them(check):
    items = [*ITEMS[:2], item(21, (3000, 3000), 300), item(16, (900, 3000), 420), ITEMS[2]]
    found = check(items)
    assert len(found.flight.chains) == 2
    samples = drawn_flight(found).samples
    (gap,) = np.flatnonzero(np.isnan(samples.s))
    assert (samples.x[gap - 1], samples.y[gap - 1]) == pytest.approx((3000, 3000), abs=0.1)
    assert (samples.x[gap + 1], samples.y[gap + 1]) == pytest.approx((900, 3000), abs=0.1)
    assert samples.s[gap + 1] == samples.s[gap - 1]
    draw(found, "m.plan")


def test_a_mission_without_a_leg_shows_its_circle(check):
    found = check([item(LOITER_TURNS, (3000, 3000), 310, params=(1, 0, 200, 0))])
    assert found.faults
    figure = draw(found, "m.plan")
    plan, _, profile = figure.axes
    assert len(marks(plan)) == len(found.faults)
    assert [text.get_text() for text in profile.texts] == ["no leg is flown"]
    (circle,) = [each for each in plan.patches if getattr(each, "radius", 0) == 0.2]
    assert circle.center == pytest.approx((3.0, 3.0))


def test_a_fault_beyond_the_edge_of_the_map_is_in_the_picture(check):
    found = check([*ITEMS[:2], item(16, (6500, 1500), 420)])
    (fault,) = found.faults
    assert fault.limit == "map"
    plan = draw(found, "m.plan").axes[0]
    assert marks(plan) == [pytest.approx((6.5, 1.5), abs=0.01)]
    assert plan.get_xlim()[1] > 6.6
    assert set(numbers(plan)) == {"1"}

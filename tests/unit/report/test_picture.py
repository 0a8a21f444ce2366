"""The picture of a path, for every shape of map: texts, places, proportions."""

import itertools
import math
import warnings
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.legend import Legend
from matplotlib.offsetbox import AnchoredOffsetbox
from matplotlib.text import Text
from matplotlib.transforms import Bbox

from pathgene.host.diagnosis import diagnose
from pathgene.host.evaluation import Evaluator
from pathgene.host.mission.mission import MissionProblem
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.report import plan_view, style
from pathgene.host.report.picture import Scene, draw
from pathgene.host.report.placing import label
from pathgene.host.report.plan_view import axis_unit, nice_length
from pathgene.host.terrain import Terrain
from tests.support.host.pictures import assert_texts_apart, texts_of


WORLDS = {
    "square": {"shape": (61, 61)},
    "tall": {"shape": (90, 25)},
    "very tall": {"shape": (120, 16)},
    "tall ribbon": {"shape": (900, 30)},
    "wide ribbon": {"shape": (30, 900)},
    "wide": {"shape": (25, 90)},
    "slightly wide": {"shape": (31, 61)},
    "alps": {"shape": (61, 61), "side_m": 900.0, "relief": 4000.0},
    "flat": {"shape": (41, 61), "relief": 0.0},
    "voids": {"shape": (61, 61), "void": True},
    "infeasible": {"shape": (61, 61), "height_m": -400.0},
    "small": {"shape": (21, 31), "side_m": 12.0, "relief": 9.0, "nofly": False},
    "not searched": {"shape": (61, 61), "history": 0},
}
BY_RULES = {
    "square, by rules": {"shape": (61, 61)},
    "tall, by rules": {"shape": (90, 25)},
    "wide, by rules": {"shape": (25, 90)},
    "infeasible, by rules": {"shape": (61, 61), "height_m": -400.0},
    "voids, by rules": {"shape": (61, 61), "void": True},
}


@pytest.fixture(scope="module", params=[*WORLDS, *BY_RULES])
def scene(request, make_run):
    as_paper = request.param in WORLDS
    world = (WORLDS if as_paper else BY_RULES)[request.param]
    evaluator, result = make_run(**world, as_paper=as_paper)
    return Scene(
        evaluator,
        result.path,
        result.evaluation,
        result.history,
        "Title of the picture",
        "feasible, fitness 1.5177, 55.31 km, mean altitude 2,526 m, fuel 1.335 N",
    )


@pytest.fixture(scope="module")
def figure(scene):
    figure = draw(scene)
    figure.canvas.draw()
    return figure


def test_legends_cover_no_other_text(figure):
    renderer = figure.canvas.get_renderer()
    legends = figure.findobj(Legend)
    assert legends
    for legend in legends:
        box = legend.get_window_extent(renderer)
        own = {text.get_text() for text in legend.get_texts()}
        for text, other in texts_of(figure):
            assert text in own or not box.overlaps(other), text


def test_texts_neither_overlap_nor_leave_the_figure(figure):
    assert_texts_apart(figure)


def test_map_keeps_its_proportions(figure):
    plan = figure.axes[0]
    box = plan.get_window_extent()
    (left, right), (bottom, top) = plan.get_xlim(), plan.get_ylim()
    assert box.width / box.height == pytest.approx((right - left) / (top - bottom), rel=0.01)
    others = [axes.get_window_extent() for axes in figure.axes[1:]]
    assert not any(box.overlaps(other) for other in others)


def test_names_what_it_shows(scene, figure):
    shown = [text for text, _ in texts_of(figure)]
    evaluation = scene.evaluation
    for text in (
        "Plan view",
        "height of the ground (m)",
        "Altitude along the path",
        "start",
        "goal",
        "N",
        "Title of the picture",
        f"minimum clearance {evaluation.minimum_clearance_m:,.1f} m",
    ):
        assert shown.count(text) == 1, text
    for text in ("Convergence", "feasible above 1"):
        assert shown.count(text) == bool(scene.history), text
    assert len(figure.axes) == 3 + bool(scene.history)
    flyable = evaluation.distance_under_terrain_m == 0
    if not scene.evaluator.problem.as_paper:
        flyable = evaluation.feasible
        reasons = [text for text in shown if text.startswith("Not feasible: ")]
        assert len(reasons) == (not flyable)
    assert ("not flyable" in shown) == (not flyable)
    voids = np.isnan(scene.evaluator.problem.terrain.elevation).any()
    assert ("void" in shown) == voids
    assert ("no-fly zone" in shown) == bool(scene.evaluator.problem.zones)
    if scene.history:
        # The strict verdict may count less than the search did.
        assert any(text.startswith(f"best {scene.history[-1][1]:.4f}") for text in shown)


def test_scale_and_north_cover_no_end_of_the_path(scene, figure):
    (box,) = figure.axes[0].findobj(AnchoredOffsetbox)
    window = box.get_window_extent()
    assert {text.get_text() for text in box.findobj(Text)} >= {"N"}
    assert figure.axes[0].get_window_extent().padded(1).containsx(window.x0)
    unit_m = axis_unit(
        max(scene.evaluator.problem.terrain.width_m, scene.evaluator.problem.terrain.height_m)
    )[0]
    for end in scene.path[[0, -1], :2] / unit_m:
        x, y = figure.axes[0].transData.transform(end)
        assert not window.padded(10).contains(x, y)


def test_the_reason_of_the_search_comes_before_the_worst_limit(make_run):
    evaluator, result = make_run(height_m=-400.0)
    scene = Scene(evaluator, result.path, result.evaluation, [], "", "", {"sentence": "The wall."})
    assert "No path: The wall." in [t.get_text() for t in draw(scene).findobj(Text)]


@pytest.mark.parametrize("kind", ["closed", "climb"])
def test_marks_the_ring_and_the_place_of_a_diagnosis(kind):
    heights = np.full((40, 40), 100.0)
    zones = ()
    if kind == "closed":
        zones = (Polygon(((1400, -50), (1600, -50), (1600, 4000), (1400, 4000)), name="W"),)
    else:
        heights[:] = 900.0
        heights[3:8, 3:8] = 100.0
    terrain = Terrain("made", heights, 100.0, 100.0)
    ends = (500.0, 500.0, 200.0), (3000.0, 3000.0, 1100.0)
    problem = Problem(terrain, *ends, zones=zones)
    reason = diagnose(problem).to_dict()
    assert reason["code"] == kind
    evaluator = Evaluator(problem, threads=1)
    path = np.array(ends)
    figure = draw(Scene(evaluator, path, evaluator.evaluate(path), [], "T", "s", reason))
    figure.canvas.draw()
    assert_texts_apart(figure)
    lines = [np.array(line.get_xydata()) for line in figure.axes[0].get_lines()]
    place = np.array(reason["place"]) / 1000
    assert any(line.shape == (1, 2) and np.allclose(line[0], place) for line in lines)
    for ring in reason["ring"]:
        ring = np.array(ring) / 1000
        assert any(line.shape == ring.shape and np.allclose(line, ring) for line in lines)
    shown = [text for text, _ in texts_of(figure)]
    assert ("closing ring" in shown) == (kind == "closed") == bool(reason["ring"])
    assert any(text.startswith("No path: ") for text in shown)
    # The broken zone has one text on the map, not its name and the limit's.
    on_map = [text.get_text() for text in figure.axes[0].texts]
    assert "W" not in on_map
    assert on_map.count("zone W") == (kind == "closed")


def test_many_zones_are_one_patch_without_texts():
    terrain = Terrain("made", np.full((40, 40), 100.0), 100.0, 100.0)
    ends = (500.0, 500.0, 200.0), (3000.0, 3000.0, 200.0)
    evaluators = [
        Evaluator(
            Problem(terrain, *ends, zones=[Circle(20.0 * i, 3500.0, 9.0, name="Z")] * count),
            threads=1,
        )
        for i, count in enumerate((200, 201))
    ]
    drawn = [
        draw(Scene(evaluator, np.array(ends), evaluator.evaluate(np.array(ends)), [], "T", "s"))
        for evaluator in evaluators
    ]
    few, many = (len(figure.axes[0].patches) for figure in drawn)
    assert few - many == 199 + 200, "each of few zones, and its margin"
    assert ["Z" in [text.get_text() for text in fig.axes[0].texts] for fig in drawn] == [
        True,
        False,
    ]


@pytest.fixture
def axes():
    figure = Figure(figsize=(6, 5))
    FigureCanvasAgg(figure)
    return figure.add_axes((0, 0, 1, 1), xlim=(0, 6), ylim=(0, 5))


def test_labels_avoid_what_is_taken_and_are_left_out_without_room(axes):
    first = label(axes, [(3, 2.5)], "clearance", [])
    second = label(axes, [(3, 2.5)], "clearance", [first])
    assert not first.overlaps(second)
    assert label(axes, [(3, 2.5)], "clearance", [axes.get_window_extent()]) is None
    assert len(axes.texts) == 2


def test_labels_keep_off_lines_where_there_is_room(axes):
    level = np.stack((np.linspace(0, 6, 200), np.full(200, 2.5)), axis=1)
    place = [(3.0, 2.5)]

    def covers(box):
        x, y = axes.transData.transform(level).T
        return bool(((box.x0 <= x) & (x <= box.x1) & (box.y0 <= y) & (y <= box.y1)).any())

    assert covers(label(axes, place, "clearance", []))
    assert not covers(label(axes, place, "clearance", [], lines=level))
    # If there are lines everywhere, the text is still drawn, at the first place.
    everywhere = np.stack([axis.ravel() for axis in np.mgrid[:6:0.05, :5:0.05]], axis=1)
    box = label(axes, place, "clearance", [], lines=everywhere)
    assert box.bounds == label(axes, place, "clearance", []).bounds


def test_labels_take_the_next_place_where_the_first_is_full(axes):
    full = Bbox([[0, 0], axes.transData.transform((3, 5))])
    box = label(axes, [(1.0, 2.5), (5.0, 2.5)], "clearance", [full])
    assert box.x0 > full.x1
    assert axes.texts[-1].xy == (5.0, 2.5)


@pytest.mark.parametrize("free", [(0, 0), (0, 1), (1, 0), (1, 1)])
def test_scale_and_north_avoid_a_path_through_three_corners(free):
    figure = Figure(figsize=(6, 5))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.1, 0.1, 0.8, 0.8), xlim=(0, 6), ylim=(0, 5))
    x, y = free
    corners = np.array([(1 - x, y), (1 - x, 1 - y), (x, 1 - y)]) * (5.7, 4.7) + 0.15
    along = np.linspace(corners[:-1], corners[1:], 200).reshape(-1, 2)
    plan_view._draw_scale_and_north(axes, along, 1000.0)
    (box,) = axes.findobj(AnchoredOffsetbox)
    window = box.get_window_extent().padded(20)
    assert not any(window.contains(*point) for point in axes.transData.transform(along))


def test_reports_that_the_best_was_not_chosen(make_run):
    evaluator, result = make_run()
    history = [[0, 1.5, 1.0], [1, result.evaluation.fitness + 0.25, 1.0]]
    figure = draw(Scene(evaluator, result.path, result.evaluation, history, "", ""))
    best, chosen = history[-1][1], result.evaluation.fitness
    assert f"best {best:.4f}, chosen {chosen:.4f}" in [t.get_text() for t in figure.findobj(Text)]


def test_the_legs_of_a_mission_converge_one_by_one(make_run):
    """Lines are not joined across legs; a leg of one generation is a point; each has a figure."""
    evaluator, result = make_run()
    history = [[0, 0.5, 0.1], [1, 1.5, 1.0], [2, 1.25, 1.25], [3, 0.25, 0.1], [4, 1.75, 1.0]]
    figure = draw(
        Scene(
            evaluator,
            result.path,
            result.evaluation,
            history,
            "",
            "",
            legs=[(0, 1.5), (2, 1.375), (3, 1.75)],
        )
    )
    figure.canvas.draw()
    assert_texts_apart(figure)
    axes = figure.axes[3]
    best = [line for line in axes.get_lines() if line.get_color() == style.BEST]
    assert [line.get_xdata().tolist() for line in best] == [[0, 1], [2], [3, 4]]
    assert [line.get_marker() for line in best] == ["None", "o", "None"]
    shown = [text for text, _ in texts_of(figure)]
    assert "chosen 1.5000, 1.3750, 1.7500" in shown
    assert shown.count("best") == 1


def test_generations_without_a_row_lie_between_points(make_run):
    evaluator, result = make_run()
    history = [[0, 0.5, 0.1], [10_000, 1.5, 1.25]]
    figure = draw(Scene(evaluator, result.path, result.evaluation, history, "", ""))
    lines = [line for line in figure.axes[3].get_lines() if len(line.get_xdata()) == 2]
    drawn = {line.get_color(): line.get_marker() for line in lines}
    assert (drawn[style.BEST], drawn[style.MEAN]) == ("o", "o")


def test_png(make_run, tmp_path):
    evaluator, result = make_run()
    file = tmp_path / "path.png"
    style.save(
        draw(Scene(evaluator, result.path, result.evaluation, result.history, "a", "b")), file
    )
    rows, columns, _ = imread(file).shape
    assert columns >= 1920
    assert rows >= 1080


@pytest.mark.parametrize(
    ("span", "length"),
    [(4, 1), (7.9, 1), (8, 2), (20, 5), (39.9, 5), (40, 10), (0.5, 0.1), (1500, 200)],
)
def test_scale_bar_is_round(span, length):
    assert nice_length(span) == pytest.approx(length)


def test_units_follow_the_span():
    assert axis_unit(1999) == (1.0, "m")
    assert axis_unit(2000) == (1000.0, "km")


def luminance(colour):
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return np.dot(linear, (0.2126, 0.7152, 0.0722))


def test_land_grows_lighter_with_height():
    ramp = [luminance(style.LAND(level)[:3]) for level in np.linspace(0, 1, 64)]
    assert all(low < high for low, high in itertools.pairwise(ramp))


@pytest.mark.parametrize("colour", [style.PATH, style.NOFLY, style.TEXT, style.TROUBLE])
def test_strong_colours_stand_out_on_white(colour):
    # The contrast that web guidelines require of text.
    assert 1.05 / (luminance(colour) + 0.05) > 4.5
    assert math.isfinite(luminance(colour))


def test_broken_stretches_stand_out_from_the_path_in_grey():
    assert (luminance(style.TROUBLE) + 0.05) / (luminance(style.PATH) + 0.05) > 1.5


def test_without_a_reason_the_map_begins_below_the_titles(make_run):
    """Each line that says why a path is not feasible needs its own height."""
    tops = []
    for sentence in ("", "The wall.", "The wall of the valley. " * 9):
        evaluator, result = make_run(height_m=-400.0)
        evaluation = replace(result.evaluation, feasible=not sentence)
        reason = {"sentence": sentence}
        scene = Scene(evaluator, result.path, evaluation, [], "Title", "subtitle", reason)
        figure = draw(scene)
        figure.canvas.draw()
        assert_texts_apart(figure)
        texts = dict(texts_of(figure))
        above = min(box.y0 for text, box in texts.items() if text.startswith(("No path", "subt")))
        # The title of the map is close below, within half an inch.
        assert 0 < above - texts["Plan view"].y1 < 0.5 * figure.dpi
        tops.append(figure.axes[0].get_window_extent().y1)
        assert tops[-1] == pytest.approx(figure.axes[2].get_window_extent().y1)
    assert tops[0] > tops[1] > tops[2]


def test_arrows_show_the_fixed_headings(make_run):
    evaluator, result = make_run()
    old = evaluator.problem
    problem = Problem(old.terrain, old.start, old.goal, start_heading_deg=90, goal_heading_deg=30)
    evaluator = Evaluator(problem, threads=1)
    scene = Scene(evaluator, result.path, evaluator.evaluate(result.path), [], "", "")
    plan = draw(scene).axes[0]
    arrows = [note for note in plan.texts if note.arrow_patch is not None]
    assert [note.xy for note in arrows] == [
        pytest.approx(np.array(end[:2]) / 1000) for end in (problem.start, problem.goal)
    ]
    for note, heading_deg in zip(arrows, (90, 30), strict=True):
        east, north = note.get_position()
        assert math.degrees(math.atan2(east, north)) == pytest.approx(heading_deg)
        # The arrow's head is at the end where the text is.
        assert note.arrowprops["arrowstyle"] == "<|-"
    free = draw(replace(scene, evaluator=Evaluator(old, threads=1))).axes[0]
    assert not [note for note in free.texts if note.arrow_patch is not None]


@pytest.mark.parametrize("return_to_start", [False, True])
def test_map_profile_and_legend_tell_start_via_points_and_goal_apart(return_to_start):
    terrain = Terrain("flat", np.full((40, 50), 100.0), 100.0, 100.0)
    start, via, goal = (500.0, 500.0, 200.0), (2500.0, 700.0, 250.0), (2800.0, 3000.0, 300.0)
    mission = MissionProblem(Problem(terrain, start, goal), [via], return_to_start)
    path = np.array(mission.way)
    evaluator = Evaluator(mission.whole, threads=1)
    figure = draw(Scene(evaluator, path, evaluator.evaluate(path), [], "Title", "subtitle"))
    figure.canvas.draw()
    assert_texts_apart(figure)

    def marked(axes):
        return {
            line.get_marker(): line.get_xydata()
            for line in axes.get_lines()
            if line.get_marker() in tuple("oD*") and line.get_color() in (style.START, style.GOAL)
        }

    on_map = marked(figure.axes[0])
    for mark, point in zip("oD*", (start, via, goal), strict=True):
        assert on_map.pop(mark) == pytest.approx(np.array([point[:2]]) / 1000)
    assert not on_map
    along = marked(figure.axes[2])
    assert set(along) == ({"D", "*"} if return_to_start else {"D"})
    # The turn at a waypoint passes inside it, and below a peak of the altitudes.
    ((x, z),) = along["D"]
    assert x == pytest.approx(2.01, abs=0.1)
    assert z == pytest.approx(250, abs=15)
    shown = [text for text, _ in texts_of(figure)]
    first = "start and end" if return_to_start else "start"
    assert [shown.count(text) for text in (first, "via point", "goal")] == [1, 1, 1]


def test_names_in_any_script_print_no_warning(make_run, tmp_path):
    evaluator, result = make_run(**WORLDS["small"])
    circle = Circle(120.0, 120.0, 60.0, name="\u7981\u6b62\u533a")
    problem = replace(evaluator.problem, zones=(circle,))
    scene = Scene(Evaluator(problem), result.path, result.evaluation, (), "\u6771\u4eac", "")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        style.save(draw(scene), tmp_path / "path.png")
        assert [str(each.message) for each in caught] == []
        # The letters are in the picture, and the font lacks them.
        figure = draw(scene)
        assert any("\u7981" in text for text, _ in texts_of(figure))
        figure.canvas.draw()
    assert any("missing from font" in str(each.message) for each in caught)

"""The picture of a run: plan view over hillshade, altitude profile and convergence."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pathgene.host.evaluation import Evaluation, Evaluator, Samples
from pathgene.host.evaluation.broken import Stretch
from pathgene.host.evaluation.evaluator import FINE
from pathgene.host.report import convergence, hand_over_view, plan_view, points, profile
from pathgene.host.report.along import broken_samples, surface_and_demand
from pathgene.host.report.along import why as why_not
from pathgene.host.report.handed_over import HandedOver
from pathgene.host.report.style import LEFT, NARROWEST, RIGHT, TROUBLE, WIDTH, any_letters, frame
from pathgene.host.report.via import visits


__all__ = ["LINE", "TOP", "Scene", "draw", "layout"]

_WIDE = 2.2  # Maps with a higher aspect ratio are placed above the two graphs.
_WIDEST = 6.5  # Frames of maps wider than this have room next to the map.
# In inches: the margins of titles and legend, and a line that says why a path is not feasible.
TOP, _BOTTOM, LINE = 1.2, 1.0, 0.2
# Positions of a ceiling's text, as shares of the profile's width, best first.
_ASIDE = (0.75, 0.5, 0.25, 0.9, 0.1)
_MOST_REASONS = 12  # Number of stretches that are named, longest first.


@dataclass(frozen=True)
class Scene:
    """The content of a picture.

    Parameters
    ----------
    path : ndarray
        Waypoints, (n, 3) float64 metres, start and goal included.
    history : sequence of [int, float, float]
        Generation, best and mean fitness; empty if there was no search, and then no convergence is
        drawn.
    title, subtitle : str
        Lines above the picture.
    reason : mapping
        The ``reason`` of a summary: why a planner found no path; empty for a given path.
    legs : sequence of (int, float)
        For each leg of a mission, its first row of ``history`` and the fitness of its path.
    warnings : sequence of str
        Warnings on the files that were read.
    mission : HandedOver or None
        The mission as an autopilot gets it.
    """

    evaluator: Evaluator
    path: NDArray[np.float64]
    evaluation: Evaluation
    history: Sequence[Sequence[float]]
    title: str
    subtitle: str
    reason: Mapping[str, Any] = field(default_factory=dict)
    legs: Sequence[tuple[int, float]] = ()
    warnings: Sequence[str] = ()
    mission: HandedOver | None = None


@any_letters()
def draw(scene: Scene) -> Figure:
    """Return the figure: the map next to the two graphs, or above them if it is wide."""
    terrain = scene.evaluator.problem.terrain
    rows, columns = terrain.elevation.shape
    aspect = columns * terrain.dx_m / (rows * terrain.dy_m)
    why = "" if scene.evaluation.feasible else why_not(scene.reason, scene.evaluation.limits)
    said = (why, *(f"Warning: {text}" for text in scene.warnings))
    lines = [
        line for text in said for line in textwrap.wrap(text, 125, max_lines=2, placeholder=" ...")
    ]
    figure, (plan, bar, altitudes, *rest) = layout(
        aspect, TOP + LINE * len(lines), searched=bool(scene.history)
    )

    # The same samples as in the verdict, so that the picture does not contradict it.
    samples, _ = scene.evaluator.track(scene.path).midpoints(scene.evaluator.ds_m / FINE)
    stretches = scene.evaluator.broken(scene.path)
    trouble = broken_samples(scene.evaluator, samples, stretches)
    reasons = _reasons(samples, stretches)
    legend = plan_view.draw(
        plan,
        bar,
        scene.evaluator.problem,
        scene.path,
        samples,
        trouble,
        [(limit, float(samples.x[at]), float(samples.y[at])) for limit, at in reasons],
    )
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    if scene.mission is not None:
        legend += hand_over_view.draw(plan, scene.mission, unit_m)
    legend += plan_view.draw_reason(plan, scene.reason, unit_m)
    ground, _, band = surface_and_demand(scene.evaluator.problem, samples)
    profile.draw(
        altitudes,
        scene.evaluator.problem,
        samples,
        ground,
        band,
        trouble,
        reasons,
        scene.evaluator.lowest_at_m(scene.path),
        scene.evaluation.minimum_clearance_m,
        _visited(scene),
    )
    for progress in rest:
        convergence.draw(progress, scene.history, scene.evaluation.fitness, scene.legs)

    frame(figure, scene.title, scene.subtitle, legend)
    if lines:
        width, height = figure.get_size_inches()
        figure.text(
            LEFT / width,
            1 - 0.85 / height,
            "\n".join(lines),
            color=TROUBLE,
            va="top",
            fontsize=10.5,
            weight="bold",
        )
    return figure


def _reasons(samples: Samples, stretches: Sequence[Stretch]) -> list[tuple[str, int]]:
    """Return the limits of the longest stretches, each with its middle sample."""
    longest = sorted(stretches, key=lambda each: each.from_m - each.to_m)[:_MOST_REASONS]
    middles = np.searchsorted(samples.s, [0.5 * (each.from_m + each.to_m) for each in longest])
    at = np.minimum(middles, len(samples.s) - 1).tolist()
    return [(each.limit, place) for each, place in zip(longest, at, strict=True)]


def _visited(scene: Scene) -> list[tuple[str, float]]:
    """Return the points between the ends, each with the metres flown to the nearest place."""
    near = visits(scene.evaluator, scene.path)
    named = points.between(scene.evaluator.problem.way)
    return [(name, visit.at_m) for (name, _), visit in zip(named, near, strict=True)]


def layout(aspect: float, top: float, *, searched: bool) -> tuple[Figure, list[Axes]]:
    """Return the figure and the axes of map, colour bar, profile and convergence.

    ``aspect`` is the aspect ratio of the map, ``top`` the height of the titles in inches. If
    nothing was ``searched``, there is no convergence, and the profile uses its space.
    """
    aspect = min(max(aspect, NARROWEST), _WIDEST)
    if aspect > _WIDE:
        map_width = min(WIDTH - LEFT - 1.0, 4.0 * aspect)
        map_height = map_width / aspect
        graph_height, gap = 2.3, 1.1
        bottom = _BOTTOM + graph_height + gap
        height = bottom + map_height + top
        left = LEFT + (WIDTH - LEFT - 1.0 - map_width) / 2
        graph_width = (WIDTH - LEFT - RIGHT - 0.9) / 2
        graphs = [
            (LEFT, _BOTTOM, graph_width * 1.15, graph_height),
            (LEFT + graph_width * 1.15 + 0.9, _BOTTOM, graph_width * 0.85, graph_height),
        ]
        if not searched:
            graphs = [(LEFT, _BOTTOM, WIDTH - LEFT - RIGHT, graph_height)]
    else:
        height = 7.75
        room = height - top - _BOTTOM
        map_width = min(6.1, room * aspect)
        map_height = map_width / aspect
        left, bottom = LEFT, _BOTTOM + room - map_height
        graph_left = left + map_width + 1.75
        graph_width, graph_height = WIDTH - RIGHT - graph_left, (room - 1.0) / 2
        graphs = [
            (graph_left, _BOTTOM + graph_height + 1.0, graph_width, graph_height),
            (graph_left, _BOTTOM, graph_width, graph_height),
        ]
        if not searched:
            graphs = [(graph_left, _BOTTOM, graph_width, room)]
    figure = Figure(figsize=(WIDTH, height), facecolor="white")
    FigureCanvasAgg(figure)
    places = [
        (left, bottom, map_width, map_height),
        (left + map_width + 0.12, bottom, 0.16, map_height),
        *graphs,
    ]
    return figure, [
        figure.add_axes((x / WIDTH, y / height, w / WIDTH, h / height)) for x, y, w, h in places
    ]

"""The picture of a comparison: box plots of F next to the convergence."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from pathgene.host.compare.convergence import band, same_generations, work_of
from pathgene.host.compare.entrants import split_label
from pathgene.host.report.style import DASHES, MEAN, SERIES, TEXT, finish, titles


__all__ = ["draw"]

Floats = NDArray[np.float64]

# In inches: widths of the figure, of the boxes and of the counts next to them, and the margins.
_WIDTH, _BOXES, _COUNTS, _GAP = 13.2, 4.1, 0.9, 0.8
_LEFT, _RIGHT, _TOP, _BOTTOM = 0.35, 0.35, 1.3, 1.0
_LINE, _CHARACTER, _KEY = (
    0.17,
    0.083,
    0.6,
)  # In inches: height of a label's line, width of a character, and width of its key.
_SMALLEST_ROW, _SMALLEST_PLOT = 0.55, 3.4
_LABEL_CHARACTERS = 26
# If the evaluations of planners differ by a larger factor, the axis is logarithmic.
_LOGARITHMIC = 8
_CAPTION = (
    "Box: quartiles and median; whiskers: farthest run within 1.5 boxes; diamond: mean; "
    "dots: runs. Line and band: median and quartiles of the best F so far."
)


def draw(report: Mapping[str, Any]) -> Figure:
    """Return the figure; planners without a finished run have an empty row."""
    labels = [_wrapped(planner["label"]) for planner in report["planners"]]
    figure, boxes, convergence = _layout(labels)
    _draw_boxes(boxes, report["planners"], labels)
    _draw_convergence(convergence, report["planners"])

    width, height = figure.get_size_inches()
    titles(figure, _title(report), _subtitle(report), _LEFT)
    figure.text(_LEFT / width, 0.22 / height, _CAPTION, color=MEAN, fontsize=9, va="center")
    return figure


def _wrapped(label: str) -> str:
    """Break a label into lines, only before its options if that suffices."""
    name, *options = split_label(label)
    parts = [name, *(f":{option}" for option in options)]
    lines = [""]
    for part in parts:
        if len(lines[-1] + part) <= _LABEL_CHARACTERS:
            lines[-1] += part
        else:
            lines += textwrap.wrap(part, _LABEL_CHARACTERS)
    return "\n".join(line for line in lines if line)


def _layout(labels: Sequence[str]) -> tuple[Figure, Axes, Axes]:
    """Return the figure and the axes of the boxes and of the convergence."""
    lines = [line for label in labels for line in label.split("\n")]
    row = max(_SMALLEST_ROW, _LINE * (max(label.count("\n") for label in labels) + 2))
    plot = max(_SMALLEST_PLOT, row * len(labels))
    height = _TOP + plot + _BOTTOM
    left = _LEFT + _CHARACTER * max(map(len, lines)) + _KEY
    right = left + _BOXES + _COUNTS + _GAP
    figure = Figure(figsize=(_WIDTH, height), facecolor="white")
    FigureCanvasAgg(figure)
    boxes, convergence = (
        figure.add_axes((x / _WIDTH, _BOTTOM / height, w / _WIDTH, plot / height))
        for x, w in ((left, _BOXES), (right, _WIDTH - _RIGHT - right))
    )
    return figure, boxes, convergence


def _title(report: Mapping[str, Any]) -> str:
    first, last = report["seeds"]
    runs = "one run" if first == last else f"{last - first + 1} runs"
    count = len(report["planners"])
    return f"{report['terrain']['name']}: " + (
        f"{count} planners, {runs} each" if count > 1 else f"one planner, {runs}"
    )


def _subtitle(report: Mapping[str, Any]) -> str:
    first, last = report["seeds"]
    seeds = f"seeds {first} to {last}" if last > first else f"seed {first}"
    text = f"{report['uav']['name']}, sampled every {report['ds_m']:g} m, {seeds}"
    for pair in report["pairs"] if len(report["pairs"]) == 1 else []:
        tests = (
            (pair[key], name)
            for key, name in (("welch", "Welch's t-test"), ("mann_whitney", "Mann-Whitney"))
        )
        text += "; " + ", ".join(
            f"{name}: {test['note']}" if test["p"] is None else f"{name} p = {test['p']:.2g}"
            for test, name in tests
        )
    return text


def _style(index: int) -> dict[str, Any]:
    return {"color": SERIES[index % len(SERIES)], "linestyle": DASHES[index % len(DASHES)]}


def _fitness(planner: Mapping[str, Any]) -> Floats:
    return np.array([run["fitness"] for run in planner["runs"]], dtype=np.float64)


def _mostly_feasible(planners: Sequence[Mapping[str, Any]]) -> bool:
    """Return whether more than half of the runs of every planner end above 1."""
    return all(np.median(values) > 1 for values in map(_fitness, planners) if len(values))


def _draw_boxes(axes: Axes, planners: Sequence[Mapping[str, Any]], labels: Sequence[str]) -> None:
    """Draw a box plot of each planner, the first at the top, with its runs and feasible count.

    If most runs are feasible, the infeasible ones are counted, not drawn: their fitness is too
    low for a difference to be visible.
    """
    every = np.concatenate([_fitness(planner) for planner in planners])
    shown = every[every > 1] if _mostly_feasible(planners) else every
    low, high = (float(shown.min()), float(shown.max())) if len(shown) else (0.0, 2.0)
    margin = max(0.06 * (high - low), 1e-3)
    axes.set(xlim=(low - margin, high + margin), ylim=(len(planners) - 0.5, -0.5))
    axes.axvline(1, color=TEXT, linewidth=1, linestyle=(0, (4, 3)), zorder=2)

    beside = axes.get_yaxis_transform()
    scatter = np.random.default_rng(0)  # Jitter separates the dots of equal runs.
    key_from = -_KEY / _BOXES
    for at, planner in enumerate(planners):
        style, values = _style(at), _fitness(planner)
        axes.plot(
            (0.85 * key_from, 0.15 * key_from),
            (at, at),
            transform=beside,
            clip_on=False,
            linewidth=2.2,
            **style,
        )
        feasible = planner["statistics"]["feasible"]
        text = f"{feasible}/{len(values)}\nfeasible" if len(values) else "no run\nfinished"
        axes.text(1.03, at, text, transform=beside, fontsize=9, color=TEXT, va="center")
        if not len(values):
            continue
        colour = style["color"]
        drawn = axes.boxplot(
            values,
            positions=[at],
            widths=0.5,
            orientation="horizontal",
            showfliers=False,
            showmeans=True,
            patch_artist=True,
            manage_ticks=False,
            zorder=3,
            boxprops={"facecolor": colour, "alpha": 0.3, "linewidth": 0},
            medianprops={"color": colour, "linewidth": 2.4},
            whiskerprops={"color": colour},
            capprops={"color": colour},
            meanprops={
                "marker": "D",
                "markerfacecolor": "white",
                "markeredgecolor": colour,
                "markersize": 6,
            },
        )
        drawn["means"][0].set_zorder(5)
        axes.scatter(
            values,
            at + scatter.uniform(-0.16, 0.16, len(values)),
            s=9,
            color=colour,
            alpha=0.55,
            linewidth=0,
            zorder=4,
        )
        hidden = int((values < low - margin).sum())
        if hidden:
            axes.text(
                0.01,
                at + 0.42,
                f"← {hidden} below 1",
                transform=beside,
                fontsize=8.5,
                color=colour,
                va="center",
            )
    finish(axes, "Fitness of the paths found", "fitness", "")
    axes.set_yticks(range(len(labels)), labels, fontsize=10)
    axes.tick_params(axis="y", length=0, pad=_KEY * 72)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    axes.grid(visible=False, axis="y")


def _draw_convergence(axes: Axes, planners: Sequence[Mapping[str, Any]]) -> None:
    """Draw the band of each planner over generations or evaluations.

    The axis counts generations if a generation takes the same number of evaluations with every
    planner, and evaluations otherwise. An axis of evaluations is logarithmic if the planners'
    numbers differ widely.
    """
    histories = [[run for run in planner["runs"] if run["history"]] for planner in planners]
    runs = [run for some in histories for run in some]
    by_generation = not runs or same_generations(runs)
    ends = [float(work_of(run)[-1]) for run in runs]
    logarithmic = not by_generation and max(ends) > _LOGARITHMIC * min(ends)
    start, top, last = np.inf, 1.0, 1.0
    for at, some in enumerate(histories):
        if not some:
            continue
        shape = band(some, by_generation=by_generation, logarithmic=logarithmic)
        style = _style(at)
        axes.fill_between(
            shape.x,
            shape.low,
            shape.high,
            color=style["color"],
            alpha=0.18,
            linewidth=0,
            step="post",
            zorder=3,
        )
        axes.plot(shape.x, shape.median, linewidth=2, drawstyle="steps-post", zorder=4, **style)
        axes.plot(
            shape.x[-1],
            shape.median[-1],
            marker="o",
            markersize=5,
            color=style["color"],
            zorder=5,
            clip_on=False,
        )
        start = min(start, float(shape.low.min()))
        top, last = max(top, float(shape.high.max())), max(last, float(shape.x[-1]))
    axes.axhline(1, color=TEXT, linewidth=1, linestyle=(0, (4, 3)), zorder=2)
    # If most runs are feasible, the infeasible phase lies far below and is cut off.
    bottom = max(1.0, start) if top > 1 and _mostly_feasible(planners) else 0.0
    # All fitness may be equal.
    height = top - bottom or 1.0
    axes.set_ylim(bottom - 0.06 * height, top + 0.08 * height)
    if bottom <= 1:
        axes.text(
            0.985,
            1,
            "feasible above 1",
            transform=axes.get_yaxis_transform(),
            fontsize=9,
            color=TEXT,
            ha="right",
            va="bottom",
        )
    if logarithmic:
        axes.set_xscale("log")
    else:
        axes.set_xlim(0, last)
        axes.xaxis.set_major_locator(MaxNLocator(6, integer=True))
    finish(
        axes, "Convergence", "generation" if by_generation else "evaluations", "best fitness so far"
    )

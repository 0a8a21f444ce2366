"""The animation of a flight with replans: the aircraft flies, zones appear, the path changes."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray
from PIL import Image

from pathgene.host.evaluation.track import SmoothedTrack
from pathgene.host.files.output import replacing
from pathgene.host.flight.flight import PERIOD_S
from pathgene.host.problem.tiles import wholes
from pathgene.host.replanning.picture import version_points, window
from pathgene.host.report import plan_view, zone_shapes
from pathgene.host.report.style import FLOWN, GOAL, NOFLY, PATH, START, TEXT, any_letters, halo


if TYPE_CHECKING:
    from pathgene.host.replanning.outcome import Replanned
    from pathgene.host.replanning.pilot import Change

__all__ = ["frames", "write"]

Floats = NDArray[np.float64]

# Size of a frame in inches, and its dots per inch.
_WIDTH, _HEIGHT, _DPI = 8.0, 6.6, 80
# Frames of the whole flight, and how long each one is shown; a change is shown longer.
_FRAMES, _FRAME_MS, _PAUSE_MS = 72, 100, 1600
_COLOURS = 64
# Colours that are always kept, and the height of their bands in the palette's picture, in dots.
_LINES = (PATH, FLOWN, START, GOAL, NOFLY, TEXT, "white")
_BAND = 40
# Size of the aircraft's mark, in dots.
_MARK = 15
_AIRCRAFT = Outline([(1.0, 0.0), (-0.8, 0.6), (-0.45, 0.0), (-0.8, -0.6), (1.0, 0.0)])


def write(report: Replanned, file: Path) -> None:
    """Write the animation to the GIF ``file``."""
    images, durations = frames(report)
    palette = _palette(images[len(images) // 2])
    reduced = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    with replacing(file) as binary:
        reduced[0].save(
            binary,
            format="GIF",
            save_all=True,
            append_images=reduced[1:],
            duration=durations,
            loop=0,
            optimize=True,
        )


def _palette(frame: Image.Image) -> Image.Image:
    """Return a palette of a frame's colours, and of lines and zones, which have few dots."""
    width, height = frame.size
    bands = Image.new("RGB", (width, height + _BAND * len(_LINES)))
    bands.paste(frame)
    for number, colour in enumerate(_LINES):
        bands.paste(colour, (0, height + _BAND * number, width, height + _BAND * (number + 1)))
    return bands.quantize(_COLOURS, dither=Image.Dither.NONE)


@any_letters()
def frames(report: Replanned) -> tuple[list[Image.Image], list[int]]:
    """Return the frames, and the milliseconds that each is shown."""
    session = report.session
    figure = Figure(figsize=(_WIDTH, _HEIGHT), facecolor="white", dpi=_DPI)
    canvas: Any = FigureCanvasAgg(figure)
    plan, unit_m = _background(figure, report)
    canvas.draw()
    behind = np.asarray(canvas.buffer_rgba()).copy()
    images, durations = [], []
    for time_s, pause, said in _times(report):
        drawn = _draw_moment(plan, report, unit_m, time_s, said)
        images.append(_composed(canvas, behind, plan, drawn))
        durations.append(_PAUSE_MS if pause else _FRAME_MS)
        for artist in drawn:
            artist.remove()
    assert session.pilot.samples
    return images, durations


def _composed(canvas: Any, behind: NDArray[np.uint8], plan: Axes, drawn: list[Any]) -> Image.Image:
    """Return the background with all drawings on it."""
    renderer = canvas.get_renderer()
    np.asarray(renderer.buffer_rgba())[:] = behind
    for artist in sorted(drawn, key=lambda each: each.get_zorder()):
        artist.draw(renderer)
    return Image.fromarray(np.asarray(renderer.buffer_rgba())[..., :3].copy())


def _background(figure: Figure, report: Replanned) -> tuple[Axes, float]:
    """Draw the constant parts: the land, the first zones, the ends."""
    session = report.session
    mission = session.mission
    terrain = mission.terrain
    plan = figure.add_axes((0.08, 0.09, 0.79, 0.78))
    bar = figure.add_axes((0.885, 0.09, 0.018, 0.78))
    ends = np.array([mission.start, mission.goal])
    samples = SmoothedTrack(session.pilot.legs[0].track, terrain).sample(10.0)
    none = np.zeros(len(samples.s), dtype=bool)
    shown = window(report, plan)
    plan_view.draw(plan, bar, mission, ends, samples, none, window=shown)
    for line in list(plan.lines):
        # The path is drawn in each frame while it is valid.
        if line.get_color() == PATH:
            line.remove()
    unit_m, _ = plan_view.axis_unit(max(terrain.width_m, terrain.height_m))
    plan.set_title("", loc="left")
    board = f", board {report.board}" if report.board else ""
    figure.text(
        0.08,
        0.955,
        f"Replanned in flight by {report.planner}{board}",
        fontsize=13,
        weight="bold",
        color=TEXT,
        va="center",
    )
    return plan, unit_m


def _times(report: Replanned) -> list[tuple[float, bool, str]]:
    """Return the time of each frame in seconds, whether it is a pause, and its text."""
    session = report.session
    end = session.pilot.time_s
    moments: list[tuple[float, bool, str]] = [
        (float(time), False, "") for time in np.linspace(0, end, _FRAMES)
    ]
    for change in session.changes:
        if not change.needed:
            continue
        moments.append((change.at_s, True, f"{change.what}."))
        if change.active_s is not None:
            moments.append(
                (
                    change.at_s + change.active_s + PERIOD_S,
                    True,
                    f"New path after {1000 * change.active_s:.1f} ms: "
                    f"{change.flown_m:.2f} m flown.\n{_parts(change)}",
                )
            )
    return sorted(moments, key=lambda moment: moment[:2])


def _parts(change: Change) -> str:
    """Return the parts of a new path's time in words; none for a planner without a chip."""
    times = [attempt.time for _, attempt in change.attempts]
    chip_ms = 1000 * sum(time.chip_s for time in times)
    if not chip_ms:
        return ""
    trips_ms = 1000 * sum(time.round_trips_s for time in times)
    host_ms = 1000 * sum(time.host_s for time in times)
    return (
        f"chip and line {chip_ms:.1f} ms, counted; round trips {trips_ms:.1f} ms "
        f"and host {host_ms:.0f} ms, assumed"
    )


def _draw_moment(
    plan: Axes, report: Replanned, unit_m: float, time_s: float, said: str
) -> list[Any]:
    """Draw a moment of the flight; return its artists."""
    session = report.session
    index = min(int(time_s / PERIOD_S), len(session.pilot.samples) - 1)
    flown = np.array(session.pilot.samples[: index + 1])[:, 1:3]
    drawn: list[Any] = []
    zones = next(zones for since, zones in reversed(session.airspace.past) if since <= time_s)
    known = wholes(session.mission.zones)
    for zone in wholes(zones):
        if zone not in known:
            drawn.append(plan.add_patch(zone_shapes.outline(zone, unit_m)))
    number = max(
        (i for i, leg in enumerate(session.pilot.legs) if leg.since_s <= time_s), default=0
    )
    ahead = _ahead(version_points(report, number), flown[-1])
    colour = PATH if session.pilot.legs[number].kind == "path" else START
    drawn += plan.plot(
        *(ahead / unit_m).T, color=colour, linewidth=2.4, path_effects=halo(1.2), zorder=6
    )
    drawn += plan.plot(*(flown[::5] / unit_m).T, color=FLOWN, linewidth=1.8, zorder=7)
    east, north = flown[-1] - flown[max(len(flown) - 15, 0)]
    drawn += plan.plot(
        *(flown[-1:] / unit_m).T,
        marker=_AIRCRAFT.transformed(Affine2D().rotate(math.atan2(north, east))),
        markersize=_MARK,
        color=TEXT,
        markeredgecolor="white",
        zorder=9,
    )
    headline, _, parts = said.partition("\n")
    caption = f"{time_s:5.0f} s   {headline}"
    drawn.append(
        plan.text(
            0.0,
            1.02,
            caption,
            transform=plan.transAxes,
            fontsize=12,
            color=TEXT,
            weight="bold" if said else "normal",
        )
    )
    if parts:
        drawn.append(
            plan.text(
                0.985,
                0.02,
                parts,
                transform=plan.transAxes,
                fontsize=9.5,
                color=TEXT,
                ha="right",
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.85, "pad": 3},
                zorder=10,
            )
        )
    return drawn


def _ahead(points: Floats, here: Floats) -> Floats:
    """Return the part of a path ahead of a place."""
    nearest = int(np.argmin(np.hypot(*(points - here).T)))
    return points[nearest:]

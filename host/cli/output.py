"""Output of the commands: JSON, pairs, tables, and notes of one line on standard error."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pathgene.host.progress import Counter, beside_bars


if TYPE_CHECKING:
    from pathgene.host.remarks import Reading

__all__ = [
    "LONGEST_LINE",
    "note",
    "note_compiling",
    "note_compiling_routes",
    "note_reading",
    "note_readings",
    "note_start",
    "print_json",
    "print_line",
    "print_pairs",
    "print_table",
    "term_pairs",
]


#: Maximum characters of a line on standard error.
LONGEST_LINE = 1000

_PREFIX = "pathgene: "
# Paths of files may have some hundreds of characters.
_LONGEST_WORD = 400


def print_line(sentence: str) -> None:
    """Print a sentence as one line, with the middle of long words cut out."""
    # Names from files may hold sequences that control a terminal.
    shown = "".join(c if c.isprintable() or c.isspace() else "?" for c in sentence)
    line = _PREFIX + " ".join(_cut(word, _LONGEST_WORD, 100, 50) for word in shown.split())
    with beside_bars():
        print(_cut(line, LONGEST_LINE, 600, LONGEST_LINE - 603), file=sys.stderr, flush=True)


def _cut(text: str, longest: int, first: int, last: int) -> str:
    """Return the first and the last characters of a text that is longer than ``longest``."""
    return text if len(text) <= longest else f"{text[:first]}...{text[-last:]}"


def print_json(value: Any) -> None:
    """Print ``value`` as JSON on standard output; its numbers must be finite."""
    print(json.dumps(value, indent=2, allow_nan=False), flush=True)


def print_pairs(pairs: Iterable[tuple[str, str]], width: int = 0) -> int:
    """Print names and values as two columns, and return the width of the first.

    Parameters
    ----------
    width : int
        Minimum width of the first column, to continue an earlier list.
    """
    rows = list(pairs)
    width = max(width, *(len(name) for name, _ in rows))
    for name, value in rows:
        print(f"{name:<{width}}  {value}")
    return width


def print_table(rows: Sequence[Sequence[str]]) -> None:
    """Print ``rows`` as left-aligned columns."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True))
        print("  ".join(cells).rstrip())


def note(text: str) -> None:
    """Print a note on standard error."""
    print_line(text)


def note_start(text: str) -> None:
    """Tell a user at a terminal, who waits for the first sign of life, that work has begun."""
    if sys.stderr.isatty():
        print_line(text)


def note_reading(read: Mapping[str, Any] | None, prefix: str = "") -> None:
    """Print the report on files that were read on standard error: the ``read`` of a summary."""
    from pathgene.host.report.reading import sentences

    for sentence in sentences(read):
        print_line(f"{prefix}{sentence}")


def note_readings(terrain: Reading, zones: Reading) -> None:
    """Print the reports on a terrain and on zones on standard error."""
    note_reading({"terrain": terrain.to_dict(), "zones": zones.to_dict()})


def term_pairs(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the terms of a path as names and texts with units."""
    return [
        (
            "feasible",
            "yes"
            if summary["feasible"]
            else "no, infeasible only between samples"
            if summary["feasible_at_ds"]
            else "no",
        ),
        ("fitness", _shown(summary["fitness"], ".6f")),
        ("penalty", _shown(summary["penalty"], ".1f", "m")),
        ("  under terrain", _shown(summary["distance_under_terrain_m"], ".1f", "m")),
        ("  in no-fly zones", _shown(summary["distance_in_nofly_m"], ".1f", "m")),
        ("  too steep", _shown(summary["distance_too_steep_m"], ".1f", "m")),
        ("  impossible arcs", f"{summary['impossible_arcs']}"),
        *(
            [("  beyond other limits", _shown(summary["distance_beyond_limits_m"], ".1f", "m"))]
            if summary.get("distance_beyond_limits_m")
            else []
        ),
        ("cost", _shown(summary["cost"], ".6f")),
        ("length", _shown(summary["length_m"], ".1f", "m")),
        ("mean altitude", _shown(summary["mean_altitude_m"], ".1f", "m")),
        ("fuel", _shown(summary["fuel_N"], ".4f", "N")),
        ("minimum clearance", _shown(summary["minimum_clearance_m"], ".1f", "m")),
        *_limit_pairs(summary),
        *map(_visit_pair, summary.get("visits", ())),
        ("waypoints", f"{len(summary['waypoints'])}, start and goal included"),
    ]


def _limit_pairs(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the duration of the flight, and the limit that it comes closest to or exceeds most."""
    limits = summary.get("limits")
    if not limits:
        return []
    # Loads the kernels.
    from pathgene.host.evaluation.aircraft_limits import unit_of

    worst = limits[0]
    unit = unit_of(worst["limit"])
    pairs = [("flight time", _duration(summary["flight_time_s"]))]
    if summary["fuel_left_N"] is not None:
        pairs.append(("fuel left", f"{summary['fuel_left_N']:.2f} N"))
    return [
        *pairs,
        (
            "nearest limit" if summary["feasible"] else "worst limit",
            f"{worst['limit']}: {_worst(worst['worst'], unit)}, "
            f"allowed {_short(worst['allowed'])} {unit}, "
            f"{worst['at_m'] / 1000:.2f} km from the start",
        ),
    ]


def _visit_pair(visit: dict[str, Any]) -> tuple[str, str]:
    """Return how near the track comes to a via point, and where."""
    return (
        f"via point {visit['index']}",
        f"{'missed' if visit['missed'] else 'passed'} at {visit['distance_m']:.1f} m "
        f"({visit['horizontal_m']:.1f} m horizontally), {visit['at_m'] / 1000:.2f} km from the "
        "start",
    )


def _duration(time_s: float | None) -> str:
    if time_s is None:
        return "unknown"
    minutes, seconds = divmod(round(time_s), 60)
    return f"{minutes} min {seconds:02} s"


def _worst(value: float | None, unit: str) -> str:
    """Return the worst value of a limit as text; a clearance is unknown over a void."""
    return "unknown over a void" if value is None else _shown(value, ".4g", unit)


def _short(value: float | None) -> str:
    return _shown(value, ".4g")


def _shown(value: float | None, form: str, unit: str = "") -> str:
    """Return a number as text; None means unknown: out of range of a float, or over a void."""
    return "unknown" if value is None else f"{value:{form}} {unit}".rstrip()


def note_compiling(*, as_paper: bool) -> None:
    """Compile the kernels of the evaluation, with a note, unless numba has cached them.

    On a terminal, the number of compiled kernels is shown.
    """
    # Loads numba; bad input must not wait for it.
    from pathgene.host.compiling import compile_apart, compile_first
    from pathgene.host.evaluation import kernels, rule_kernels

    compile_apart()
    # The outermost kernel of every evaluation.
    if not _note(kernels.path_terms if as_paper else rule_kernels.strict_terms, "about a minute"):
        return
    with contextlib.closing(Counter(sys.stderr, "kernels compiled")) as counter:
        compile_first(as_paper=as_paper, progress=counter.update)


def note_compiling_routes() -> None:
    """Note the same for the kernels of ``pathgene auv``."""
    from pathgene.host.auv import measures
    from pathgene.host.compiling import compile_apart

    compile_apart()
    _note(measures.measure, "some ten seconds")


def _note(kernel: Any, duration: str) -> bool:
    """Note a first compilation; return whether there is one."""
    from pathgene.jit import is_kept

    is_first = not is_kept(kernel)
    if is_first:
        note(f"Compiling for this machine, once: {duration}.")
    return is_first

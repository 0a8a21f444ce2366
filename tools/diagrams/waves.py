"""Waveforms of a simulated chip, as SVG."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.sax.saxutils import escape


_LEFT, _TOP, _ROW, _HIGH = 190, 46, 30, 18
#: Width of all cycles, pixels.
_WIDE = 1000
_TEXT = 'font-family="Helvetica, Arial, sans-serif"'


@dataclass
class Trace:
    """One row of a waveform."""

    label: str
    #: Text of a value; None for a row of one bit.
    show: Callable[[int], str] | None = None
    values: list[int] = field(default_factory=list)
    #: If given, the row shows nothing while this is 0.
    valid: list[int] = field(default_factory=list)


def draw(title: str, traces: Sequence[Trace], first: int, last: int) -> str:
    """Return the SVG of cycles ``first`` to ``last``."""
    step = _WIDE / (last - first)
    width = round(_LEFT + (last - first + 1) * step + 10)
    height = _TOP + _ROW * len(traces) + 8
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}">',
        f'<rect width="{width}" height="{height}" fill="white"/>',
        f'<text x="8" y="18" {_TEXT} font-size="13" font-weight="bold">{escape(title)}</text>',
        *_grid(first, last, step, height),
    ]
    for row, trace in enumerate(traces):
        top = _TOP + _ROW * row + (_ROW - _HIGH) / 2
        parts.append(
            f'<text x="8" y="{top + 13:g}" {_TEXT} font-size="11">{escape(trace.label)}</text>'
        )
        shown = trace.values[first : last + 1]
        if trace.show is None:
            parts.append(_bit(shown, top, step))
        else:
            valid = trace.valid[first : last + 1] or [1] * len(shown)
            parts += _bus(shown, valid, trace.show, top, step)
    return "\n".join([*parts, "</svg>", ""])


def _grid(first: int, last: int, step: float, height: int) -> list[str]:
    count = last - first + 1
    every = next(size for size in (1, 2, 5, 10, 20, 50, 100, 200, 500) if size * step >= 40)
    parts = [
        f'<text x="{_LEFT - 8}" y="{_TOP - 10}" {_TEXT} font-size="9" fill="#808080" '
        'text-anchor="end">cycle</text>'
    ]
    for cycle in range(0, count, every):
        x = _LEFT + cycle * step
        parts += [
            f'<line x1="{x:g}" y1="{_TOP - 6}" x2="{x:g}" y2="{height - 4}" stroke="#e4e4e4"/>',
            f'<text x="{x + 2:g}" y="{_TOP - 10}" {_TEXT} font-size="9" fill="#808080">'
            f"{cycle}</text>",
        ]
    return parts


def _bit(values: Sequence[int], top: float, step: float) -> str:
    points, level = [], None
    for cycle, value in enumerate(values):
        x, y = _LEFT + cycle * step, top + (0 if value else _HIGH)
        if value != level:
            points += [f"{x:g},{y:g}"] if level is None else [f"{x:g},{_other(y, top):g}"]
            points += [] if level is None else [f"{x:g},{y:g}"]
            level = value
    end = top + (0 if level else _HIGH)
    points.append(f"{_LEFT + len(values) * step:g},{end:g}")
    return (
        f'<polyline points="{" ".join(points)}" fill="none" stroke="#205090" stroke-width="1.3"/>'
    )


def _other(y: float, top: float) -> float:
    return top + _HIGH if y == top else top


def _bus(
    values: Sequence[int], valid: Sequence[int], show: Callable[[int], str], top: float, step: float
) -> list[str]:
    parts = []
    begin = 0
    for cycle in range(1, len(values) + 1):
        same = cycle < len(values) and (values[cycle], valid[cycle]) == (
            values[begin],
            valid[begin],
        )
        if same:
            continue
        x, wide = _LEFT + begin * step, (cycle - begin) * step
        if valid[begin]:
            text = show(values[begin])
            parts.append(
                f'<rect x="{x + 0.5:g}" y="{top}" width="{max(wide - 1, 0.6):g}" height="{_HIGH}" '
                'rx="3" fill="#e8f0fa" stroke="#205090"/>'
            )
            if len(text) * 5.6 + 4 <= wide:
                parts.append(
                    f'<text x="{x + wide / 2:g}" y="{top + 13}" {_TEXT} font-size="10" '
                    f'text-anchor="middle">{escape(text)}</text>'
                )
        else:
            middle = top + _HIGH / 2
            parts.append(
                f'<line x1="{x:g}" y1="{middle}" x2="{x + wide:g}" y2="{middle}" stroke="#b0b0b0"/>'
            )
        begin = cycle
    return parts


def integer(value: int) -> str:
    """Return a value in decimal."""
    return str(value)


def hexadecimal(value: int) -> str:
    """Return a byte in hex."""
    return f"{value:02x}"


def text_of(values: Any) -> Callable[[int], str]:
    """Return a function that shows members of an enumeration by name."""
    return lambda value: str(values(value).name)

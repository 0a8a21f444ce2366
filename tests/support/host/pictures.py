"""Assertions about every picture."""

import itertools

from matplotlib.text import Text


def texts_of(figure):
    """Return the visible texts with their boxes in pixels, without ticks outside the view."""
    unseen = set()
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        low, high = sorted(axis.get_view_interval())
        margin = 1e-9 * (high - low)
        unseen |= {
            label
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks())
            for label in (tick.label1, tick.label2)
            if not low - margin <= tick.get_loc() <= high + margin or not axis.get_visible()
        }
    renderer = figure.canvas.get_renderer()
    # The box of a text without its arrow, which may cross other texts' boxes and no text.
    return [
        (text.get_text(), Text.get_window_extent(text, renderer))
        for text in figure.findobj(Text)
        if text.get_visible() and text.get_text() and text not in unseen
    ]


def assert_texts_apart(figure):
    """Assert that there are texts, none overlaps another, and none leaves the figure."""
    width, height = figure.canvas.get_width_height()
    texts = texts_of(figure)
    assert texts
    for text, box in texts:
        assert box.x0 >= 0, text
        assert box.y0 >= 0, text
        assert box.x1 <= width, text
        assert box.y1 <= height, text
    for (one, a), (other, b) in itertools.combinations(texts, 2):
        overlap = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        assert min(overlap) <= 1, (one, other)

"""The panels next to the views: points, zones, and the form."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterator
from typing import Any

from nicegui import ui

from pathgene.host.errors import InputError
from pathgene.host.numeric import parse
from pathgene.host.web.desk.fields import Entry, Input, add_field, add_numbers
from pathgene.host.web.desk.form import GROUPS, ZONE_FIELDS, Field, fields_of, planner_fields
from pathgene.host.web.desk.sheet import Sheet


__all__ = ["Panels", "panel"]

# Size of a new zone added by keyboard, as a share of the shorter side of the map.
_NEW_ZONE_SHARE = 0.08
_NEW_ZONES = "circle", "polygon"
# Zones in the list at a time: NiceGUI takes a second to make the buttons of some hundreds.
_LISTED = 50


class Panels:
    """The panels of a page.

    Parameters
    ----------
    picked : callable
        Called with the number of the zone that the user opens, or None.
    """

    def __init__(
        self, sheet: Sheet, changed: Callable[[], object], picked: Callable[[int | None], object]
    ) -> None:
        self._sheet, self._changed, self._picked = sheet, changed, picked
        self._zone: int | None = None
        self._first_zone = 0
        # Buttons that add to a list are outside the list, so that they keep the keyboard focus.
        with panel("Points", is_open=True):
            self._points()
            _adders({"Add via point": self._add_via})
        with panel("No-fly zones") as self._zones_panel:
            self._zones()
            _adders({f"Add {kind}": functools.partial(self._add_zone, kind) for kind in _NEW_ZONES})
        for table in ("mission", "aircraft", "rules", "planner", "terrain"):
            with panel(GROUPS.get(table, "Aircraft")):
                self._form(table)

    def show(self) -> None:
        """Show all values again, for example after another problem was opened."""
        self.show_drawn()
        self.show_form()

    def show_form(self) -> None:
        """Show the values of the form again, for example after another planner was chosen."""
        self._form.refresh()

    def show_drawn(self) -> None:
        """Show the values again that can change on the map."""
        self._points.refresh()
        self._zones.refresh()

    def pick(self, number: int | None) -> None:
        """Open the fields of a zone."""
        self._zone = number
        if number is not None:
            self._first_zone = number - number % _LISTED
            ui.run_javascript(f"getHtmlElement({self._zones_panel.id}).open = true")
        self._zones.refresh()

    @ui.refreshable_method
    def _points(self) -> None:
        sheet = self._sheet
        height = "height" if sheet.values.get("agl") else "altitude"
        names = ("east m", "north m", f"{height} m")
        for end in ("start", "goal"):
            with ui.element("fieldset").classes("point"):
                _legend(end.capitalize(), end)
                point = sheet.values.get(end) or (0.0, 0.0, 0.0)
                take = self._value_taker(end)
                add_numbers(end.capitalize(), names, point, take, self._entry(end))
            if end == "start":
                for number, via in enumerate(sheet.via):
                    with ui.element("fieldset").classes("point"):
                        with _legend(f"Via {number + 1}", "via"):
                            _remover(f"Remove via {number + 1}", self._via_remover(number))
                        take = self._via_taker(number)
                        entry = self._entry("via", number)
                        add_numbers(f"Via {number + 1}", names, via, take, entry)

    @ui.refreshable_method
    def _zones(self) -> None:
        zones = self._sheet.zones
        first = min(self._first_zone, max(len(zones) - 1, 0) // _LISTED * _LISTED)
        if len(zones) > _LISTED:
            self._turner(first, len(zones))
        for number, zone in enumerate(zones[first : first + _LISTED], start=first):
            name = zone.get("name") or f"Zone {number + 1}"
            kind = "circle" if "circle" in zone else "polygon"
            is_open = number == self._zone
            with ui.element("div").classes("zone"):
                with ui.row().classes("zone-head"):
                    ui.button(f"{name}, {kind}", on_click=self._picker(number)).props(
                        f"flat dense no-caps align=left aria-expanded={str(is_open).lower()}"
                    ).classes("grow")
                    _remover(f"Remove {name}", self._zone_remover(number))
                if is_open:
                    self._zone_fields(number, zone)

    def _turner(self, first: int, total: int) -> None:
        """Add the buttons that show earlier and later zones of a long list."""

        def turned(to: int) -> Callable[[], None]:
            def turn() -> None:
                self._first_zone = to
                self._zones.refresh()

            return turn

        with ui.row().classes("actions"):
            ui.label(f"{first + 1} to {min(first + _LISTED, total)} of {total:,}").classes("word")
            for text, to in (("Earlier", first - _LISTED), ("Later", first + _LISTED)):
                button = ui.button(text, on_click=turned(to)).props("flat dense no-caps")
                button.set_enabled(0 <= to < total)

    def _zone_fields(self, number: int, zone: dict[str, Any]) -> None:
        with ui.element("div").classes("fields"):
            if "circle" in zone:
                names = ("east m", "north m", "radius m")
                take, entry = self._setter(zone, "circle"), self._entry("zone", number, "circle")
                add_numbers("Circle", names, zone["circle"], take, entry)
            else:
                Input(
                    "corners: east north, one in a line",
                    "\n".join(f"{x:.10g} {y:.10g}" for x, y in zone["polygon"]),
                    _corners,
                    self._setter(zone, "polygon"),
                    self._entry("zone", number, "polygon"),
                ).props("type=textarea autogrow").classes("wide")
            for field in ZONE_FIELDS:
                name = field.option.key
                entry = self._entry("zone", number, name)
                add_field(field, zone.get(name), self._setter(zone, name), entry)

    @ui.refreshable_method
    def _form(self, table: str) -> None:
        values = self._sheet.values
        with ui.element("div").classes("fields"):
            if table == "aircraft" and isinstance(values.get("uav"), dict):
                ui.label(f"{values['uav']['name']}, described in its problem").classes("wide")
            for field in fields_of(table):
                if field.option.name == "planner":
                    continue  # It is above the views.
                self._form_field(field, field.option.name)
            if table == "planner":
                for field in planner_fields(self._sheet.planner):
                    self._form_field(field, field.option.name)

    def _form_field(self, field: Field, dest: str) -> None:
        def read_board(text: str) -> Any:
            board = field.value_of(text)
            self._sheet.require_board(board)
            return board

        value, take = self._sheet.values.get(dest), self._value_taker(dest)
        read = read_board if dest == "board" else None
        add_field(field, value, take, self._entry("form", dest), read)

    def _entry(self, *place: str | int) -> Entry:
        return Entry(self._sheet.misread, place, self._changed)

    def _value_taker(self, dest: str) -> Callable[[Any], None]:
        def take(value: Any) -> None:
            self._sheet.set(dest, value)
            if dest == "agl":
                self._points.refresh()
            self._changed()

        return take

    def _via_taker(self, number: int) -> Callable[[Any], None]:
        def take(point: tuple[float, ...]) -> None:
            self._sheet.via[number] = point
            self._changed()

        return take

    def _via_remover(self, number: int) -> Callable[[], None]:
        def remove() -> None:
            self._sheet.remove_via(number)
            self._points.refresh()
            self._changed()

        return remove

    def _add_via(self) -> None:
        """Add a via point between the last one and the goal."""
        values = self._sheet.values
        before = self._sheet.via[-1] if self._sheet.via else values.get("start")
        ends = before, values.get("goal")
        (x0, y0), (x1, y1) = ((end or (0.0, 0.0, 0.0))[:2] for end in ends)
        self._sheet.add_via((x0 + x1) / 2, (y0 + y1) / 2)
        self._points.refresh()
        self._changed()

    def _setter(self, zone: dict[str, Any], name: str) -> Callable[[Any], None]:
        def take(value: Any) -> None:
            if value is None:
                zone.pop(name, None)
            else:
                zone[name] = value
            self._changed()

        return take

    def _picker(self, number: int) -> Callable[[], None]:
        def pick() -> None:
            chosen = None if self._zone == number else number
            self.pick(chosen)
            self._picked(chosen)

        return pick

    def _zone_remover(self, number: int) -> Callable[[], None]:
        def remove() -> None:
            self._sheet.remove_zone(number)
            self.pick(None)
            self._picked(None)
            self._changed()

        return remove

    def _add_zone(self, kind: str) -> None:
        """Add a zone at the centre of the map; its fields move it."""
        try:
            terrain = self._sheet.terrain()
        except InputError:
            return  # The page says so.
        size = round(_NEW_ZONE_SHARE * min(terrain.width_m, terrain.height_m), 0)
        x, y = round(terrain.width_m / 2, 0), round(terrain.height_m / 2, 0)
        if kind == "circle":
            zone: dict[str, Any] = {"circle": (x, y, size)}
        else:
            corners = [[x - size, y - size], [x + size, y - size], [x, y + size]]
            zone = {"polygon": corners}
        self._sheet.zones.append(zone)
        number = len(self._sheet.zones) - 1
        self._changed()
        self.pick(number)
        self._picked(number)


@contextlib.contextmanager
def panel(title: str, *, is_open: bool = False) -> Iterator[ui.element]:
    """Add a panel that opens and closes. It holds all elements that the block adds."""
    with ui.element("details").classes("panel") as details:
        if is_open:
            details.props("open")
        with ui.element("summary"):
            ui.label(title).classes("word")
        with ui.element("div").classes("panel-body"):
            yield details


def _adders(acts: dict[str, Callable[[], None]]) -> None:
    with ui.row().classes("actions"):
        for text, act in acts.items():
            ui.button(text, on_click=act).props("flat dense no-caps")


def _legend(text: str, kind: str) -> ui.element:
    with ui.element("legend") as legend:
        ui.element("i").classes(f"mark {kind}")
        ui.label(text).classes("word")
    return legend


def _remover(label: str, remove: Callable[[], None]) -> None:
    ui.button("✕", on_click=remove).props(f'flat dense round size=sm aria-label="{label}"').classes(
        "remove"
    )


def _corners(text: str) -> list[list[float]]:
    """Return the corners of a polygon, one per line.

    Raises
    ------
    InputError
        If they are not at least three pairs of numbers.
    """
    try:
        ring = [
            [parse(part) for part in line.replace(",", " ").split()]
            for line in text.strip().splitlines()
        ]
    except ValueError:
        ring = []
    if len(ring) < 3 or any(len(corner) != 2 for corner in ring):
        raise InputError("A polygon has three corners or more, each two numbers in a line.")
    return ring

"""Fields of the form as NiceGUI elements."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from nicegui import ui

from pathgene.host.errors import InputError
from pathgene.host.numeric import parse
from pathgene.host.web.desk.form import Field
from pathgene.host.web.desk.misread import Misread, Place, Wrong


__all__ = ["Entry", "Input", "add_field", "add_numbers"]

#: Pause in milliseconds after a keystroke before a field counts as entered.
_PAUSE_MS = 250
_LOOK = f"dense outlined hide-bottom-space debounce={_PAUSE_MS}"


@dataclass(frozen=True)
class Entry:
    """The place of a field, where a text without a valid value is noted.

    Parameters
    ----------
    misread : Misread
        The texts of the page without a valid value.
    changed : callable
        Called after such a text is noted.
    """

    misread: Misread
    place: Place
    changed: Callable[[], object]

    def part(self, number: int) -> Entry:
        """Return the place of one of several fields that make up a value."""
        return Entry(self.misread, (*self.place, number), self.changed)


class Input(ui.input):
    """A text field that yields a value, or shows below it why its text is not a value.

    Parameters
    ----------
    read : callable
        Returns the value of a text; raises InputError if there is none.
    entry : Entry
        Its place. A text without a value stays there, even if the field is shown again.
    meaning : str
        Shown below the field while it is used.
    """

    def __init__(
        self,
        label: str,
        text: str,
        read: Callable[[str], Any],
        take: Callable[[Any], object],
        entry: Entry,
        *,
        meaning: str = "",
        placeholder: str = "",
    ) -> None:
        self._read, self._take, self.entry = read, take, entry
        wrong = entry.misread.at(entry.place)
        super().__init__(
            label,
            value=text if wrong is None else wrong.text,
            placeholder=placeholder,
            on_change=self._changed,
        )
        # NiceGUI would clear the error after each change.
        self.without_auto_validation()
        if wrong is not None:
            self.error = wrong.sentence
        self.props(f"{_LOOK} hide-hint stack-label")
        if meaning:
            self._props["hint"] = meaning

    def _changed(self) -> None:
        text = self.value or ""
        try:
            value = self._read(text)
        except InputError as error:
            self.error = str(error)
            self.entry.misread.note(self.entry.place, Wrong(text, str(error)))
            self.entry.changed()
            return
        self.error = None
        self.entry.misread.clear(*self.entry.place)
        self._take(value)


def add_field(
    field: Field,
    value: Any,
    take: Callable[[Any], object],
    entry: Entry,
    read: Callable[[str], Any] | None = None,
) -> ui.element:
    """Add a field of the form with its value; ``take`` is called with each new value.

    The field itself reads a text unless there is a function ``read``.
    """
    default = field.option.default_text
    meaning = f"{field.meaning[:1].upper()}{field.meaning[1:]}."
    if field.widget == "switch":
        switch = ui.switch(
            field.label, value=bool(value), on_change=lambda event: take(event.value)
        )
        return switch.props("dense").tooltip(meaning)
    if field.widget == "choice":
        return (
            ui.select(
                list(field.choices),
                label=field.label,
                value=value if value in field.choices else None,
                clearable=True,
                on_change=lambda event: take(event.value),
            )
            .props(
                f"dense outlined options-dense hide-bottom-space stack-label "
                f'display-value="{value if value in field.choices else default}"'
            )
            .tooltip(meaning)
        )
    entered = Input(
        field.label,
        field.text_of(value),
        read or field.value_of,
        take,
        entry,
        meaning=meaning,
        placeholder=default,
    )
    if field.widget == "number":
        entered.props("inputmode=decimal")
    return entered


def add_numbers(
    label: str,
    names: Sequence[str],
    values: Sequence[float],
    take: Callable[[Any], object],
    entry: Entry,
) -> None:
    """Add a row of related numbers, such as a point; ``take`` is called with all of them."""
    numbers = list(values)

    def reader(name: str) -> Callable[[str], float]:
        def read(text: str) -> float:
            try:
                return parse(text)
            except ValueError:
                raise InputError(f"The {name} must be a number, not {text!r}.") from None

        return read

    def taker(index: int) -> Callable[[float], None]:
        def changed(number: float) -> None:
            numbers[index] = number
            take(tuple(numbers))

        return changed

    for index, name in enumerate(names):
        shown = f"{numbers[index]:.10g}"
        Input(name, shown, reader(name), taker(index), entry.part(index)).props(
            f'inputmode=decimal aria-label="{label}, {name}"'
        ).classes("number")

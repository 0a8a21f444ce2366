"""Texts of an autopilot to its pilot (STATUSTEXT), long ones put together from their parts."""

from __future__ import annotations

from typing import Any


__all__ = ["StatusTexts"]

# Characters of a part.
_PART = 50


class StatusTexts:
    """Texts in their order, each once.

    A text of more than 50 characters arrives in numbered parts with a common number, which is not
    0. One of which a part is missing is shown with a gap.
    """

    def __init__(self) -> None:
        self._parts: dict[Any, dict[int, str]] = {}
        self._short = 0

    def take(self, message: Any) -> None:
        """Take a message STATUSTEXT."""
        number, place = getattr(message, "id", 0), getattr(message, "chunk_seq", 0)
        if not number:
            self._short += 1
        key = number or f"short {self._short}"
        self._parts.setdefault(key, {})[place] = str(message.text)

    def clear(self) -> None:
        """Forget all texts."""
        self._parts.clear()

    @property
    def all(self) -> list[str]:
        """The texts."""
        texts = []
        for parts in self._parts.values():
            last = max(parts)
            shown = (parts.get(place, " ... ") for place in range(last + 1))
            text = "".join(shown)
            is_cut = len(parts[last]) == _PART and last > 0
            texts.append(f"{text} ..." if is_cut else text)
        return list(dict.fromkeys(text.strip() for text in texts if text.strip()))

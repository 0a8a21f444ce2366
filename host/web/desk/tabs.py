"""The open tabs of a desk, with a limit for each browser."""

from __future__ import annotations

from dataclasses import dataclass

from nicegui import Client


__all__ = ["MOST_TABS", "Tabs"]

#: Maximum open tabs of a browser; each has a problem in memory.
MOST_TABS = 32
# Maximum open tabs of all browsers.
_MOST_IN_ALL = 256
# Maximum pages that a browser, and all browsers, have fetched and not opened yet: a browser opens a
# page in a second, and a program that only fetches pages never does.
_MOST_FETCHED, _MOST_FETCHED_IN_ALL = 8, 64


@dataclass(eq=False)
class _Tab:
    client: Client
    browser: str
    is_open: bool = False

    def open(self) -> None:
        """Note that the browser has opened its page."""
        self.is_open = True


class Tabs:
    """The tabs of a desk."""

    def __init__(self) -> None:
        self._tabs: list[_Tab] = []

    def admit(self, client: Client, browser: str) -> bool:
        """Return whether a browser may open another page.

        If it has fetched too many pages without opening them, the oldest of them are forgotten. A
        browser that still opens one loads it again.
        """
        self._tabs = [tab for tab in self._tabs if not tab.client.is_deleted]
        opened = [tab for tab in self._tabs if tab.is_open]
        own = sum(tab.browser == browser for tab in opened)
        if own >= MOST_TABS or len(opened) >= _MOST_IN_ALL:
            return False
        new = _Tab(client, browser)
        client.on_connect(new.open)
        self._tabs.append(new)
        fetched = [tab for tab in self._tabs if not tab.is_open]
        of_browser = [tab for tab in fetched if tab.browser == browser]
        for tab in {*of_browser[:-_MOST_FETCHED], *fetched[:-_MOST_FETCHED_IN_ALL]}:
            tab.client.delete()
        return True

"""Names of earlier releases, which are still accepted with a note that gives the new name."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping


__all__ = ["current_engine", "current_setting", "current_top", "current_url"]

_CORES = {
    "genetic=none": "core=none",
    "genetic=0": "core=none",
    "genetic=parallel": "core=paper",
    "genetic=1": "core=paper",
    "genetic=streaming": "core=planner",
}
_IN_URL = re.compile(rf"(?<=[?&])({'|'.join(_CORES)})(?=&|$)")


def current_url(url: str) -> str:
    """Return the URL of a board with the current name of its core."""
    return _IN_URL.sub(lambda found: _current(found[0], _CORES), url)


def current_setting(field: str, value: str) -> tuple[str, str]:
    """Return a field of the configuration and its value, in current words."""
    field, _, value = _current(f"{field}={value}", _CORES).partition("=")
    return field, value


def current_engine(engine: str) -> str:
    """Return the current name of an engine of a planner."""
    return _current(engine, {"cores": "threads"})


def current_top(top: str) -> str:
    """Return the current name of a top-level design of the Verilog."""
    return _current(top, {"planner": "chip"})


def _current(name: str, names: Mapping[str, str]) -> str:
    if name not in names:
        return name
    warnings.warn(f"The old name {name!r} still works; write {names[name]!r}.", stacklevel=3)
    return names[name]

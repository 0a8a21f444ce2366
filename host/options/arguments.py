"""Arguments of the Python API: options that only some planners have, and callbacks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pathgene.host.device.chip import Chip
from pathgene.host.errors import InputError
from pathgene.host.numeric import integer
from pathgene.host.options.kinds import INTEGER
from pathgene.host.options.table import OWN
from pathgene.host.planners import PLANNERS


__all__ = ["own_options", "require_functions"]


def own_options(planner: str, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options that are not None.

    Raises
    ------
    InputError
        If a planner of the registry has no such option, or it has no such value.
    """
    own = {name: value for name, value in options.items() if value is not None}
    if not isinstance(planner, str) or planner not in PLANNERS:
        return own
    having = PLANNERS[planner].options
    for name in options:
        if name not in having:
            raise InputError(
                f"The planner {planner} has no option {name!r}, only {', '.join(having)}."
            )
    for name, value in own.items():
        option = OWN[name]
        if name == "board" and isinstance(value, Chip):
            continue
        if option.kind is INTEGER:
            own[name] = integer(f"option {name}", value)
            continue
        if isinstance(value, str):
            own[name] = value = option.kind.parse(value)
        if not isinstance(value, str) or not value or value not in (option.choices or (value,)):
            kinds = " or ".join(option.choices) or f"a {option.metavar}"
            raise InputError(f"The option {name} must be {kinds}, not {value!r}.")
    return own


def require_functions(**callbacks: Any) -> None:
    """Refuse callbacks that are neither None nor a function.

    Raises
    ------
    InputError
        If a callback is refused.
    """
    for name, callback in callbacks.items():
        if callback is not None and not callable(callback):
            raise InputError(f"The {name} must be a function, not {callback!r}.")

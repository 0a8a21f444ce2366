"""The terms of one path, as reports state them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import Any, Generic, TypeVar, cast


__all__ = ["Evaluation", "Late"]

T = TypeVar("T")


@dataclasses.dataclass(frozen=True)
class Late(Generic[T]):
    """A value of an :class:`Evaluation` that is computed when it is first read."""

    compute: Callable[[], T]


class _LateField(Generic[T]):
    """A field of a dataclass that takes a value or a :class:`Late` one, and returns the value."""

    def __init__(self, *default: T) -> None:
        self._default = default

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    def __get__(self, instance: object | None, owner: type) -> T:
        if instance is None:
            # Here a dataclass asks for the default.
            if not self._default:
                raise AttributeError(self._name)
            return self._default[0]
        values = vars(instance)
        value = values[self._name]
        if isinstance(value, Late):
            value = values[self._name] = value.compute()
        return cast(T, value)

    def __set__(self, instance: object, value: T | Late[T]) -> None:
        vars(instance)[self._name] = value


@dataclasses.dataclass(frozen=True)
class Evaluation:
    """Every term of one path, under the names of ``summary.json``.

    Parameters
    ----------
    feasible : bool
        Penalty 0 both at ``ds`` and at ``ds / 8``.
    feasible_at_ds : bool
        Penalty 0 at ``ds``.
    fitness : float
        Equation (3), inside (0, 2).
    penalty : float
        Equation (1) at ``ds``, metres.
    cost : float
        Equation (2).
    length_m, mean_altitude_m, fuel_N : float
        Values of the smoothed path. The altitude is the exact mean by length.
    distance_under_terrain_m, distance_in_nofly_m, distance_too_steep_m : float
        The terms of the penalty at ``ds``, except that by the strict rule ``distance_in_nofly_m``
        counts each metre once, and the penalty counts it in each zone that holds it.
    impossible_arcs : int
        Interior waypoints whose arc does not fit.
    void_crossed_m : float
        The part of ``distance_under_terrain_m`` over voids.
    minimum_clearance_m : float
        Minimum height over the terrain among the samples of the smoothed path at ``ds / 8``, its
        start and its goal; voids are left out.
    penalty_fine : float
        Equation (1) at ``ds / 8``, metres.

    Under the rules of safe flight, the strict rule gives ``feasible``, ``penalty``, ``fitness`` and
    the distances; ``feasible_at_ds`` is true if the path is feasible by the strict rule or by the
    search surface, and ``penalty_fine`` equals ``penalty``. ``minimum_clearance_m`` is then exact
    to a centimetre and counts the whole corridor, NaN where that covers a void or leaves the map.
    The following are None with ``as_paper``.

    distance_beyond_limits_m : float
        Distance above a ceiling or with more than the engine's power, and the share of the path
        for which there is no fuel.
    max_height_agl_m : float
        Greatest height over the surface.
    flight_time_s : float
        Seconds of the flight.
    fuel_left_N : float
        Fuel left at the goal, the reserve included; None without a ``fuel_weight_N``.
    range_left_m : float
        Distance that this fuel lasts in level flight in still air.
    limits : list of dict
        ``limit``, ``worst`` value, ``allowed`` value and ``at_m``, metres flown; the worst first.
    """

    feasible: bool
    feasible_at_ds: bool
    fitness: float
    penalty: float
    cost: float
    length_m: float
    mean_altitude_m: float
    fuel_N: float
    distance_under_terrain_m: float
    distance_in_nofly_m: float
    distance_too_steep_m: float
    impossible_arcs: int
    void_crossed_m: float
    minimum_clearance_m: _LateField[float] = _LateField()
    penalty_fine: float  # type: ignore[misc]  # The field before it has no default.
    clearance_m: float | None = None
    distance_beyond_limits_m: float | None = None
    max_height_agl_m: _LateField[float | None] = _LateField(None)
    flight_time_s: float | None = None
    fuel_left_N: float | None = None
    range_left_m: float | None = None
    limits: _LateField[list[dict[str, Any]] | None] = _LateField(None)

    def to_dict(self) -> dict[str, Any]:
        """The terms as plain JSON values; ``as_paper`` omits the terms of the rules."""
        if self.limits is None:
            return {name: getattr(self, name) for name in _AS_PAPER}
        # Not `asdict`, which copies each value of thousands of zones.
        terms = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return terms | {"limits": [dict(limit) for limit in self.limits]}

    def __getstate__(self) -> dict[str, Any]:
        """Return all values, for a copy or another process."""
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}


_AS_PAPER = tuple(
    field.name for field in dataclasses.fields(Evaluation) if field.default is dataclasses.MISSING
)

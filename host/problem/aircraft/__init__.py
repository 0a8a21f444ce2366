"""Aircraft: their parameters, the shipped aircraft, and the user's own in TOML."""

import math
from dataclasses import dataclass, field, fields, replace
from importlib import resources
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.inputs import exists, parse_toml, read_text
from pathgene.host.numeric import is_number
from pathgene.host.problem.atmosphere import true_m_s
from pathgene.host.suggestion import did_you_mean


__all__ = ["DEFAULT", "Aircraft", "load", "names", "parse"]

#: The shipped aircraft that is used if none is named.
DEFAULT = "silver-fox"

# Every number of an aircraft lies between these bounds, so that products of some of them fit a
# float.
_LEAST, _MOST = 1e-12, 1e12
# Altitude up to which the standard atmosphere is known.
_HIGHEST_M = 20_000.0


@dataclass(frozen=True, kw_only=True)
class Aircraft:
    """An aircraft: the parameters that the evaluation and the reports use.

    Parameters
    ----------
    name : str
        Shown in reports.
    weight_N : float
        Take-off weight, fuel included.
    fuel_weight_N : float or None
        Weight of the fuel, below ``weight_N``. Under the rules of safe flight, a path may burn at
        most this, minus the reserve.
    wing_span_m, wing_area_m2 : float
        They determine the aspect ratio, span^2 / area.
    lift_coefficient_max : float or None
        It determines the stall speed; under the rules, no turn is possible below that speed.
    zero_lift_drag_coefficient : float
        Drag coefficient at zero lift, CD0.
    oswald_efficiency : float
        Oswald's span efficiency e, above 0 and at most 1.
    engine_power_W : float or None
        Maximum shaft power under the rules.
    specific_fuel_consumption_N_per_Ws : float
        Weight of fuel burned per unit of shaft work.
    propeller_efficiency : float
        Above 0 and at most 1.
    cruise_speed_m_s : float
        The constant true airspeed V of the evaluation.
    equivalent_speed_m_s : float or None
        The equivalent airspeed of the cruise. If ``cruise_speed_m_s`` equals it, as in a file
        without the latter, ``cruise_speed_m_s``, ``max_speed_m_s`` and ``turn_radius_m`` hold at
        sea level, and a problem converts them by :meth:`at`.
    max_speed_m_s : float or None
        Top speed, not below the cruise speed. Not used by the evaluation.
    size_m : float or None
        The largest of span, length and height. Not used by the evaluation.
    service_ceiling_m : float or None
        Maximum altitude under the rules.
    turn_radius_m : float
        Radius R of every arc.
    max_climb_deg, max_descent_deg : float
        Steepest slopes flown, both above 0 and at most 90.
    height_lag_s : float
        Delay of the autopilot's height in climbs; missions that it gets begin their climbs earlier
        by this time. Not used by the evaluation.
    sources : dict of str to str
        Source of each value, by parameter name; ignored in comparisons. Other names are notes.

    Raises
    ------
    InputError
        If a value is missing, not a finite number, or outside its range.
    """

    name: str
    weight_N: float
    wing_span_m: float
    wing_area_m2: float
    zero_lift_drag_coefficient: float
    specific_fuel_consumption_N_per_Ws: float
    propeller_efficiency: float
    cruise_speed_m_s: float
    turn_radius_m: float
    max_climb_deg: float
    max_descent_deg: float
    oswald_efficiency: float = 0.8
    fuel_weight_N: float | None = None
    lift_coefficient_max: float | None = None
    engine_power_W: float | None = None
    equivalent_speed_m_s: float | None = None
    max_speed_m_s: float | None = None
    size_m: float | None = None
    service_ceiling_m: float | None = None
    height_lag_s: float = 3.0
    sources: dict[str, str] = field(default_factory=dict, compare=False, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name.strip():
            raise InputError(f"UAV name must be a non-empty text, not {self.name!r}.")
        for parameter in PARAMETERS:
            value = getattr(self, parameter)
            if value is None and parameter in _OPTIONAL:
                continue
            if not is_number(value) or value <= 0:
                raise InputError(
                    f"UAV {self.name!r}: {parameter} must be a positive number, not {value!r}."
                )
            if not _LEAST <= value <= _MOST:
                raise InputError(
                    f"UAV {self.name!r}: {parameter} must be from {_LEAST:g} to {_MOST:g}, "
                    f"not {value:g}."
                )
            object.__setattr__(self, parameter, float(value))
        for parameter, most in (
            ("oswald_efficiency", 1.0),
            ("propeller_efficiency", 1.0),
            ("max_climb_deg", 90.0),
            ("max_descent_deg", 90.0),
        ):
            if getattr(self, parameter) > most:
                raise InputError(
                    f"UAV {self.name!r}: {parameter} must be at most {most:g}, "
                    f"not {getattr(self, parameter):g}."
                )
        if self.fuel_weight_N is not None and self.fuel_weight_N >= self.weight_N:
            raise InputError(
                f"UAV {self.name!r}: fuel_weight_N must be below weight_N, which "
                f"includes the fuel, not {self.fuel_weight_N:g}."
            )
        if self.max_speed_m_s is not None and self.max_speed_m_s < self.cruise_speed_m_s:
            raise InputError(
                f"UAV {self.name!r}: max_speed_m_s must not be below "
                f"cruise_speed_m_s, not {self.max_speed_m_s:g}."
            )

    @property
    def aerodynamic_speed_m_s(self) -> float:
        """The airspeed of drag, power and stall, which count with the density at sea level."""
        equivalent = self.equivalent_speed_m_s
        return self.cruise_speed_m_s if equivalent is None else equivalent

    def at(self, altitude_m: float) -> "Aircraft":
        """Return the aircraft with the true airspeed and the turn at an altitude.

        It is the same one unless its speeds hold at sea level. The bank of a turn is kept, so the
        radius grows with the square of the speed.
        """
        if self.equivalent_speed_m_s != self.cruise_speed_m_s:
            return self
        most, altitude_m = self.max_speed_m_s, min(altitude_m, _HIGHEST_M)
        true = true_m_s(self.cruise_speed_m_s, altitude_m)
        return replace(
            self,
            cruise_speed_m_s=true,
            turn_radius_m=self.turn_radius_m * (true / self.cruise_speed_m_s) ** 2,
            max_speed_m_s=None if most is None else true_m_s(most, altitude_m),
        )

    @property
    def aspect_ratio(self) -> float:
        """Wing span squared over wing area."""
        return self.wing_span_m**2 / self.wing_area_m2

    @property
    def induced_drag_factor(self) -> float:
        """The factor k = 1 / (pi e AR): the drag coefficient due to lift is k CL^2."""
        return 1.0 / (math.pi * self.oswald_efficiency * self.aspect_ratio)

    def to_dict(self) -> dict[str, Any]:
        """Name and parameters as plain JSON values; :func:`from_dict` converts them back."""
        return {"name": self.name} | {
            parameter: getattr(self, parameter)
            for parameter in PARAMETERS
            if getattr(self, parameter) is not None
        }

    @staticmethod
    def load(name_or_toml: str | Path) -> "Aircraft":
        """Load a shipped aircraft by name, or a user's own from a ``.toml`` file.

        Raises
        ------
        InputError
            If there is no such name or file, or it is not a valid aircraft.
        """
        return load(name_or_toml)

    @staticmethod
    def names() -> list[str]:
        """Names of the shipped aircraft."""
        return names()

    @classmethod
    def from_dict(cls, table: dict[str, Any], where: str) -> "Aircraft":
        """Make an aircraft from a table of names and values, as parsed from TOML or JSON.

        Raises
        ------
        InputError
            If a parameter is missing, unknown or bad; ``where`` names the table in the sentence.
        """
        if "equivalent_speed_m_s" in table:
            table = {"cruise_speed_m_s": table["equivalent_speed_m_s"], **table}
        known = {"name", "sources", *PARAMETERS}
        unknown = sorted(set(table) - known)
        if unknown:
            raise InputError(
                f"{where}: unknown UAV parameter {unknown[0]!r}; known are "
                f"{', '.join(sorted(known))}."
            )
        needed = {"name", *PARAMETERS} - {"oswald_efficiency", "height_lag_s", *_OPTIONAL}
        missing = sorted(needed - set(table))
        if missing:
            raise InputError(
                f"{where}: UAV parameter {missing[0]!r} is missing; add it to the file."
            )
        sources = table.get("sources", {})
        if not isinstance(sources, dict) or not all(
            isinstance(source, str) for source in sources.values()
        ):
            raise InputError(f"{where}: [sources] must map names to texts.")
        return cls(**table)


# Every number of an aircraft, in the order of the dataclass.
PARAMETERS = tuple(f.name for f in fields(Aircraft) if f.name not in ("name", "sources"))
# The optional numbers of an aircraft.
_OPTIONAL = tuple(f.name for f in fields(Aircraft) if f.default is None)


def names() -> list[str]:
    """Names of the shipped aircraft, sorted."""
    return sorted(
        entry.name.removesuffix(".toml")
        for entry in resources.files(__name__).iterdir()
        if entry.name.endswith(".toml")
    )


def load(name_or_toml: str | Path) -> Aircraft:
    """Load a shipped aircraft by name, or a user's own from a ``.toml`` file.

    Raises
    ------
    InputError
        If there is no such aircraft or file, or its values are bad.
    """
    text = str(name_or_toml)
    if text in names():
        return parse(resources.files(__name__).joinpath(f"{text}.toml").read_text("utf-8"), text)
    if not text.endswith(".toml") and exists(text):
        raise InputError(
            f"The name of a UAV file must end in .toml, unlike {text!r}; shipped are "
            f"{', '.join(names())}."
        )
    if not text.endswith(".toml"):
        raise InputError(
            f"There is no UAV {text!r}{did_you_mean(text, names())}; give one of "
            f"{', '.join(names())}, or a .toml file."
        )
    try:
        return parse(read_text(Path(text)), text)
    except UnicodeDecodeError:
        raise InputError(f"{text}: not a TOML file, it is not UTF-8 text.") from None
    except OSError as error:
        reason = error.strerror or "unknown reason"
        raise InputError(f"Cannot read UAV file {text!r}: {reason}.") from None


def parse(toml: str, where: str) -> Aircraft:
    """Make an aircraft from the text of a TOML file; ``where`` names it in error sentences.

    Raises
    ------
    InputError
        If the text is not TOML, or a parameter is missing, unknown or bad.
    """
    try:
        table = parse_toml(toml)
    except ValueError as error:
        raise InputError(f"{where}: not valid TOML: {error}.") from None
    return Aircraft.from_dict(table, where)

"""Unit and datum of heights, and sentences on heights above the ellipsoid."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Remark


__all__ = ["ELLIPSOID", "ELLIPSOID_ACCEPTED", "NO_GEOID", "Vertical", "ellipsoid_refusal"]

#: Name of the datum of heights above the ellipsoid.
ELLIPSOID = "ellipsoid"
#: The warning that heights stay above the ellipsoid.
ELLIPSOID_ACCEPTED = Remark(
    Grade.WARNING,
    "Heights and all altitudes count from the ellipsoid, not from the sea, as --heights "
    "ellipsoidal accepts; the two differ by up to 107 m.",
)
#: The usual reason why heights cannot be turned.
NO_GEOID = (
    "PROJ has no grid of the geoid to turn them to heights above the sea: install "
    "us_nga_egm96_15.tif (pyproj sync --file us_nga_egm96_15)"
)


@dataclass(frozen=True)
class Vertical:
    """Unit and datum of the heights of a file.

    Parameters
    ----------
    unit : str
        Name of the unit.
    unit_m : float
        Its metres; negative if the file has depths.
    unit_from, datum_from : str
        Their origin: ``file``, ``option`` or ``assumed``.
    datum : str
        Name of the datum.
    is_ellipsoidal : bool
        Heights above the ellipsoid.
    stated : str
        Name of the reference system that states it.
    remarks : tuple of Remark
        Contradictions between the file and the user.
    """

    unit: str
    unit_m: float
    unit_from: str
    datum: str
    datum_from: str
    is_ellipsoidal: bool = False
    stated: str = ""
    remarks: tuple[Remark, ...] = ()

    @property
    def facts(self) -> dict[str, Any]:
        """The unit and datum, for a report."""
        return {
            "unit": self.unit,
            "unit_from": self.unit_from,
            "datum": self.datum,
            "datum_from": self.datum_from,
        }


def ellipsoid_refusal(name: str | Path, stated_by: str, reason: str) -> InputError:
    """Return the refusal of heights above the ellipsoid that cannot be turned.

    Parameters
    ----------
    stated_by : str
        The part of the file that states the ellipsoid.
    reason : str
        Reason why they cannot be turned, and its remedy.
    """
    return InputError(
        f"{name}: its heights count from the ellipsoid ({stated_by}), and {reason}, or accept "
        "altitudes above the ellipsoid in all files (--heights ellipsoidal)."
    )

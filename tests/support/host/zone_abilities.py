"""The statements that each format of zones can make, from the definitions of the formats."""

from dataclasses import dataclass


_METRES = (("AMSL", "m"),)
_BOTH = (("AMSL", "m"), ("AMSL", "ft"), ("AGL", "m"), ("AGL", "ft"))
_LEVELS = (("STD", "FL"),)
_WGS84 = (("WGS84", "m"), ("WGS84", "ft"))


@dataclass(frozen=True)
class Ability:
    """A format.

    Parameters
    ----------
    limits, circle_limits : tuple
        Pairs of surface and unit; ``circle_limits`` of circles if they differ.
    one_unit, one_surface : bool
        Both limits have the same.
    hours : str
        ``moments``, ``schedule``, ``sun`` (a schedule that also follows the sun), or none.
    classes : tuple
        Words of the file, with the class in the product's documents and its default.
    """

    limits: tuple = ()
    circle_limits: tuple = ()
    limits_inside: bool = False
    one_unit: bool = False
    one_surface: bool = False
    upper_alone: bool = False
    hours: str = ""
    both_moments: bool = False
    one_period: bool = False
    offsets: bool = False
    events: frozenset = frozenset({"SR", "SS", "BMCT", "EECT"})
    nights: bool = True
    seconds: bool = False
    classes: tuple = ()
    circles: bool = True
    sectors: bool = False
    holes: bool = True
    far: bool = True
    keeps_in: bool = False
    keeps_out: bool = True
    many: bool = True
    named: bool = True


_UAS = (
    ("PROHIBITED", "PROHIBITED", True),
    ("REQ_AUTHORISATION", "REQ_AUTHORISATION", True),
    ("CONDITIONAL", "CONDITIONAL", True),
    ("NO_RESTRICTION", "NO_RESTRICTION", False),
)
_ED318 = (
    *_UAS,
    ("REQ_AUTHORIZATION", "REQ_AUTHORISATION", True),
    ("USPACE", "USPACE", True),
)
# Type and ICAO class by the numbers of openAIP.
_OPENAIP = (
    ("1 8", "RESTRICTED", True),
    ("2 8", "DANGER", True),
    ("3 8", "PROHIBITED", True),
    ("4 3", "CTR", True),
    ("7 2", "TMA", True),
    ("0 2", "C", True),
    ("0 4", "E", False),
    ("0 6", "G", False),
    ("10 6", "FIR", False),
    ("21 8", "GLIDING", False),
    ("33 6", "FIS", False),
)
# Class and type of version 2 of OpenAir.
_OPENAIR = (
    ("R ", "RESTRICTED", True),
    ("Q ", "DANGER", True),
    ("P ", "PROHIBITED", True),
    ("CTR ", "CTR", True),
    ("C ", "C", True),
    ("D ", "D", True),
    ("E ", "E", False),
    ("G ", "G", False),
    ("W ", "WAVE", False),
    ("GP ", "NOGLIDER", True),
    ("RMZ ", "RMZ", True),
    ("D TMA", "TMA", True),
    ("G RMZ", "RMZ", True),
    ("UNC R", "RESTRICTED", True),
    ("UNC GSEC", "GLIDING", False),
)
_KML = Ability(
    limits=(("AMSL", "m"), ("AGL", "m")), circle_limits=_METRES, one_surface=True,
    upper_alone=True, seconds=True,
)  # fmt: skip

#: The formats by name.
ABILITIES = {
    "geojson": Ability(limits=(*_BOTH, *_LEVELS, *_WGS84), seconds=True),
    "openaip": Ability(
        limits=(*_BOTH, *_LEVELS), hours="sun", one_period=True, circles=False,
        events=frozenset({"SR", "SS"}), nights=False, classes=_OPENAIP,
    ),
    "ed269": Ability(
        limits=_BOTH, one_unit=True, hours="sun", both_moments=True, offsets=True, classes=_UAS,
    ),
    "ed318": Ability(
        limits=(*_BOTH, *_WGS84), one_unit=True, hours="sun", offsets=True, classes=_ED318,
    ),
    "inav": Ability(limits=_METRES, holes=False, keeps_in=True),
    "openair": Ability(
        limits=(*_BOTH, *_LEVELS), hours="moments", classes=_OPENAIR, sectors=True, holes=False,
    ),
    "kml": _KML,
    "kmz": _KML,
    "plan": Ability(holes=False, keeps_in=True, named=False),
    "waypoints": Ability(holes=False, keeps_in=True, named=False),
    "fen": Ability(
        circles=False, holes=False, far=False, keeps_in=True, keeps_out=False, many=False,
        named=False,
    ),
}  # fmt: skip

"""Scenes of zones as OpenAir."""

import random
from datetime import UTC

from pyproj import Geod


_EARTH = Geod(ellps="WGS84")


def openair(scene, style, places):
    """Return the file of a scene; ``style`` and ``places`` come from the writers."""
    lines = ["* made for a test"]
    for area in scene.areas:
        rng = style(scene, area)
        kind, _, type_of = area.word.partition(" ")
        lines += ["", f"AC {kind}", *([f"AY {type_of}"] if type_of else []), f"AN {area.name}"]
        lines += [f"AL {_limit(area.lower, 'GND', rng)}", f"AH {_limit(area.upper, 'UNL', rng)}"]
        for hours in area.hours:
            start, end = (
                "NONE" if each is None else f"{each.astimezone(UTC):%Y-%m-%dT%H:%MZ}"
                for each in (hours.start, hours.end)
            )
            lines.append(f"AA {start}/{end}")
        lines += _outline(scene, area, rng, places)
    rng = random.Random(f"encoding {scene.seed}")
    text = rng.choice(("\n", "\r\n")).join(lines)
    return text.encode(rng.choice(("utf-8", "utf-8-sig", "cp1252")))


def _limit(limit, none, rng):
    if limit is None:
        return none
    if limit.unit == "FL":
        return rng.choice((f"FL {limit.value:.0f}", f"FL{limit.value:03.0f}"))
    if limit.surface == "AGL" and limit.value == 0:
        return "SFC"
    word = {"AMSL": ("AMSL", "MSL"), "AGL": ("AGL", "GND")}[limit.surface]
    return f"{limit.value:g} {limit.unit} {rng.choice(word)}"


def _outline(scene, area, rng, places):
    def text(pairs):
        return [_place(pair, rng) for pair in pairs]

    if area.circle:
        (centre,) = text(places(scene, area, [area.circle[:2]], rng))
        return [f"V X={centre}", f"DC {area.circle[2] / 1852:.6f}"]
    if area.sector:
        lon, lat, radius_m, first, last = area.sector
        (centre,) = text(places(scene, area, [(lon, lat)], rng))
        lines = [f"V X={centre}"]
        is_forward = rng.random() < 0.5
        begin, end = (first, last) if is_forward else (last, first)
        lines.append(f"V D={'+' if is_forward else '-'}")
        if rng.random() < 0.5:
            lines.append(f"DA {radius_m / 1852:.6f},{begin % 360},{end % 360}")
        else:
            ends = [_EARTH.fwd(lon, lat, each, radius_m)[:2] for each in (begin, end)]
            lines.append("DB " + ", ".join(text(places(scene, area, ends, rng))))
        return [*lines, f"DP {centre}"]
    corners = text(places(scene, area, area.rings[0], rng))
    if rng.random() < 0.5:
        corners.append(corners[0])
    return [f"DP {corner}" for corner in corners]


def _place(pair, rng):
    kind = rng.randrange(3)
    lon, lat = ((each + 180) % 360 - 180 if abs(each) > 180 else each for each in pair)
    sides = (("NS"[lat < 0], abs(lat), 2), ("EW"[lon < 0], abs(lon), 3))
    return " ".join(f"{_angle(size, width, kind)} {letter}" for letter, size, width in sides)


def _angle(size, width, kind):
    if kind == 0:
        return f"{size:.7f}"
    whole = int(size)
    if kind == 1:
        return f"{whole:0{width}}:{(size - whole) * 60:08.5f}"
    minutes = int((size - whole) * 60)
    seconds = (size - whole - minutes / 60) * 3600
    return f"{whole:0{width}}:{minutes:02}:{max(seconds, 0):06.3f}"

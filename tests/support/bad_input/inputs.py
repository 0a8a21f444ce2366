"""Bad inputs of the command line, made at random from good ones: damaged files and odd options.

A case is a command line with its files. The files are created in a new folder; the good files that
it refers to are in ``../base`` (:mod:`tests.support.bad_input.good_inputs`).
"""

import copy
import dataclasses
import io
import json
import random
import re
import zipfile
from collections.abc import Callable, Iterator
from itertools import starmap
from typing import Any

import numpy as np

from pathgene.host.problem.aircraft import load as load_aircraft
from tests.support.bad_input.extremes import (
    deep_zones,
    dotted_keys,
    huge_terrain,
    odd_name,
    repeated,
)
from tests.support.bad_input.good_inputs import (
    CSV,
    KML,
    LINE,
    RECORD,
    VIRTUAL,
    array,
    land,
    plan_file,
    raster,
    summary,
    table,
    toml,
    zones,
)
from tests.support.bad_input.judge import is_unreadable
from tests.support.bad_input.options import CHECK, LAND, Case, board, number, option


ENTITIES = (
    '<?xml version="1.0"?><!DOCTYPE kml [<!ENTITY a0 "aaaaaaaaaa">'
    + "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 10))
    + "]><kml>&a9;</kml>"
)

#: Unexpected values that JSON and TOML can express.
ODD: tuple[Any, ...] = (
    None,
    True,
    0,
    -1,
    7,
    2**70,
    10**400,
    1e308,
    -1e308,
    1e-320,
    float("nan"),
    float("inf"),
    "",
    "x",
    "1",
    "a\0b",
    "\ud800",
    "/dev/zero",
    "x" * 5000,
    [],
    {},
    [[]],
    [None],
    [1, 2, 3],
    [1] * 5000,
    {"x": 1},
)


def grid(rng: random.Random) -> bytes:
    """An ASCII grid with some odd numbers."""
    rows = [" ".join(f"{height:g}" for height in row) for row in land().elevation[::-1]]
    head = ("ncols 21", "nrows 21", "xllcorner 0", "yllcorner 0", "cellsize 100")
    lines = [*head, "NODATA_value -9999", *rows]
    at = rng.randrange(len(lines))
    words = lines[at].split()
    words[rng.randrange(len(words))] = odd_text(rng)
    lines[at] = " ".join(words)
    return "\n".join(lines).encode()


def archive(rng: random.Random) -> bytes:
    """An ``.npz`` with an odd member."""
    members: dict[str, Any] = {
        "elevation": land().elevation, "dx_m": 100.0, "dy_m": 100.0, "crs": "EPSG:32632",
        "origin": (500_000.0, 5_100_000.0),
    }  # fmt: skip
    odd = (
        0.0, -1.0, np.nan, np.inf, 1e308, 1e-320, "EPSG:4326", "EPSG:999999", "x" * 9000, b"x", 1j,
        True, np.zeros((3, 3)), np.zeros((2, 2, 2)), np.full((9, 9), np.nan), np.zeros((1, 9)),
        np.zeros((0, 5)), np.array([["a", "b"]]), np.full((9, 9), 1e308), np.array(["nan"] * 4),
        np.full((9, 9), -1e308), np.array([np.nan, 1e308]), np.zeros((9, 9), np.complex64),
        "PROJCS[", "+proj=utm +zone=99", "GEOGCS[]", "\0", np.zeros((9, 9), np.float16),
    )  # fmt: skip
    key = rng.choice(list(members))
    if rng.random() < 0.2:
        del members[key]
    else:
        members[key] = rng.choice(odd)
    made = io.BytesIO()
    np.savez(made, **members)
    return made.getvalue()


def header(rng: random.Random) -> bytes:
    """The beginning of an array, with an impossible shape or type."""
    shape = rng.choice(
        ((10**6, 10**6), (-2, 5), (0, 0), (1, 25_000_001), (2, 10**400), (5,), (), (21, 21, 21))
    )
    kind = rng.choice(("<f8", "<U99999999", "|O", "<M8[s]", "<i1", "|V8", "<c16", "x"))
    stated = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode()
    length = rng.choice((len(stated), 0, 4_000_000_000, 60))
    return b"\x93NUMPY\x02\x00" + length.to_bytes(4, "little") + stated + bytes(rng.randrange(99))


def odd_text(rng: random.Random) -> str:
    """A word that is not a number, or an unusual number."""
    return rng.choice(
        ("nan", "inf", "-inf", "-0", "1e308", "-1e308", "1e-320", "9" * 400, "", "x", "1,5", "--",
         "١٢", "0x10", "1e99999", "\0", "2147483648", "99999999999", "-5")
    )  # fmt: skip


def damaged(rng: random.Random, content: bytes) -> bytes:
    """Return bytes that are truncated, have changed bits or parts, or another encoding."""
    match rng.randrange(9):
        case 0:
            return content[: rng.randrange(len(content))]
        case 1 | 2 | 3:
            changed = bytearray(content)
            # The beginning of a file determines how the rest is read.
            reach = rng.choice((len(changed), min(400, len(changed))))
            for _ in range(rng.randint(1, 8)):
                changed[rng.randrange(reach)] ^= 1 << rng.randrange(8)
            return bytes(changed)
        case 4:
            at = rng.randrange(len(content))
            return content[:at] + rng.randbytes(rng.randint(1, 40)) + content[at:]
        case 5:
            first, last = sorted(rng.choices(range(len(content)), k=2))
            return content[:first] + content[last:]
        case 6:
            return content.decode("latin-1").encode(rng.choice(("utf-16", "utf-32", "utf-7")))
        case 7:
            return b"\xef\xbb\xbf" * rng.randint(1, 2) + content + b"\0"
    return rng.choice((b"", b"\0" * 99, b"\xff\xfe", rng.randbytes(300)))


def mutated(rng: random.Random, document: Any, *, in_toml: bool = False) -> Any:
    """Return a document with one to three of its values gone, moved or replaced by an odd one."""
    document = copy.deepcopy(document)
    for _ in range(rng.randint(1, 3)):
        places = list(_places(document))
        if not places:
            break
        # All places in a long list are equivalent, so a shallow place is as likely as a deep one.
        depth = rng.choice(sorted({place[0] for place in places}))
        _, holder, key = rng.choice([place for place in places if place[0] == depth])
        # TOML has no null.
        value = rng.choice([odd for odd in ODD if not (in_toml and odd in (None, [None]))])
        match rng.randrange(5):
            case 0:
                del holder[key]
            case 1:
                holder[key] = [holder[key]]
            case 2 if isinstance(holder, dict):
                holder[rng.choice(("x", "", f"{key} ", "é"))] = holder.pop(key)
            case _:
                holder[key] = copy.deepcopy(value)
    return document


def _places(document: Any, depth: int = 0) -> Iterator[tuple[int, Any, Any]]:
    """Yield depth, container and key of every value."""
    items = document.items() if isinstance(document, dict) else enumerate(document)
    for key, value in list(items):
        yield depth, document, key
        if isinstance(value, dict | list):
            yield from _places(value, depth + 1)


def as_json(rng: random.Random, document: Any) -> bytes:
    """Return a mutated document, damaged text, or a deeply nested document."""
    if rng.random() < 0.05:
        depth = rng.choice((900, 5000, 100_000))
        return b'{"waypoints":' + b"[" * depth + b"]" * depth + b"}"
    if rng.random() < 0.15:
        return damaged(rng, json.dumps(document).encode())
    return json.dumps(mutated(rng, document)).encode()


def as_toml(rng: random.Random, document: dict[str, Any]) -> bytes:
    """Return the same in TOML."""
    if rng.random() < 0.05:
        return b"a = " + b"[" * 3000
    content = toml(mutated(rng, document, in_toml=True))
    return damaged(rng, content) if rng.random() < 0.15 else content


def as_kml(rng: random.Random, text: str = KML) -> bytes:
    """Return KML with a number, a word or a tag replaced."""
    choice = rng.random()
    if choice < 0.05:
        return ENTITIES.encode()
    if choice < 0.1:
        return b"<kml>" + b"<a>" * 100_000
    if choice < 0.25:
        return damaged(rng, text.encode())
    found = rng.choice(list(re.finditer(r"[-\d.]+|\w+", text)))
    return (text[: found.start()] + odd_text(rng) + text[found.end() :]).encode()


def as_csv(rng: random.Random, text: str = CSV) -> bytes:
    """Return a CSV with a cell replaced."""
    if rng.random() < 0.25:
        return damaged(rng, text.encode())
    found = rng.choice(list(re.finditer(r"[^,\n]+", text)))
    return (text[: found.start()] + odd_text(rng) + text[found.end() :]).encode()


def terrain(rng: random.Random) -> Case:
    """A damaged terrain of any format."""
    name, made = rng.choice(
        (
            ("x.npz", lambda: archive(rng)),
            ("x.npz", lambda: damaged(rng, archive(rng))),
            ("x.npy", lambda: damaged(rng, array(land().elevation))),
            ("x.npy", lambda: header(rng)),
            ("x.asc", lambda: grid(rng)),
            ("x.asc", lambda: damaged(rng, grid(rng))),
            ("x.tif", lambda: damaged(rng, raster("EPSG:32632", 100.0, (0.0, 0.0)))),
            ("x.tif", lambda: damaged(rng, raster("EPSG:4326", 0.001, (8.0, 46.0)))),
            ("x.tif", lambda: odd_raster(rng)),
            ("x.vrt", lambda: as_kml(rng, VIRTUAL)),
            ("N46E008.hgt", lambda: bytes(rng.choice((0, 100, 25_934_402, 2_884_801)))),
        )
    )
    name = rng.choice(("x.tif", "x.npz", "x.npy", "x.asc", "x")) if rng.random() < 0.1 else name
    options = ("--fill-voids",) if rng.random() < 0.3 else ()
    options += ("--cell", "100") if name.endswith((".npy", "x")) else ()
    arguments = ("terrain", "info", name, *options)
    if rng.random() < 0.3:
        arguments = ("check", "--terrain", name, "--path", "../base/path.csv", *options)
    return Case(f"terrain {name}", arguments, {name: made()})


def odd_raster(rng: random.Random) -> bytes:
    """A GeoTIFF with an impossible place or impossible heights."""
    side = rng.choice((0.0, -1.0, 1e-9, 1e-320, 1e9, 1e308, float("nan"), float("inf"), 0.5))
    corner = tuple(rng.choice((0.0, 8.0, 179.99, 1e308, float("nan"), -90.0)) for _ in range(2))
    crs = rng.choice((None, "EPSG:32632", "EPSG:4326", "EPSG:3857", "EPSG:4978", "EPSG:2056"))
    return raster(crs, side, (corner[0], corner[1]), nodata=rng.choice((None, 0.0, 1e38)))


def zone_file(rng: random.Random) -> Case:
    """A damaged file of zones."""
    name, made = rng.choice(
        (
            ("x.geojson", lambda: as_json(rng, zones())),
            ("x.kml", lambda: as_kml(rng)),
            ("x.plan", lambda: as_json(rng, plan_file())),
        )
    )
    return Case(f"zones {name}", (*CHECK, "--nofly", name), {name: made()})


def path_file(rng: random.Random) -> Case:
    """A damaged path."""
    name, made = rng.choice(
        (("x.csv", lambda: as_csv(rng)), ("x.geojson", lambda: as_json(rng, LINE)))
    )
    return Case(f"path {name}", ("check", "--terrain", LAND, "--path", name), {name: made()})


def summary_file(rng: random.Random) -> Case:
    """A damaged summary, for each command that reads one."""
    arguments = rng.choice(
        (
            ("check", "--path", "summary.json"),
            ("export", "summary.json"),
            ("upload", "summary.json", "--to", "udpout:127.0.0.1:9", "--timeout", "0.01"),
        )
    )
    return Case(f"summary, {arguments[0]}", arguments, {"summary.json": as_json(rng, summary())})


def mission_file(rng: random.Random) -> Case:
    """A damaged ``.plan`` for an autopilot."""
    to = ("--to", "udpout:127.0.0.1:9", "--timeout", "0.01")
    return Case("plan", ("upload", "x.plan", *to), {"x.plan": as_json(rng, plan_file())})


def problem_file(rng: random.Random) -> Case:
    """A damaged problem file."""
    content = as_toml(rng, table())
    return Case("problem", ("problem", "check", "x.toml"), {"x.toml": content})


def aircraft_file(rng: random.Random) -> Case:
    """A damaged aircraft."""
    content = as_toml(rng, load_aircraft("silver-fox").to_dict())
    return Case("aircraft", (*CHECK, "--uav", "x.toml"), {"x.toml": content})


def wrong_kind(rng: random.Random) -> Case:
    """A problem or an aircraft without a required number."""
    made = table() if rng.random() < 0.5 else load_aircraft("silver-fox").to_dict()
    document = copy.deepcopy(made)
    numbers = [
        (holder, key)
        for _, holder, key in _places(document)
        if isinstance(holder[key], int | float) and not isinstance(holder[key], bool)
    ]
    holder, key = rng.choice(numbers)
    holder[key] = rng.choice(("x", "", "1e", [], {}, [[]], {"x": 1}, float("nan"), ["1"]))
    if "mission" in document:
        return Case("problem", ("problem", "check", "x.toml"), {"x.toml": toml(document)}, True)
    return Case("aircraft", (*CHECK, "--uav", "x.toml"), {"x.toml": toml(document)}, True)


def checker_files(rng: random.Random) -> Case:
    """A damaged map or path of the collision checker."""
    arguments = ("feasible", "--map", "map.npy", "--path", "cells.csv")
    files = {
        "map.npy": array(np.zeros((32, 32), np.int64)),
        "cells.csv": b"x,y,z\n1,1,5\n20,20,5\n",
    }
    if rng.random() < 0.5:
        files["cells.csv"] = as_csv(rng, "x,y,z\n1,1,5\n9,9,5\n20,20,5\n")
    else:
        made = rng.choice((damaged(rng, files["map.npy"]), header(rng), array(np.zeros((3, 3)))))
        files["map.npy"] = made
    return Case("feasible", arguments, files)


def store(rng: random.Random) -> Case:
    """Damaged stored runs of a comparison; intact ones would belong to another problem."""
    lines = [as_json(rng, RECORD) for _ in range(3)]
    arguments = (
        "compare", "--terrain", LAND, "--start", "150,150,600", "--goal", "1550,1550,600",
        "--planners", "ga-pc", "--generations", "1", "--runs", "1", "--jobs", "1", "--out", ".",
    )  # fmt: skip
    return Case("store", arguments, {"runs.jsonl": b"\n".join(lines)})


def archive_bomb(rng: random.Random) -> Case:
    """A small archive with a member of gigabytes."""
    made = io.BytesIO()
    large = rng.choice(("elevation", "dx_m"))
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as file:
        for key in ("elevation", "dx_m", "dy_m"):
            content = array(np.zeros((3, 3)) if key == "elevation" else 100.0)
            if key == large:
                content = header(rng) + bytes(50_000_000)
            # Without the time of day, so that the same seed gives the same bytes.
            file.writestr(zipfile.ZipInfo(f"{key}.npy"), content, zipfile.ZIP_DEFLATED)
    return Case("bomb", ("terrain", "info", "x.npz"), {"x.npz": made.getvalue()})


#: Makers of cases, each with its share.
KINDS: tuple[tuple[Callable[[random.Random], Case], int], ...] = (
    (terrain, 28),
    (zone_file, 16),
    (path_file, 7),
    (summary_file, 18),
    (mission_file, 5),
    (problem_file, 14),
    (aircraft_file, 6),
    (wrong_kind, 14),
    (checker_files, 4),
    (store, 1),
    (archive_bomb, 1),
    (number, 24),
    (option, 10),
    (board, 6),
    (huge_terrain, 5),
    (deep_zones, 4),
    (dotted_keys, 2),
    (odd_name, 5),
    (repeated, 3),
)


def cases(seed: int, count: int) -> Iterator[Case]:
    """Yield ``count`` cases; with the same seed, a larger count continues a smaller one."""
    for index in range(count):
        rng = random.Random(f"{seed} {index}")
        (make,) = rng.choices([kind for kind, _ in KINDS], [share for _, share in KINDS])
        case = make(rng)
        surely_bad = case.surely_bad or any(starmap(is_unreadable, case.files.items()))
        yield dataclasses.replace(case, surely_bad=surely_bad)

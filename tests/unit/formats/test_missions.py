"""Missions in files of other programs, compared with independent readers of the formats."""

import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.formats.mission_items import ARDUPILOT, PX4
from pathgene.host.formats.registry import mission_files, read_mission
from tests.support.host.planted_missions import KINDS, plant


fastkml = pytest.importorskip("fastkml")
mavwp = pytest.importorskip("pymavlink.mavwp")

LINE = [(10.01, 46.5, 800.0), (10.02, 46.51, 812.5), (10.03, 46.5, 790.25)]


def written(tmp_path, name, text):
    file = tmp_path / name
    file.write_text(text)
    return file


def read(tmp_path, name, text):
    return read_mission(written(tmp_path, name, text))


def refused(tmp_path, name, text):
    file = written(tmp_path, name, text)
    with pytest.raises(InputError) as error:
        read_mission(file)
    return str(error.value).removeprefix(f"{file}: ")


def places(mission):
    return [(item.lon, item.lat, item.alt_m) for item in mission.items]


def plan(items, **mission):
    table = {"version": 2, "items": items, **mission}
    return json.dumps({"fileType": "Plan", "version": 1, "mission": table})


def simple(command, params, frame=0, **more):
    return {"type": "SimpleItem", "command": command, "frame": frame, "params": params, **more}


def test_the_sources_are_made_of_the_rows():
    assert mission_files() == ".plan, .waypoints, a line of KML, a line of GPX or CSV in degrees"


# --- Lists of waypoints --------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [kind for kind in KINDS if plant(kind, 0, faulty=True).waypoints])
def test_waypoints_are_as_the_loader_of_pymavlink_reads_them(kind, tmp_path):
    file = written(tmp_path, "m.waypoints", plant(kind, 0, faulty=True).waypoints)
    loader = mavwp.MAVWPLoader()
    loader.load(str(file))
    ours = read_mission(file)
    assert ours.autopilot == ARDUPILOT
    theirs = [loader.wp(number) for number in range(1, loader.count())]
    assert [item.number for item in ours.items] == [row.seq for row in theirs]
    for item, row in zip(ours.items, theirs, strict=True):
        assert (item.command, item.frame) == (row.command, row.frame)
        assert item.params == (row.param1, row.param2, row.param3, row.param4)
        assert (item.lat or 0, item.lon or 0, item.alt_m) == (row.x, row.y, row.z)


ROW = "{}\t0\t{}\t{}\t0\t0\t0\t0\t{}\t{}\t{}\t1"


def rows(*values):
    return "\n".join(["QGC WPL 110", *(ROW.format(*each) for each in values), ""])


def test_row_0_is_home_and_rows_of_fences_are_no_items(tmp_path):
    text = rows(
        (0, 0, 16, 46.5, 10.0, 700),
        (1, 3, 22, 0, 0, 40),
        (2, 3, 16, 46.6, 10.1, 90),
        (3, 0, 5003, 46.5, 10.0, 0),
        (4, 3, 5100, 46.55, 10.05, 80),
    )
    mission = read(tmp_path, "m.txt", f"{text}# a remark\n\n")
    assert mission.home == (46.5, 10.0, 700)
    assert mission.has_fences
    assert mission.rally == ((46.55, 10.05, 80),)
    assert [(item.number, item.lat) for item in mission.items] == [(1, None), (2, 46.6)]


def test_home_at_0_is_none(tmp_path):
    text = rows((0, 0, 16, 0, 0, 0), (1, 0, 16, 46.5, 10.0, 700))
    assert read(tmp_path, "m.waypoints", text).home is None


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("QGC WPL 110\n1\t0\t0\t16\n", "line 2 is no row of 12 numbers."),
        (
            "QGC WPL 100\n1\t0\t0\t16\n",
            "its first line is 'QGC WPL 100', whose columns may mean something else; save it as "
            "QGC WPL 110.",
        ),
        (rows((1, 0, 16.5, 1, 1, 1)), "line 2 is no row of 12 numbers."),
        (rows((0, 0, 16, 1, 1, 1)), "there is no item of a mission in it."),
        (rows((2, 0, 16, 1, 1, 1), (2, 0, 16, 1, 1, 1)), "its item 2 follows item 2."),
    ],
)
def test_a_bad_list_is_refused(text, sentence, tmp_path):
    assert refused(tmp_path, "m.waypoints", text) == sentence


# --- Plans ---------------------------------------------------------------------------------------


def test_transects_of_surveys_are_read_with_their_numbers(tmp_path):
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "TransectStyleComplexItem": {
            "Items": [
                simple(16, [0, 0, 0, None, 46.5, 10.0, 80], 3, doJumpId=2),
                simple(206, [25, 0, 1, 0, 0, 0, 0], 2, doJumpId=3),
            ]
        },
    }
    items = [simple(22, [15, 0, 0, None, 0, 0, 50], 3, doJumpId=1), survey, simple(20, [0] * 7, 2)]
    home = [46.4, 10.1, 650]
    mission = read(tmp_path, "m.plan", plan(items, firmwareType=12, plannedHomePosition=home))
    assert [(item.number, item.command, item.within) for item in mission.items] == [
        (1, 22, ""),
        (2, 16, "survey 2"),
        (3, 206, "survey 2"),
        (4, 20, ""),
    ]
    assert mission.autopilot == PX4
    assert mission.home == (46.4, 10.1, 650)
    assert mission.items[1].params == (0, 0, 0, None)
    assert not mission.has_fences


def test_a_home_without_a_height_or_place(tmp_path):
    item = simple(16, [0, 0, 0, None, 46.5, 10.0, 80])
    text = plan([item], plannedHomePosition=[46.4, 10.1, None])
    assert read(tmp_path, "m.plan", text).home == (46.4, 10.1, None)
    assert read(tmp_path, "m.plan", plan([item], plannedHomePosition=[0, 0, 0])).home is None
    assert read(tmp_path, "m.plan", plan([item])).home is None


def complex_item(kind, **more):
    return {"type": "ComplexItem", "complexItemType": kind, **more}


@pytest.mark.parametrize(
    ("items", "sentence"),
    [
        ([], "its mission has no items."),
        ([3], "item 1 is not an object."),
        (
            [complex_item("StructureScan")],
            "item 1 is a structure scan, which cannot be judged; replace it by waypoints, as an "
            "autopilot gets it: upload the mission, download it and save it.",
        ),
        (
            [complex_item("survey")],
            "item 1 is a survey without stored transects; open and save it with QGroundControl.",
        ),
        (
            [complex_item("CorridorScan", TransectStyleComplexItem={"Items": [1]})],
            "item 1 is a corridor with a bad transect.",
        ),
        (
            [simple(16, [0, 0, 0, 0, 46.5, 10.0])],
            "item 1 must have command, frame and seven params, numbers or null.",
        ),
    ],
)
def test_a_bad_plan_is_refused_by_item(items, sentence, tmp_path):
    assert refused(tmp_path, "m.plan", plan(items)) == sentence


def test_a_plan_without_a_mission_is_refused(tmp_path):
    text = json.dumps({"fileType": "Plan"})
    assert refused(tmp_path, "m.plan", text) == (
        "it is not a .plan file of QGroundControl, version 1."
    )
    assert refused(tmp_path, "m.plan", plan([], version=1)) == (
        "its mission has version 1; save it with a newer QGroundControl."
    )
    newer = json.dumps(json.loads(plan([])) | {"version": 3})
    assert refused(tmp_path, "m.plan", newer) == (
        "it is a .plan of version 3, and only 1 is known; save it with QGroundControl."
    )


# --- Lines ---------------------------------------------------------------------------------------


def kml(lines, more=""):
    marks = "".join(
        f"<Placemark><name>{name}</name><LineString>{mode}<coordinates>{text}</coordinates>"
        "</LineString></Placemark>"
        for name, mode, text in lines
    )
    return f'<kml xmlns="http://www.opengis.net/kml/2.2"><Document>{marks}{more}</Document></kml>'


def mode_of(name):
    return f"<altitudeMode>{name}</altitudeMode>"


def texts(points, blank=""):
    return " ".join(f",{blank}".join(map(repr, point)) for point in points)


@pytest.mark.parametrize(("mode", "frame"), [("absolute", 0), ("relativeToGround", 10)])
def test_the_first_line_of_kml_is_as_fastkml_reads_it(mode, frame, tmp_path):
    text = kml([("a", mode_of(mode), texts(LINE)), ("b", mode_of(mode), texts(LINE))])
    mission = read(tmp_path, "m.kml", text)
    theirs = fastkml.KML.from_string(text).features[0].features[0].geometry
    assert places(mission) == list(theirs.coords) == LINE
    assert {item.frame for item in mission.items} == {frame}
    assert [item.number for item in mission.items] == [1, 2, 3]
    assert [remark.text for remark in mission.remarks] == [
        '1 more line is in the file and not judged: "b".'
    ]


def test_kml_may_have_blanks_after_commas(tmp_path):
    text = kml([("", mode_of("absolute"), texts(LINE, " "))])
    assert places(read(tmp_path, "m.kml", text)) == LINE


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (kml([]), "there is no LineString in it."),
        (
            kml([("a  b", "", texts(LINE))]),
            'the line "a b" has the altitudeMode clampToGround, so it has no heights; set absolute '
            "or relativeToGround.",
        ),
        (
            kml([("a", mode_of("absolute"), "1,2 3,4")]),
            "the line \"a\" has the position '1,2', which must be longitude, latitude and height.",
        ),
        (
            kml([("", mode_of("absolute"), "1,2,3")]),
            "the line must have two points or more.",
        ),
    ],
)
def test_a_bad_line_of_kml_is_refused(text, sentence, tmp_path):
    assert refused(tmp_path, "m.kml", text) == sentence


def test_a_kml_of_our_own_has_the_waypoints_of_its_track(tmp_path):
    text = kml([("Track", mode_of("absolute"), texts(LINE))]).replace(
        "<name>Track</name>", "<name>Track</name><styleUrl>#track</styleUrl>"
    )
    assert places(read(tmp_path, "m.kml", text)) == LINE
    points = "".join(
        f"<Placemark><Point>{mode_of('absolute')}<coordinates>{texts([point])}</coordinates>"
        "</Point></Placemark>"
        for point in LINE[::2]
    )
    folder = f"<Folder><name>Waypoints</name>{points}</Folder></Document>"
    mission = read(tmp_path, "m.kml", text.replace("</Document>", folder))
    assert places(mission) == LINE[::2]
    assert [item.number for item in mission.items] == [0, 1]


def gpx(kind, points):
    inner = "".join(
        f'<{kind[:3]}pt lat="{lat!r}" lon="{lon!r}"><ele>{height!r}</ele></{kind[:3]}pt>'
        for lon, lat, height in points
    )
    around = f"<trkseg>{inner}</trkseg>" if kind == "trk" else inner
    return f"<{kind}>{around}</{kind}>"


def gpx_file(*parts):
    return f'<gpx xmlns="http://www.topografix.com/GPX/1/1" version="1.1">{"".join(parts)}</gpx>'


def test_a_route_of_gpx_comes_before_its_tracks(tmp_path):
    text = gpx_file(gpx("trk", LINE[:2]), gpx("rte", LINE))
    mission = read(tmp_path, "m.gpx", text)
    space = {"g": "http://www.topografix.com/GPX/1/1"}
    theirs = [
        (float(p.get("lon")), float(p.get("lat")), float(p.find("g:ele", space).text))
        for p in ET.fromstring(text).findall("g:rte/g:rtept", space)
    ]
    assert places(mission) == theirs == LINE
    assert mission.kind == "a route of GPX"
    assert [remark.text for remark in mission.remarks] == [
        "1 more route or track is in the file and not judged."
    ]
    assert places(read(tmp_path, "m.gpx", gpx_file(gpx("trk", LINE)))) == LINE


def test_segments_of_a_track_are_joined_with_a_warning(tmp_path):
    inner = gpx("trk", LINE).removeprefix("<trk>").removesuffix("</trk>")
    mission = read(tmp_path, "m.gpx", gpx_file(f"<trk>{inner}{inner}</trk>"))
    assert places(mission) == [*LINE, *LINE]
    (remark,) = mission.remarks
    assert str(remark.grade) == "warning"
    assert remark.text == "the 2 segments of the track are joined by straight legs."


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (gpx_file(), "it has no route and no track."),
        (gpx_file(gpx("trk", LINE[:1])), "its track must have two points or more."),
        (
            gpx_file('<rte><rtept lat="1" lon="2"/><rtept lat="1" lon="2"/></rte>'),
            "point 1 of its route must have lat, lon and a height (ele) in metres.",
        ),
    ],
)
def test_bad_gpx_is_refused(text, sentence, tmp_path):
    assert refused(tmp_path, "m.gpx", text) == sentence


@pytest.mark.parametrize(
    ("header", "frame"),
    [("lon,lat,alt", 0), ("Longitude, Latitude ,Altitude (m)", 0), ("lng,lat,AGL_m", 10)],
)
def test_columns_of_degrees_are_found_by_their_names(header, frame, tmp_path):
    body = "\n".join(",".join(map(repr, point)) for point in LINE)
    mission = read(tmp_path, "m.csv", f"\ufeff{header}\n{body}\n\n")
    assert np.array(places(mission)) == pytest.approx(np.array(LINE))
    assert {item.frame for item in mission.items} == {frame}


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "lat,lon,alt_ft\n1,2,3\n",
            "its columns are lat, lon, alt_ft; give one of heights in metres, named alt (above "
            "mean sea level) or agl (above the ground).",
        ),
        ("lat,lon,alt\n1,2,3\n", "a line needs two rows or more."),
        (
            "lat,lon,alt\n1,2,3\n1,2\n",
            "line 3 must have numbers for latitude, longitude and height, not '1,2'.",
        ),
        (
            "lat,lon,alt\n1,2,3\n46,02,7,05,250\n",
            "line 3 has 5 cells, and the header has 3; write numbers with decimal points.",
        ),
        ("lat,latitude,lon,alt\n", "its columns lat and latitude mean the same; keep one."),
        (
            "lat;lon;alt\n46,02;7,05;250\n",
            "its cells must be separated by commas, with decimal points in numbers.",
        ),
    ],
)
def test_bad_columns_of_degrees_are_refused(text, sentence, tmp_path):
    assert refused(tmp_path, "m.csv", text) == sentence


@pytest.mark.parametrize("suffix", [".plan", ".waypoints", ".kml", ".gpx"])
@pytest.mark.parametrize("text", ["", "<kml><Document>", '{"fileType": "Plan"'])
def test_a_part_of_a_mission_is_not_taken_for_a_path(suffix, text, tmp_path):
    assert refused(tmp_path, f"m{suffix}", text) == (
        f"this is not the content of a {suffix} file, or a part of it is missing; save it again."
    )


@pytest.mark.parametrize(
    ("name", "text"),
    [("p.csv", "x,y,z\n1,2,3\n4,5,6\n"), ("p.geojson", "{}"), ("p.json", '{"waypoints": []}')],
)
def test_paths_of_our_own_are_no_missions(name, text, tmp_path):
    assert read(tmp_path, name, text) is None

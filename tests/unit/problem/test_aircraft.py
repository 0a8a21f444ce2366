"""Aircraft of the package and of users' files."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest

from pathgene.host.errors import InputError
from pathgene.host.evaluation import Evaluator
from pathgene.host.evaluation.fuel import fuel_burned
from pathgene.host.problem.aircraft import PARAMETERS, Aircraft, load, names, parse
from pathgene.host.problem.limits import Limits, steady_thrust
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.rules import Rules
from pathgene.host.terrain import Terrain


FOX = load("silver-fox")
TOML = """
name = "Mine"
weight_N = 100
wing_span_m = 2.0
wing_area_m2 = 0.5
zero_lift_drag_coefficient = 0.03
specific_fuel_consumption_N_per_Ws = 1e-6
propeller_efficiency = 0.7
cruise_speed_m_s = 20
turn_radius_m = 100
max_climb_deg = 8
max_descent_deg = 20
"""


def test_sources_may_name_more_than_the_parameters():
    aircraft = parse(TOML + "[sources]\nspan = 'measured'\nnote = 'of 2024'", "mine.toml")
    assert aircraft.sources == {"span": "measured", "note": "of 2024"}
    assert "note" not in aircraft.to_dict()


def test_the_page_documents_every_key():
    """There is one row per key, with its default or the word "required"."""
    defaults = {field.name: field.default for field in dataclasses.fields(Aircraft)}
    page = (Path(__file__).parents[3] / "docs" / "rules.md").read_text()
    page = page.partition("\n## Aircraft\n")[2].partition("\n## ")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*)\|$", page, flags=re.MULTILINE))
    assert list(rows) == ["name", *PARAMETERS]
    for key, row in rows.items():
        default = defaults[key]
        stated = row.split("|")[1].strip()
        if default is dataclasses.MISSING:
            assert stated == "required", key
        else:
            assert stated == ("none" if default is None else f"{default:g}"), key


def test_the_pages_example_is_an_aircraft():
    page = (Path(__file__).parents[3] / "docs" / "rules.md").read_text()
    (example,) = re.findall(r"```toml\n(.*?)```", page, flags=re.DOTALL)
    assert parse(example, "docs/rules.md").name == "My glider"


def test_silver_fox_has_the_papers_values():
    assert load("silver-fox").to_dict() == {
        "name": "Silver Fox-like",
        "weight_N": 113.0,
        "fuel_weight_N": 19.0,
        "wing_span_m": 2.4,
        "wing_area_m2": 0.768,
        "lift_coefficient_max": 1.26,
        "zero_lift_drag_coefficient": 0.0251,
        "oswald_efficiency": 0.8,
        "engine_power_W": 1850.0,
        "specific_fuel_consumption_N_per_Ws": 1.1569e-6,
        "propeller_efficiency": 0.8,
        "cruise_speed_m_s": 23.0,
        "turn_radius_m": 150.0,
        "max_climb_deg": 10.0,
        "max_descent_deg": 30.0,
        "height_lag_s": 3.0,
    }


@pytest.mark.parametrize(
    ("name", "max_speed", "size"),
    [("sperwer", 70.0, 4.2), ("heron", 62.0, 16.2), ("predator", 62.0, 14.8)],
)
def test_male_aircraft_have_the_papers_speed_and_size(name, max_speed, size):
    aircraft = load(name)
    assert (aircraft.max_speed_m_s, aircraft.size_m, aircraft.wing_span_m) == (
        max_speed,
        size,
        size,
    )


def test_names():
    assert names() == ["c172p", "heron", "j3cub", "predator", "silver-fox", "sperwer"]


@pytest.mark.parametrize("name", names())
def test_every_value_of_the_package_has_a_source(name):
    aircraft = load(name)
    given = {parameter for parameter in PARAMETERS if getattr(aircraft, parameter) is not None}
    assert set(aircraft.sources) == given
    for source in aircraft.sources.values():
        assert source.startswith(
            (
                "assumed",
                "chosen",
                "fitted",
                "the model",
                "Roberge and Tarbouchi, table",
                "Allaire et al., two-tier feasibility, table",
            )
        )


@pytest.mark.parametrize("name", names())
def test_aircraft_of_the_package_can_fly_their_values(name):
    # A lift coefficient below 1.3 and enough power to climb, both at cruise speed.
    aircraft = load(name)
    pressure_area = 0.5 * 1.225 * aircraft.cruise_speed_m_s**2 * aircraft.wing_area_m2
    assert aircraft.weight_N / pressure_area < 1.3
    drag = (
        pressure_area * aircraft.zero_lift_drag_coefficient
        + aircraft.induced_drag_factor * aircraft.weight_N**2 / pressure_area
    )
    climb = aircraft.weight_N * math.sin(math.radians(aircraft.max_climb_deg))
    power = (drag + climb) * aircraft.cruise_speed_m_s / aircraft.propeller_efficiency
    assert power < aircraft.engine_power_W


def test_polar():
    assert FOX.aspect_ratio == pytest.approx(7.5)
    assert FOX.induced_drag_factor == pytest.approx(1 / (math.pi * 0.8 * 7.5))


def test_loads_a_file(tmp_path):
    file = tmp_path / "mine.toml"
    file.write_text(TOML, encoding="utf-8")
    aircraft = load(file)
    assert aircraft == load(str(file))
    assert (aircraft.name, aircraft.weight_N, aircraft.oswald_efficiency) == ("Mine", 100.0, 0.8)
    assert aircraft.fuel_weight_N is None
    assert "fuel_weight_N" not in aircraft.to_dict()


def test_an_equivalent_airspeed_is_converted_once_at_the_mean_altitude():
    """The bank and the drag of the cruise are kept; the stall compares equivalent airspeeds."""
    file = TOML.replace("cruise_speed_m_s", "lift_coefficient_max = 0.8\nequivalent_speed_m_s")
    mine = parse(file + "max_speed_m_s = 24", "mine.toml")
    terrain = Terrain("flat", np.full((41, 41), 2000.0), 50.0, 50.0)
    ends = (400.0, 1000.0, 2600.0), (1600.0, 1000.0, 3400.0)
    problem = Problem(terrain, *ends, mine, rules=Rules(corridor_m=0))
    high = problem.aircraft
    assert high == mine.at(3000.0)
    assert high.cruise_speed_m_s == pytest.approx(20 * 1.1607, rel=1e-4)
    assert high.max_speed_m_s == pytest.approx(24 * 1.1607, rel=1e-4)
    assert high.turn_radius_m == pytest.approx(100 * 1.1607**2, rel=1e-3)
    assert Aircraft.from_dict(high.to_dict(), "summary").at(0.0) == high
    assert steady_thrust(high, 0.1, 100.0) == steady_thrust(mine, 0.1, 100.0)
    stall = problem.limits.stall_speed_m_s
    assert stall == pytest.approx(Limits.of(mine, (0.0, 0.0), Rules()).stall_speed_m_s)
    assert high.equivalent_speed_m_s < stall < high.cruise_speed_m_s
    assert not math.isfinite(problem.limits.turn_radius_m)
    burned = Evaluator(problem).evaluate(np.array(ends)).fuel_N
    run_m, rise_m = 1200.0, 800.0
    length_m = math.hypot(run_m, rise_m)
    assert burned == pytest.approx(fuel_burned(high, 100.0, run_m, rise_m, length_m))
    assert burned == pytest.approx(fuel_burned(mine, 100.0, run_m, rise_m, length_m))
    assert load("silver-fox").at(3000.0) == load("silver-fox")


@pytest.mark.parametrize("name", names())
def test_dictionary_round_trip(name):
    assert Aircraft.from_dict(load(name).to_dict(), "summary") == load(name)


@pytest.mark.parametrize(
    ("toml", "message"),
    [
        ("a = ", r"^mine\.toml: not valid TOML: .+\.$"),
        (
            "a = " + "[" * 3000 + "]" * 3000,
            r"^mine\.toml: not valid TOML: tables or arrays are nested too deeply\.$",
        ),
        (
            TOML + "speed = 3",
            (
                r"^mine\.toml: unknown UAV parameter 'speed'; known are "
                r"cruise_speed_m_s, .*\.$"
            ),
        ),
        (
            TOML.replace("weight_N = 100", ""),
            (
                r"^mine\.toml: UAV parameter 'weight_N' is missing; add "
                r"it to the file\.$"
            ),
        ),
        (
            TOML + "[sources]\nwing_span_m = 2",
            r"^mine\.toml: \[sources\] must map names to texts\.$",
        ),
        (
            TOML.replace("100\nwing", "'x'\nwing"),
            (
                r"^UAV 'Mine': weight_N must be a positive number, "
                r"not 'x'\.$"
            ),
        ),
        *(
            (
                TOML.replace("weight_N = 100", f"weight_N = {value}"),
                rf"^UAV 'Mine': weight_N must be from 1e-12 to 1e\+12, not {shown}\.$",
            )
            for value, shown in (("1e-320", "9.99989e-321"), ("1e13", r"1e\+13"))
        ),
        (TOML.replace('"Mine"', '" "'), r"^UAV name must be a non-empty text, not ' '\.$"),
    ],
)
def test_refuses_bad_files(toml, message):
    with pytest.raises(InputError, match=message):
        parse(toml, "mine.toml")


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weight_N": 0.0}, r"weight_N must be a positive number, not 0\.0\.$"),
        ({"turn_radius_m": -1}, r"turn_radius_m must be a positive number, not -1\.$"),
        ({"wing_span_m": math.nan}, r"wing_span_m must be a positive number, not nan\.$"),
        ({"wing_area_m2": math.inf}, r"wing_area_m2 must be a positive number, not inf\.$"),
        ({"cruise_speed_m_s": True}, r"cruise_speed_m_s must be a positive number, not True\.$"),
        ({"cruise_speed_m_s": None}, r"cruise_speed_m_s must be a positive number, not None\.$"),
        ({"max_climb_deg": 90.1}, r"max_climb_deg must be at most 90, not 90\.1\.$"),
        ({"max_descent_deg": 91}, r"max_descent_deg must be at most 90, not 91\.$"),
        ({"oswald_efficiency": 1.01}, r"oswald_efficiency must be at most 1, not 1\.01\.$"),
        ({"propeller_efficiency": 2}, r"propeller_efficiency must be at most 1, not 2\.$"),
        (
            {"fuel_weight_N": 113},
            (
                r"fuel_weight_N must be below weight_N, which includes the fuel, "
                r"not 113\.$"
            ),
        ),
        ({"max_speed_m_s": 22}, r"max_speed_m_s must not be below cruise_speed_m_s, not 22\.$"),
    ],
)
def test_refuses_bad_values(changes, message):
    with pytest.raises(InputError, match=r"^UAV 'Silver Fox-like': " + message):
        dataclasses.replace(FOX, **changes)


def test_refuses_an_unknown_name():
    with pytest.raises(
        InputError,
        match=r"^There is no UAV 'fox'; give one of c172p, heron, j3cub, predator, "
        r"silver-fox, sperwer, or a \.toml file\.$",
    ):
        load("fox")


def test_refuses_missing_and_unreadable_files(tmp_path):
    with pytest.raises(
        InputError,
        match=r"^Cannot read UAV file '.*no\.toml': No such file or "
        r"directory\.$",
    ):
        load(tmp_path / "no.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"bytes\.toml: not a TOML file, it is not UTF-8 text\.$"):
        load(tmp_path / "bytes.toml")


def test_class_loads_and_lists_aircraft():
    assert Aircraft.load("silver-fox") == FOX
    assert Aircraft.names() == names() == sorted(names())

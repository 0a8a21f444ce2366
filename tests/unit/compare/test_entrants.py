"""Planners with options, as users write them."""

import pytest

from pathgene.host.compare.entrants import parse_entrants, planner_names, split_label
from pathgene.host.errors import InputError
from pathgene.host.planners import PLANNERS


def test_defaults_are_the_planners(entrants):
    for entrant in parse_entrants(",".join(PLANNERS), {}, {}):
        assert entrant.label == entrant.planner
        assert entrant.options.generations == PLANNERS[entrant.planner].generations
        assert not entrant.own


def test_common_options_go_to_planners_that_have_them():
    fpga, pc = parse_entrants(
        "ga-fpga, ga-pc",
        {"generations": 7, "population": None},
        {"max_waypoints": 9, "link_mode": "recipe"},
    )
    assert (fpga.own, pc.own) == ({"link_mode": "recipe"}, {"max_waypoints": 9})
    assert fpga.options.generations == pc.options.generations == 7
    assert fpga.options.population is None


def test_own_options_override_common_ones():
    one, other = parse_entrants(
        "ga-pc,ga-pc:max-waypoints=8:generations=5:population=10:time_limit=2.5:target-fitness=1.4",
        {"generations": 7},
        {"max_waypoints": 9},
    )
    assert one.own == {"max_waypoints": 9}
    assert other.own == {"max_waypoints": 8}
    assert other.make().max_waypoints == 8
    options = other.options
    assert (
        options.generations,
        options.population,
        options.time_limit_s,
        options.target_fitness,
    ) == (5, 10, 2.5, 1.4)
    assert other.label.startswith("ga-pc:max-waypoints=8:")


def test_urls_keep_their_colons():
    (entrant,) = parse_entrants("ga-fpga:board=sim:?sim=icarus&lanes=2:link_mode=recipe", {}, {})
    assert entrant.own == {"board": "sim:?sim=icarus&lanes=2", "link_mode": "recipe"}
    assert split_label("ga-fpga:board=socket://host:5000:generations=2") == [
        "ga-fpga",
        "board=socket://host:5000",
        "generations=2",
    ]


def test_names_of_planners():
    assert planner_names("ga-pc:max_waypoints=8, a-star,ga-pc") == ["ga-pc", "a-star", "ga-pc"]


@pytest.mark.parametrize(
    ("board", "hardware"),
    [
        (None, False),
        ("model:", False),
        ("sim:?sim=icarus", False),
        ("/dev/ttyUSB0", True),
        ("socket://somewhere:5000", True),
    ],
)
def test_boards_on_a_line_are_hardware(board, hardware):
    (entrant,) = parse_entrants("ga-fpga", {}, {} if board is None else {"board": board})
    assert entrant.has_hardware == hardware


def test_key_has_exactly_what_runs_depend_on():
    def key(text, **search):
        return parse_entrants(text, search, {})[0].key

    assert key("ga-pc:max_waypoints=8") == key("ga-pc:max-waypoints=8")
    assert key("ga-pc", generations=9) == key("ga-pc:generations=9")
    keys = {
        key("ga-pc"),
        key("ga-fpga"),
        key("ga-pc:generations=9"),
        key("ga-pc:population=9"),
        key("ga-pc:time_limit=9"),
        key("ga-pc:target_fitness=9"),
        key("ga-pc:max_waypoints=9"),
    }
    assert len(keys) == 7


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "a-star",
            "There is no planner 'a-star' (did you mean astar?); the planners are "
            f"{', '.join(PLANNERS)}.",
        ),
        ("ga-pc,", f"There is no planner ''; the planners are {', '.join(PLANNERS)}."),
        ("ga-pc:wings=2", "ga-pc:wings=2: ga-pc has no option 'wings'; it has generations, "),
        ("ga-pc:board=sim:", "ga-pc:board=sim:: ga-pc has no option 'board'; it has generations, "),
        (
            "ga-pc:max_waypoints=few",
            "ga-pc:max_waypoints=few: max_waypoints must be a whole number, not 'few'.",
        ),
        (
            "ga-pc:time_limit=long",
            "ga-pc:time_limit=long: time_limit must be a number, not 'long'.",
        ),
        (
            "ga-pc:max_waypoints=2",
            "ga-pc:max_waypoints=2: The most waypoints of a path must be from 3 to 1000, not 2.",
        ),
        (
            "ga-pc:generations=0",
            "ga-pc:generations=0: The number of generations must be 1 or more, not 0.",
        ),
        (
            "ga-fpga:link_mode=slow",
            "ga-fpga:link_mode=slow: link_mode must be one of rank, population, recipe, not "
            "'slow'.",
        ),
        (
            "ga-pc:population=8:population=9",
            "ga-pc:population=8:population=9: population is given twice; leave one out.",
        ),
        ("ga-pc,ga-fpga,ga-pc", "ga-pc and ga-pc are the same planner with the same options; "),
        (
            "ga-pc,ga-pc:generations=300",
            "ga-pc and ga-pc:generations=300 are the same planner with ",
        ),
    ],
)
def test_refuses_bad_entrants(text, sentence):
    with pytest.raises(InputError) as caught:
        parse_entrants(text, {}, {})
    assert str(caught.value).startswith(sentence)

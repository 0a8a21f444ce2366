"""Names of earlier releases: each is read as its successor, and a note says so once."""

import warnings
from pathlib import Path

import pytest

from pathgene.hdl.config import GeneticCore
from pathgene.host.compare.entrants import parse_entrants
from pathgene.host.device.boards import entered, known_config, open_board, with_core
from pathgene.host.errors import InputError
from pathgene.host.old_words import current_engine, current_setting, current_top, current_url
from pathgene.host.options.arguments import own_options
from pathgene.host.options.table import keys_of


def note(old, new):
    return rf"^The old name '{old}' still works; write '{new}'\.$"


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("genetic=streaming", "core=planner"),
        ("genetic=parallel", "core=paper"),
        ("genetic=1", "core=paper"),
        ("genetic=none", "core=none"),
        ("genetic=0", "core=none"),
    ],
)
def test_cores(old, new):
    for place in ("model:?{}", "sim:?{}&sim=icarus", "model:?lanes=4&{}"):
        with pytest.warns(UserWarning, match=note(old, new)):
            assert current_url(place.format(old)) == place.format(new)
    with pytest.warns(UserWarning, match=note(old, new)):
        assert current_setting(*old.split("=")) == tuple(new.split("="))
    with pytest.warns(UserWarning, match=note(old, new)):
        assert known_config(f"model:?{old}") == known_config(f"model:?{new}")


def test_engines_and_tops():
    with pytest.warns(UserWarning, match=note("cores", "threads")):
        assert current_engine("cores") == "threads"
    with pytest.warns(UserWarning, match=note("planner", "chip")):
        assert current_top("planner") == "chip"


def test_names_of_today_cause_no_note():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        url = "sim:?core=paper&checker=parallel&genetics=1"
        assert current_url(url) == url
        assert current_url("/dev/ttyUSB0") == "/dev/ttyUSB0"
        assert current_setting("checker", "parallel") == ("checker", "parallel")
        assert [current_engine(name) for name in ("threads", "gpu")] == ["threads", "gpu"]
        assert current_top("planner_core") == "planner_core"


def test_a_value_that_never_was_is_refused():
    with pytest.raises(InputError, match=r"^The model takes only port and fields of the "):
        open_board("model:?genetic=2").close()


def test_an_open_board_bears_the_name_of_today():
    with pytest.warns(UserWarning, match=note("genetic=parallel", "core=paper")):
        board = open_board("model:?genetic=parallel")
    with board:
        assert board.url == "model:?core=paper"
        # Its URL names a core, so a planner that needs the second core does not get a second chip.
        with entered(board, core=GeneticCore.PLANNER) as same:
            assert same is board
    with pytest.warns(UserWarning, match=note("genetic=0", "core=none")):
        assert with_core("model:?genetic=0", "planner") == "model:?core=none"


def test_an_engine_of_the_api_and_of_a_comparison():
    with pytest.warns(UserWarning, match=note("cores", "threads")):
        assert own_options("fpa", {"engine": "cores"}) == {"engine": "threads"}
    with pytest.warns(UserWarning, match=note("cores", "threads")):
        (entrant,) = parse_entrants("fpa:engine=cores", {}, {})
    assert entrant.own == {"engine": "threads"}


def test_an_engine_in_a_problem_file():
    kind = keys_of("planner")["engine"].kind
    with pytest.warns(UserWarning, match=note("cores", "threads")):
        assert kind.read("cores", Path()) == "threads"

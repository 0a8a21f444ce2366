"""The boards that a page, a link or a file in a browser may name."""

import base64
import zlib

import pytest

from pathgene.host.errors import InputError
from pathgene.host.web.desk.boards import require_board
from pathgene.host.web.desk.desk import Desk
from pathgene.host.web.desk.sheet import Sheet
from pathgene.host.web.desk.terrains import Terrains


OWN = "sim:?trace=wave.vcd"

REFUSED = [
    "sim:?trace=/elsewhere/user/thesis.tex",
    "sim:?max_waypoints=8&sim=icarus&trace=x",
    "sim:?tr%61ce=x",
    "sim:?trace",
    "sim:?trace=",
    "sim:?unknown=1",
    "sim:x",
    "model:?trace=x",
    "model:x",
    "SIM:?trace=x",
    " sim:",
    "",
    "/dev/ttyUSB0",
    "COM3",
    "socket://192.168.0.1:22",
    "rfc2217://localhost:4000",
    "spy:///dev/null?file=/elsewhere/user/thesis.tex",
    "alt:///dev/ttyUSB0?class=PosixPollSerial",
    "probe:1",
]
ALLOWED = [
    "model:",
    "model:?max_waypoints=8",
    "sim:",
    "sim:?sim=icarus",
    "sim:?max_waypoints=8&clocks_per_bit=8&idle_clocks=10&patience=60",
]


@pytest.fixture
def desk(tmp_path):
    desk = Desk(tmp_path / "out")
    yield desk
    desk.close()


def link_of(text):
    return base64.urlsafe_b64encode(zlib.compress(text.encode())).decode().rstrip("=")


def problem(board):
    """Return the text of a problem file with a board."""
    ends = "start = [3000, 3000, 100]\ngoal = [20000, 20000, 100]\nagl = true\n"
    return f"[mission]\n{ends}[planner]\nboard = '{board}'\n"


@pytest.mark.parametrize("url", ALLOWED)
def test_simulated_boards_are_allowed(url, tmp_path):
    require_board(url, None)
    sheet = Sheet(Terrains(tmp_path))
    sheet.open_link(link_of(problem(url)))
    assert sheet.values["board"] == url
    sheet.mission()
    assert sheet.task()["board"] == url


@pytest.mark.parametrize("url", REFUSED)
def test_other_boards_are_refused_in_links_and_files(url, tmp_path):
    sheet = Sheet(Terrains(tmp_path))
    before = sheet.text()
    for act, given in (
        (sheet.open_link, link_of(problem(url))),
        (sheet.open_text, problem(url)),
    ):
        with pytest.raises(InputError, match=r"^The board of a page "):
            act(given)
    assert sheet.text() == before


def test_other_boards_neither_plan_nor_fly(desk, tmp_path):
    for url in REFUSED:
        sheet = desk.sheet()
        sheet.set("board", url)
        for act in (sheet.mission, sheet.task, lambda sheet=sheet: desk.plan(sheet)):
            with pytest.raises(InputError, match=r"^The board of a page "):
                act()
        with pytest.raises(InputError, match=r"^The board of a page "):
            desk.fly(tmp_path, sheet)
    assert desk.jobs.active == []


def test_the_sentences_say_what_to_do():
    with pytest.raises(InputError) as caught:
        require_board("/dev/ttyUSB0", None)
    assert str(caught.value) == (
        "The board of a page is model: or sim: with options, not '/dev/ttyUSB0'; start the desk "
        "with a problem file that names another board."
    )
    with pytest.raises(InputError) as caught:
        require_board("sim:?trace=x", None)
    assert str(caught.value) == (
        "The board of a page takes no option 'trace' ('sim:?trace=x'); start the desk with a "
        "problem file that names this board."
    )
    with pytest.raises(InputError, match="max_waypoints"):
        require_board("sim:?max_waypoints=many", None)


def test_the_board_of_the_users_own_problem_file_is_allowed_as_it_is(tmp_path):
    (tmp_path / "problem.toml").write_text(problem(OWN))
    desk = Desk(tmp_path / "out", problem=tmp_path / "problem.toml")
    try:
        sheet = desk.sheet()
        sheet.mission()
        assert sheet.task()["board"] == OWN
        sheet.open_link(link_of(problem(OWN)))
        with pytest.raises(InputError, match=r"^The board of a page "):
            sheet.open_link(link_of(problem(OWN + "2")))
    finally:
        desk.close()


def test_a_saved_plan_of_another_board_opens_without_it(desk):
    sheet = desk.sheet()
    sentence = sheet.open_saved(problem("/dev/ttyUSB0") + "[rules]\nclearance = 40\n")
    assert sentence.startswith("The board of the plan is left out. The board of a page is ")
    assert "board" not in sheet.values
    assert sheet.values["clearance"] == 40
    assert sheet.open_saved(problem("model:")) is None
    assert sheet.values["board"] == "model:"

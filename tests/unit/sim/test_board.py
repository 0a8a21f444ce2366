from pathlib import Path
from unittest.mock import Mock

import pytest

from pathgene.host.errors import InputError
from pathgene.sim.board import BoardOptions, Program, parse_board_url, scheme


@pytest.mark.parametrize(
    ("url", "options"),
    [
        ("sim:", BoardOptions()),
        ("sim:?", BoardOptions()),
        ("sim:?sim=icarus", BoardOptions(sim="icarus")),
        (
            "sim:?sim=verilator&clocks_per_bit=868&idle_clocks=0&trace=a%20b.vcd",
            BoardOptions("verilator", 868, 0, Path("a b.vcd")),
        ),
        ("sim:?sim=icarus&patience=0.5", BoardOptions(sim="icarus", patience=0.5)),
    ],
)
def test_url(url, options):
    assert parse_board_url(url) == options


@pytest.mark.parametrize(
    ("url", "sentence"),
    [
        (
            "model:",
            "A simulated board is given as sim: or sim:?sim=icarus, not 'model:'.",
        ),
        ("sim", "A simulated board is given as sim: or sim:?sim=icarus, not 'sim'."),
        (
            "sim://x",
            "A simulated board is given as sim: or sim:?sim=icarus, not 'sim://x'.",
        ),
        (
            "sim:?speed=9",
            "The simulated board has no option 'speed'; choose from sim, clocks_per_bit, "
            "idle_clocks, trace, patience.",
        ),
        (
            "sim:?sim=icarus&sim=icarus",
            "Each option of the simulated board may be given once only, in "
            "'sim:?sim=icarus&sim=icarus'.",
        ),
        (
            "sim:?sim=vcs",
            "Option sim of the simulated board must be verilator or icarus, not 'vcs'.",
        ),
        (
            "sim:?clocks_per_bit=3",
            "Option clocks_per_bit of the simulated board must be an integer from 4 to 65535, "
            "not '3'.",
        ),
        (
            "sim:?clocks_per_bit=",
            "Option clocks_per_bit of the simulated board must be an integer from 4 to 65535, "
            "not ''.",
        ),
        (
            "sim:?idle_clocks=-1",
            "Option idle_clocks of the simulated board must be an integer from 0 to "
            "9223372036854775808, not '-1'.",
        ),
        *(
            (
                f"sim:?patience={text}",
                "Option patience of the simulated board must be a number of seconds above 0, at "
                f"most 86,400, not {text!r}.",
            )
            for text in ("0", "-1", "nan", "86401", "long", "")
        ),
        ("sim:?trace=", "Option trace of the simulated board must be a file name, not ''."),
    ],
)
def test_refuses_bad_urls(url, sentence):
    with pytest.raises(InputError) as caught:
        parse_board_url(url)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    ("url", "patience_s"),
    [
        ("sim:", 15),
        ("sim:?sim=icarus", 360),
        ("sim:?patience=60&lanes=4", 60),
        ("sim:?sim=icarus&patience=0.6", 0.6),
    ],
)
def test_the_patience_of_a_simulated_board(monkeypatch, url, patience_s):
    monkeypatch.setattr(scheme, "start_simulated", lambda url: Mock())
    opened = scheme.SCHEME.open(url)
    assert opened.timeout_s * opened.attempts == pytest.approx(patience_s)


def test_command_of_verilator():
    program = Program("verilator", Path("/b/program"), 4, traced=True)
    assert program.command() == [
        "/b/program", "--clocks-per-bit", "4", "--listen", "127.0.0.1:0",
    ]  # fmt: skip
    assert program.command(pty=True, keep=True, idle_clocks=9, trace=Path("t.vcd")) == [
        "/b/program", "--clocks-per-bit", "4", "--pty", "--keep", "--idle-clocks", "9",
        "--trace", "t.vcd",
    ]  # fmt: skip


def test_command_without_waveform():
    with pytest.raises(InputError, match=r"^This simulator was built without waveforms; "):
        Program("verilator", Path("/b/program"), 4).command(trace=Path("t.vcd"))

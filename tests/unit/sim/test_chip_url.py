"""The chip that a URL describes: fields of the configuration, and the port of the line."""

import pytest

from pathgene.host.errors import InputError
from pathgene.sim import DEFAULT_CONFIG
from pathgene.sim.chip_url import chip_of


@pytest.mark.parametrize(
    ("query", "divisor"),
    [
        ("", 4),
        ("core=planner", 0),
        ("core=planner&port=uart", 4),
        ("core=planner&clocks_per_bit=8", 8),
        ("core=planner&port=uart&clocks_per_bit=8", 8),
        ("port=bytes", 0),
        ("clocks_per_bit=0", 0),
        ("port=bytes&clocks_per_bit=0", 0),
    ],
)
def test_the_planner_core_has_a_byte_wide_port_by_default(query, divisor):
    rest, config = chip_of(f"sim:?{query}")
    core = "planner" if "core" in query else "paper"
    assert (rest, config) == ("sim:", DEFAULT_CONFIG.replace(core=core, clocks_per_bit=divisor))


def test_other_options_stay():
    rest, config = chip_of("sim:?sim=icarus&port=bytes&trace=a%20b&lanes=4")
    assert rest == "sim:?sim=icarus&trace=a+b"
    assert (config.lanes, config.has_uart) == (4, False)


def test_a_byte_takes_a_cycle_or_the_bits_of_a_uart():
    assert chip_of("model:?port=bytes")[1].byte_cycles == 1
    assert chip_of("model:?clocks_per_bit=33")[1].byte_cycles == 330


@pytest.mark.parametrize(
    ("query", "sentence"),
    [
        (
            "port=usb",
            "Option port of a simulated chip must be bytes or uart, given once, not 'usb'.",
        ),
        (
            "port=uart&port=bytes",
            "Option port of a simulated chip must be bytes or uart, given once, not 'uart' and "
            "'bytes'.",
        ),
        (
            "port=bytes&clocks_per_bit=8",
            "port=bytes contradicts clocks_per_bit=8; leave one of them out.",
        ),
        (
            "port=uart&clocks_per_bit=0",
            "port=uart contradicts clocks_per_bit=0; leave one of them out.",
        ),
    ],
)
def test_refuses_contradictions(query, sentence):
    with pytest.raises(InputError) as caught:
        chip_of(f"sim:?{query}")
    assert str(caught.value) == sentence

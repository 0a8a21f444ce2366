"""The identity of a board, from its reply to INFO."""

import re

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.messages import info_reply, info_values
from pathgene.host.device.identity import built_config, request_info
from pathgene.host.device.link import Link
from pathgene.host.errors import InputError
from pathgene.sim.model.chip import Chip
from tests.support.gateware.chips import SMALL
from tests.support.gateware.faults import FaultyTransport, VirtualClock


INFO = info_values(SMALL) | {"session": 0}


def test_tells_the_configuration_of_a_board():
    link = Link(FaultyTransport(Chip(SMALL).feed, clock := VirtualClock()), clock=clock)
    info = request_info(link)
    assert info == INFO
    assert built_config(info) == SMALL


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"core": 9}, "Core must be below 3, not 9"),
        ({"checker": 3}, "Checker must be below 3, not 3"),
        ({"lanes": 3}, "Config.lanes must be 1, 2, 4, 8 or 16, not 3"),
    ],
)
def test_refuses_a_build_of_another_release(changes, reason):
    sentence = (
        f"This release does not know the build of the board ({reason}): load a bitstream of this "
        "release."
    )
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        built_config(INFO | changes)


def test_refuses_a_build_whose_sizes_do_not_make_its_number():
    sentence = (
        f"The board was built as 00000001, but the sizes that it reports make "
        f"{SMALL.build_id:08x} here: load a bitstream of this release."
    )
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        built_config(INFO | {"build_id": 1})


def test_info_has_one_layout_for_every_chip():
    assert info_reply(SMALL) == info_reply(Config()) == info_reply(Config(core="planner"))

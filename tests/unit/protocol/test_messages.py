"""Messages: layouts, paths on the link, and the configuration in INFO."""

import random
import zlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import CheckerBuild, Config, SurvivorSelection
from pathgene.hdl.protocol import codec, messages
from pathgene.hdl.protocol.codes import LinkMode
from pathgene.hdl.protocol.layout import Field, Layout
from pathgene.hdl.protocol.paths import (
    PathResult,
    pack_cells,
    pack_paths,
    pack_results,
    unpack_cells,
    unpack_paths,
    unpack_results,
)


CONFIG = Config()
CONFIGS = [
    CONFIG,
    Config(max_waypoints=20, survivor_selection=SurvivorSelection.RANK),
    Config(population=8, children=4, survivors=2, inserts=1, deletes=1, max_waypoints=5),
    *(
        Config(checker=build, lanes=1, memory_latency=1, redraws=3)
        for build in CheckerBuild
        if build is not CheckerBuild.NONE
    ),
    Config(core="planner", point_cycles=2),
]


def test_the_base_of_a_numbered_field_is_its_name():
    names = ("slot_0", "slot_12", "seed", "x_axis")
    assert [Field(name, 1, "", "").base for name in names] == ["slot", "slot", "seed", "x_axis"]


def test_layout_packs_from_the_lowest_bit():
    layout = Layout((("first", 3), ("second", 9), ("third", 1)))
    assert (layout.bits, layout.size) == (13, 2)
    assert layout.pack(first=5, second=0x101, third=1) == bytes([0b00001_101, 0b000_1_1000])
    assert layout.unpack(bytes([0x0D, 0x18])) == {"first": 5, "second": 0x101, "third": 1}


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"a": 1}, r"^Fields must be \['a', 'b'\], not \['a'\]$"),
        ({"a": 1, "b": 1, "c": 1}, r"^Fields must be \['a', 'b'\], not \['a', 'b', 'c'\]$"),
        ({"a": 8, "b": 1}, r"^a must fit in 3 bits, not 8$"),
        ({"a": -1, "b": 1}, r"^a must fit in 3 bits, not -1$"),
    ],
)
def test_layout_refuses_bad_values(values, sentence):
    with pytest.raises(ValueError, match=sentence):
        Layout((("a", 3), ("b", 8))).pack(**values)


def test_layout_refuses_a_wrong_size():
    with pytest.raises(ValueError, match=r"^Payload must have 2 bytes, not 3$"):
        Layout((("a", 9),)).unpack(b"abc")


@pytest.mark.parametrize("config", CONFIGS)
def test_the_head_of_info_never_moves(config):
    """A host of any version reads the version; the session follows the build."""
    expected = (("version", 8), ("build_id", 32), ("session", 8))
    assert messages.info_reply(config).fields[:3] == expected
    assert messages.info_reply(config).size == sum(
        bits // 8 for _, bits in messages.info_reply(config).fields
    )


@pytest.mark.parametrize("config", CONFIGS)
def test_every_layout_returns_what_it_packed(config):
    rng = random.Random(1)
    layouts = [
        messages.start_request(config),
        messages.write_request(config),
        messages.read_request(config),
        *(messages.generate_request(config, mode) for mode in LinkMode),
        messages.info_reply(config),
        messages.status_reply(config),
        messages.counters_reply(config),
        messages.survivors_reply(config),
        messages.recipe_reply(config),
        messages.map_request(config),
        messages.check_request(config),
        messages.check_paths_request(config),
        messages.results_request(config),
        messages.check_reply(config),
        messages.path_record(config),
        messages.hit_record(config),
        messages.entry_record(config),
    ]
    for layout in layouts:
        values = {name: rng.getrandbits(width) for name, width in layout.fields}
        assert layout.unpack(layout.pack(**values)) == values


@pytest.mark.parametrize("config", CONFIGS)
def test_info_has_the_configuration(config):
    values = messages.info_values(config) | {"session": 7}
    layout = messages.info_reply(config)
    told = layout.unpack(layout.pack(**values))
    assert messages.config_from_info(told) == config
    assert (told["version"], told["build_id"]) == (codec.VERSION, config.build_id)


def test_refuses_an_unknown_checker():
    values = messages.info_values(CONFIG) | {"session": 7, "checker": 3}
    with pytest.raises(ValueError, match=r"^Checker must be below 3, not 3$"):
        messages.config_from_info(values)


def test_checkers_are_numbered():
    numbers = {"none": 0, "two-tier": 1, "parallel": 2}
    for build, number in numbers.items():
        config = Config(checker=build, lanes=1)
        assert messages.info_values(config)["checker"] == number


def test_version_and_build_never_move():
    assert messages.info_reply(CONFIG).fields[:2] == (("version", 8), ("build_id", 32))


def test_recipe_is_short():
    # At most 15 % of the bytes of population mode, even for paths of two waypoints.
    order = messages.generate_request(CONFIG, LinkMode.RECIPE).size
    assert messages.recipe_reply(CONFIG).size + order <= 0.15 * 2 * 32 * 2 * 4


waypoints = st.integers(0, (1 << CONFIG.waypoint_bits) - 1)
paths = st.lists(st.lists(waypoints, min_size=2, max_size=16), max_size=8)


@given(paths)
def test_paths_round_trip(paths):
    packed = pack_paths(CONFIG, paths)
    assert len(packed) == 4 * sum(map(len, paths))
    assert unpack_paths(CONFIG, packed) == paths


def test_every_waypoint_begins_at_a_byte():
    """A waypoint of the default chip has 30 bits, the last 31."""
    packed = pack_paths(CONFIG, [[1, 2], [3, 4]])
    assert packed == bytes.fromhex("01000000 02000040 03000000 04000040")


@pytest.mark.parametrize(
    ("payload", "sentence"),
    [
        (b"abc", r"^Paths must be whole waypoints of 4 bytes, not 3 bytes$"),
        (bytes([0, 0, 0, 0x40]), r"^Path must have 2 to 16 waypoints, not 1$"),
        (bytes(16 * 4) + bytes([0, 0, 0, 0x40]), r"^Path must have 2 to 16 waypoints, not 17$"),
        (bytes(8), r"^Paths must end with a waypoint marked last$"),
    ],
)
def test_refuses_broken_paths(payload, sentence):
    with pytest.raises(ValueError, match=sentence):
        unpack_paths(CONFIG, payload)


@pytest.mark.parametrize("bits", range(4, 17))
@given(st.data())
def test_cells_round_trip(bits, data):
    config = Config(altitude_bits=bits)
    cells = data.draw(st.lists(st.integers(0, (1 << bits) - 1), max_size=40))
    packed = pack_cells(config, cells)
    assert len(packed) == -(-len(cells) * bits // 8)
    assert unpack_cells(config, packed)[: len(cells)] == cells


def test_cells_are_packed_without_gaps():
    assert pack_cells(CONFIG, [0xABC, 0x123, 0xFFF]) == bytes.fromhex("bc3a12ff0f")


entries = st.lists(
    st.tuples(st.integers(0, 16), st.integers(0, 512), st.integers(0, 512)), max_size=17
).map(tuple)
hits = st.builds(
    PathResult,
    st.just(True),
    st.integers(0, 16),
    st.tuples(st.integers(0, 511), st.integers(0, 511)),
    st.booleans(),
    st.integers(1, 17 * 512),
    entries,
)


@given(st.lists(st.just(PathResult()) | hits, max_size=10))
def test_results_round_trip(results):
    packed = pack_results(CONFIG, results)
    # A clear path takes a byte, a hit 5 more, an entry 4.
    assert len(packed) == sum(
        1 + 5 * result.collision + 4 * len(result.entries) for result in results
    )
    assert unpack_results(CONFIG, packed) == results


def test_refuses_torn_results():
    hit = PathResult(True, 3, (100, 200), False, 70, ((3, 5, 0),))
    packed = pack_results(CONFIG, [hit])
    assert unpack_results(CONFIG, packed) == [hit]
    for size in range(1, len(packed)):
        with pytest.raises(ValueError, match=f"^Results must be whole, not end after {size} byte"):
            unpack_results(CONFIG, packed[:size])


def test_versions_do_not_mix():
    body = b"\1\2\3"
    assert codec.frame_crc(body, plain=True) == zlib.crc32(body)
    assert codec.frame_crc(body, plain=False) == zlib.crc32(body) ^ codec.VERSION * 0x01010101
    assert codec.VERSION != 0

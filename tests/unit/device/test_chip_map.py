"""Map and checks of a chip through the host, on the software model, and the map's frames."""

import random

import numpy as np
import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import BODY_HEADER_BYTES, CRC_BYTES
from pathgene.hdl.protocol.codes import Command
from pathgene.hdl.protocol.messages import check_reply, map_request
from pathgene.hdl.protocol.paths import pack_results, unpack_cells
from pathgene.host.device.chip import Chip
from pathgene.host.device.chip_map import changed_parts, map_frames, padded_map
from pathgene.host.device.link import Link, LinkTimeoutError, RefusedError
from pathgene.host.errors import InputError
from pathgene.sim.model.checker import check_path
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from tests.support.gateware.chips import CHECKERS, CHECKING, SMALL, random_path, random_paths
from tests.support.gateware.faults import ByteFaults
from tests.unit.device.test_chip import SpyPort


CONFIG = CHECKERS["parallel"]


@pytest.mark.parametrize("shape", [(1, 1), (5, 16), (16, 3), (16, 16)])
def test_the_rest_of_the_map_is_blocked(shape):
    heights = np.arange(np.prod(shape)).reshape(shape) % CONFIG.blocked_altitude
    padded = padded_map(heights, CONFIG)
    assert padded.dtype == np.uint16
    assert padded.shape == (16, 16)
    rows, columns = shape
    assert (padded[:rows, :columns] == heights).all()
    assert (padded == CONFIG.blocked_altitude).sum() == 16 * 16 - rows * columns


@pytest.mark.parametrize("config", [CONFIG, Config()], ids=["small", "default"])
def test_frames_write_every_cell_of_a_rectangle_once(config):
    rng = np.random.default_rng(1)
    heights = rng.integers(config.blocked_altitude + 1, size=(9, 13))
    written = np.full((config.map_size,) * 2, -1)
    header = map_request(config).size
    for payload, cells in map_frames(config, heights, 2, 3):
        values = map_request(config).unpack(payload[:header])
        rows, columns = cells
        height, width = written[cells].shape
        assert values == {"x": columns.start, "y": rows.start, "width": width, "height": height}
        assert (written[cells] == -1).all()
        told = unpack_cells(config, payload[header:])[: width * height]
        written[cells] = np.array(told).reshape(height, width)
    assert (written[3:12, 2:15] == heights).all()
    assert (written >= 0).sum() == heights.size


@pytest.mark.parametrize("config", [CONFIG, Config()], ids=["small", "default"])
@pytest.mark.parametrize("share", [0.0, 0.001, 0.05, 1.0])
def test_changes_are_in_parts_of_a_frame_each(config, share):
    rng = np.random.default_rng(2)
    changed = rng.random((config.map_size,) * 2) < share
    heights = np.zeros(changed.shape, int)
    times = np.zeros(changed.shape, int)
    before = np.full(changed.shape, 7, dtype=np.int32)
    after = np.where(changed, 8, 7)
    for rows, columns in changed_parts(config, before, after):
        ((_, cells),) = map_frames(config, heights[rows, columns], columns.start, rows.start)
        assert cells == (rows, columns)
        inside = changed[cells]
        for axis in (0, 1):
            assert inside.any(axis=axis)[[0, -1]].all()
        times[cells] += 1
    assert times.max(initial=0) <= 1
    assert (times[changed] == 1).all()


FULL = Config(checker="two-tier", lanes=1)


def opened(config):
    port = SpyPort(ChipModel(config))
    return Chip(Link(port, timeout_s=0.01, attempts=8)), port


def heights_of(config, rng, rows, columns):
    return rng.integers(0, config.blocked_altitude + 1, (rows, columns))


@pytest.fixture
def chip():
    """Chip with random ground and random paths."""
    chip, _ = opened(CHECKING)
    rng = np.random.default_rng(1)
    chip.upload_map(rng.choice((0, 1, 2, 9, 15), (16, 16), p=(0.5, 0.3, 0.16, 0.03, 0.01)))
    chip.load(random_paths(CHECKING, random.Random(1)))
    return chip


def verdict_of(chip, path, counting):
    terrain = chip.link._transport.chip.checking.terrain
    points = [(word & 15, word >> 4 & 15, word >> 8 & 15) for word in path]
    return check_path(chip.config, terrain, points, counting)


def same(told, said):
    assert told.collision == said.collision
    if said.collision:
        assert (told.segment, told.cell, told.coarse) == (
            said.segment,
            (said.x, said.y),
            said.coarse,
        )
        assert (told.cells, told.entries) == (said.cells, said.entries)
    else:
        assert (told.segment, told.cell, told.coarse, told.cells, told.entries) == (
            *[None] * 4,
            (),
        )


@pytest.mark.parametrize(
    ("config", "x", "y", "shape"),
    [
        (CHECKING, 0, 0, (16, 16)),
        (CHECKING, 15, 3, (1, 1)),
        (CHECKING, 3, 5, (9, 13)),
        (FULL, 0, 0, (512, 512)),
        (FULL, 17, 250, (40, 101)),
        (FULL.replace(altitude_bits=16, receive_buffer=1024), 1, 1, (60, 60)),
        (FULL.replace(altitude_bits=7, coarse_factor=256), 0, 0, (30, 512)),
        (FULL.replace(coarse_factor=2), 1, 3, (300, 5)),
    ],
)
def test_frames_tile_the_rectangle(config, x, y, shape):
    heights = heights_of(config, np.random.default_rng(2), *shape)
    told = np.full((config.map_size, config.map_size), -1)
    sizes = []
    for payload, cells in map_frames(config, heights, x, y):
        layout = map_request(config)
        at = layout.unpack(payload[: layout.size])
        size = at["width"] * at["height"]
        assert cells == (
            slice(at["y"], at["y"] + at["height"]),
            slice(at["x"], at["x"] + at["width"]),
        )
        block = unpack_cells(config, payload[layout.size :])[:size]
        part = told[cells]
        assert (part == -1).all()  # No cell is sent twice.
        part[...] = np.reshape(block, part.shape)
        sizes.append(len(payload) + BODY_HEADER_BYTES + CRC_BYTES)
    assert (told[y : y + shape[0], x : x + shape[1]] == heights).all()
    assert np.count_nonzero(told != -1) == heights.size
    assert max(sizes) <= config.receive_buffer // 4


def test_a_whole_map_has_little_overhead():
    """It takes at most 1.11 times the bytes of its cells, with delimiters and COBS codes."""
    chip, port = opened(FULL)
    before = chip.link.traffic.bytes_to_board
    reports = []
    heights = heights_of(FULL, np.random.default_rng(3), 512, 512)
    chip.upload_map(heights, progress=lambda done, of: reports.append((done, of)))
    assert (port.chip.checking.terrain.heights == heights).all()
    sent = chip.link.traffic.bytes_to_board - before
    assert sent <= 1.06 * 512 * 512 * 12 / 8
    assert reports[-1] == (512 * 512, 512 * 512)
    assert len(reports) > 8
    assert reports == sorted(reports)


def test_uploads_a_part_of_the_map():
    chip, port = opened(CHECKING)
    rng = np.random.default_rng(4)
    expected = heights_of(CHECKING, rng, 16, 16)
    chip.upload_map(expected)
    part = heights_of(CHECKING, rng, 5, 3)
    chip.upload_map(part, 12, 7)
    expected[7:12, 12:15] = part
    assert (port.chip.checking.terrain.heights == expected).all()


@pytest.mark.parametrize(
    ("south", "west", "rows", "columns"), [(0, 0, 0, 0), (7, 12, 5, 3), (9, 2, 1, 1)]
)
def test_sends_only_changed_cells(south, west, rows, columns):
    chip, port = opened(CHECKING)
    heights = heights_of(CHECKING, np.random.default_rng(5), 16, 16)
    chip.upload_map(heights[:3])
    chip.update_map(heights)  # Includes cells never written.
    port.commands.clear()
    heights[south : south + rows, west : west + columns] ^= 1
    chip.update_map(heights)
    assert (port.chip.checking.terrain.heights == heights).all()
    layout = map_request(CHECKING)
    sent = [layout.unpack(payload[: layout.size]) for _, payload in port.commands]
    assert sum(tile["width"] * tile["height"] for tile in sent) == rows * columns


def test_changes_far_apart_are_sent_by_themselves():
    config = CHECKING.replace(map_size=64)
    chip, port = opened(config)
    heights = heights_of(config, np.random.default_rng(7), 64, 64)
    chip.upload_map(heights)
    port.commands.clear()
    heights[2:5, 3:9] ^= 1
    heights[8, 12] ^= 1
    heights[4, 40] ^= 1
    heights[60:63, 50:54] ^= 1
    told = []
    chip.update_map(heights, progress=lambda done, cells: told.append((done, cells)))
    assert (port.chip.checking.terrain.heights == heights).all()
    layout = map_request(config)
    sent = [layout.unpack(payload[: layout.size]) for _, payload in port.commands]
    every = 3 * 6 + 1 + 1 + 3 * 4
    assert sum(tile["width"] * tile["height"] for tile in sent) == every
    assert told == [(every, every)]


def test_resumes_a_failed_upload():
    """The line breaks halfway; the resumed upload sends only unacknowledged cells."""
    config = CHECKING.replace(map_size=128)
    chip, port = opened(config)
    heights = heights_of(config, np.random.default_rng(6), 128, 128)
    frames = len(list(map_frames(config, heights, 0, 0)))
    assert frames >= 4 * 64
    write = port.write

    def cut(data):
        return write(data if port.count(Command.MAP) < 3 * 64 else b"")

    port.write = cut
    with pytest.raises(LinkTimeoutError, match=r"^The board did not answer MAP in 8 attempts"):
        chip.update_map(heights)
    with pytest.raises(LinkTimeoutError):
        chip.update_map(heights)
    port.write = write
    port.commands.clear()
    chip.update_map(heights)
    assert (port.chip.checking.terrain.heights == heights).all()
    assert port.count(Command.MAP) <= frames - 2 * 64
    port.commands.clear()
    chip.update_map(heights)
    assert not port.commands


@pytest.mark.parametrize("seed", range(3))
def test_uploads_a_map_over_a_bad_line(seed):
    port = ModelPort(ChipModel(CHECKING.replace(map_size=64)))
    chip = Chip(Link(port, timeout_s=0.01, attempts=8))
    fault = ByteFaults(0.001, random.Random(seed))
    write = port.write
    port.write = lambda data: write(fault(bytes(data)))
    heights = heights_of(chip.config, np.random.default_rng(seed), 64, 64)
    chip.upload_map(heights)
    assert chip.link.traffic.frames_repeated > 3
    assert (port.chip.checking.terrain.heights == heights).all()


@pytest.mark.parametrize(
    ("heights", "x", "y", "sentence"),
    [
        (np.zeros((2, 2)), 0, 0, r"^Heights must be a filled array .* not of shape \(2, 2\) of fl"),
        (np.zeros(4, int), 0, 0, r"^Heights must be a filled array .* not of shape \(4,\) of int"),
        (np.zeros((0, 4), int), 0, 0, r"^Heights must be a filled array of two axes of integers"),
        (np.zeros((2, 3), int), 14, 0, r"^Heights must lie within 0..15, not 3 x 2 cells at \(14"),
        (np.zeros((2, 3), int), 0, 15, r"^Heights must lie within 0..15, not 3 x 2 cells at \(0, "),
        (np.zeros((2, 3), int), -1, 0, r"^Heights must lie within 0..15, not 3 x 2 cells at \(-1"),
        (np.full((2, 2), 16), 0, 0, r"^Heights must be from 0 to 15, not 16 to 16$"),
        (np.full((2, 2), -1), 0, 0, r"^Heights must be from 0 to 15, not -1 to -1$"),
    ],
)
def test_refuses_wrong_heights(chip, heights, x, y, sentence):
    with pytest.raises(ValueError, match=sentence):
        chip.upload_map(heights, x, y)


def test_refuses_a_partial_map_as_the_whole(chip):
    with pytest.raises(ValueError, match=r"must be a whole map of \(16, 16\), not of \(16, 15\)$"):
        chip.update_map(np.zeros((16, 15), int))


@pytest.mark.parametrize("counting", [False, True])
def test_checks_a_path(chip, counting):
    rng = random.Random(5)
    collisions = 0
    for length in [2, 4, 7] * 10:
        path = random_path(CHECKING, rng, length)
        checked = chip.check_path(path, counting=counting)
        said = verdict_of(chip, path, counting)
        [told] = checked.verdicts
        same(told, said)
        assert checked.cells == said.cells
        assert checked.cycles > 0
        collisions += told.collision
    assert 5 < collisions < 30


@pytest.mark.parametrize("counting", [False, True])
def test_checks_the_population(chip, counting):
    start, goal = 0xF11, 0xFEE
    every = chip.check_population(start, goal, counting=counting)
    assert len(every.verdicts) == 8
    for slot, told in enumerate(every.verdicts):
        same(told, verdict_of(chip, [start, *chip.paths[slot], goal], counting))
    some = chip.check_population(start, goal, slot=3, count=2, counting=counting)
    assert some.verdicts == every.verdicts[3:5]
    assert some.cells < every.cells
    assert (
        chip.check_population(start, goal, slot=6, counting=counting).verdicts
        == (every.verdicts[6:])
    )


def test_clear_paths_take_a_byte_each():
    chip, _ = opened(CHECKING)
    chip.upload_map(np.zeros((16, 16), int))
    chip.load([[0xF00, 0xF11]] * 8)
    traffic = chip.link.traffic
    before = traffic.bytes_from_board
    checked = chip.check_population(0xF00, 0xFFF, counting=True)
    assert not any(verdict.collision for verdict in checked.verdicts)
    # Header, totals, results, CRC, COBS code, delimiter.
    assert traffic.bytes_from_board - before == 3 + check_reply(CHECKING).size + 8 + 4 + 2


@pytest.mark.parametrize("counting", [False, True])
def test_requests_lost_long_replies_in_parts(chip, counting):
    """A line transfers only short frames; the chip still checks each path once."""
    port = chip.link._transport
    ends = 0x111, 0x1EE
    path = [ends[0], 0x3A0, 0x22F, 0x1F1, ends[1]]
    expected = (
        chip.check_population(*ends, counting=counting),
        chip.check_path(path, counting=counting),
    )
    before = chip.counters()["paths"]
    for ask, told in zip(
        (
            lambda: chip.check_population(*ends, counting=counting),
            lambda: chip.check_path(path, counting=counting),
        ),
        expected,
        strict=True,
    ):
        whole = BODY_HEADER_BYTES + check_reply(CHECKING).size
        whole += len(pack_results(CHECKING, told.verdicts))
        port.answered = lambda body, plain, size=whole: body if len(body) < size else None
        results = port.count(Command.RESULTS)
        assert ask() == told
        assert port.count(Command.RESULTS) == results + (len(told.verdicts) + 1) // 2
    port.answered = lambda body, plain: body
    assert chip.counters()["paths"] == before + 8 + 1


def test_refuses_checks_without_a_checker():
    chip, port = opened(SMALL)
    sentence = (
        "^The board has no collision checker: use one that was built with "
        "checker=parallel or checker=two-tier.$"
    )
    for ask in (
        lambda: chip.upload_map(np.zeros((1, 1), int)),
        lambda: chip.update_map(np.zeros((1, 1), int)),
        lambda: chip.check_path([1, 2]),
        lambda: chip.check_population(1, 2),
    ):
        with pytest.raises(InputError, match=sentence):
            ask()
    with pytest.raises(RefusedError, match=r"START with BAD_VALUE"):
        chip.start(0, (15, 15, 9), avoid_ground=True)
    assert port.count(Command.MAP) == port.count(Command.CHECK) == 0


def test_avoids_the_ground_on_request(chip):
    chip.start(1, (15, 15, 14), avoid_ground=True)
    assert chip.link._transport.chip.core.avoid_ground
    chip.start(1, (15, 15, 14))
    assert not chip.link._transport.chip.core.avoid_ground

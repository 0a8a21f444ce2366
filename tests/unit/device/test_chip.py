"""The chip's commands as methods, on the software model."""

import random
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import (
    BODY_HEADER_BYTES,
    VERSION,
    FrameSplitter,
    decode_frame,
    encode_frame,
)
from pathgene.hdl.protocol.codes import Command, LinkMode
from pathgene.hdl.protocol.messages import info_reply, write_request
from pathgene.hdl.protocol.paths import pack_paths
from pathgene.host.device.chip import Chip, Step
from pathgene.host.device.link import Link, RefusedError
from pathgene.host.device.paths import pack_waypoints, unpack_waypoints
from pathgene.host.errors import InputError
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from pathgene.sim.model.core import PaperCore
from pathgene.sim.model.mutation import Limits
from tests.support.gateware.chips import SMALL, random_paths
from tests.support.gateware.faults import ByteFaults, FaultyTransport, VirtualClock


LIMITS = (13, 15, 14)


class SpyPort(ModelPort):
    """Port to the model that records commands and can change replies."""

    def __init__(self, model):
        super().__init__(model)
        self.commands = []
        self.answered = lambda body, plain: body
        self._splitter = FrameSplitter()

    def write(self, data):
        for encoded in self._splitter.feed(bytes(data)):
            body, _ = decode_frame(encoded)
            self.commands.append((Command(body[2]), body[BODY_HEADER_BYTES:]))
        for encoded in FrameSplitter().feed(self.chip.feed(bytes(data))):
            body, plain = decode_frame(encoded)
            changed = self.answered(body, plain)
            if changed is not None:
                self._received += encode_frame(changed, plain=plain)
        return len(data)

    def count(self, command):
        """Return the number of times that ``command`` was sent."""
        return sum(code == command for code, _ in self.commands)


@pytest.fixture
def port():
    return SpyPort(ChipModel(SMALL))


def opened(port, **options):
    return Chip(Link(port, timeout_s=0.01, attempts=8), **options)


@pytest.fixture
def chip(port):
    """A small chip, started and loaded."""
    chip = opened(port)
    chip.start(5, LIMITS)
    chip.load(random_paths(SMALL, random.Random(1)))
    return chip


@pytest.mark.parametrize("config", [SMALL, Config()], ids=["small", "default"])
@pytest.mark.parametrize("mode", LinkMode)
def test_every_mode_matches_the_core(config, mode):
    rng = random.Random(2)
    chip = opened(ModelPort(ChipModel(config)))
    core = PaperCore(config)
    limits = (config.map_size - 3, config.map_size - 1, 9)
    chip.start(77, limits)
    core.start(77, Limits(*limits))
    core.paths = random_paths(config, rng)
    chip.load(core.paths)
    for _ in range(30):
        order = rng.sample(range(config.population), config.population)
        done = core.run(order)
        step = chip.step(order, mode)
        assert step.paths == core.paths
        if mode is LinkMode.POPULATION:
            assert step.origin is None
        else:
            assert step.origin == (*order[: config.elites], *done.survivors)
    assert chip.read(0, config.population) == core.paths
    assert chip.status()["generation"] == 30


def test_modes_may_change_from_step_to_step(chip, port):
    rng = random.Random(3)
    for mode in list(LinkMode) * 5:
        step = chip.step(rng.sample(range(8), 8), mode)
        assert step.paths == port.chip.core.paths


def test_rank_is_the_default(chip, port):
    chip.step(range(8))
    assert port.commands[-1][1][0] == LinkMode.RANK


def test_restart_repeats_the_run(chip):
    paths = random_paths(SMALL, random.Random(4))
    runs = []
    for _ in range(2):
        chip.start(99, LIMITS)
        chip.load(paths)
        runs.append([chip.step(range(8), LinkMode.RECIPE) for _ in range(5)])
        assert chip.status()["generation"] == 5
    assert runs[0] == runs[1]


def test_load_of_some_slots(chip, port):
    before = chip.read(0, 8)
    fresh = [[1, 2, 3], [4, 5]]
    chip.load(fresh, slot=5)
    expected = [*before[:5], *fresh, before[7]]
    assert chip.read(0, 8) == port.chip.core.paths == expected
    assert chip.read(5, 2) == fresh
    assert chip.read(6, 2) == [[4, 5], before[7]]
    # The host's copy is up to date.
    assert chip.step(range(8)).paths == port.chip.core.paths


@pytest.mark.parametrize("mode", LinkMode)
@pytest.mark.parametrize("slots", [(), (0, 3), (2, 4), (6, 2)], ids=str)
def test_a_step_after_a_partial_load_reads_the_chip(port, mode, slots):
    opened(port).load(random_paths(SMALL, random.Random(7)))
    before = [list(path) for path in port.chip.core.paths]
    chip = opened(port)
    chip.start(5, LIMITS)
    if slots:
        slot, count = slots
        fresh = random_paths(SMALL, random.Random(8))[:count]
        chip.load(fresh, slot)
        before[slot : slot + count] = fresh
    assert chip.paths == port.chip.core.paths == before
    assert chip.step(range(8), mode).paths == port.chip.core.paths


@pytest.mark.parametrize("mode", LinkMode)
def test_callers_may_change_a_step(chip, port, mode):
    step = chip.step(range(8), mode)
    step.paths[0][0] ^= 1
    step.paths.pop()
    assert chip.paths == port.chip.core.paths
    assert chip.step(range(8), LinkMode.RANK).paths == port.chip.core.paths


def test_rereads_the_copy_after_a_refused_load(chip, port):
    with pytest.raises(RefusedError, match=r"WRITE with BAD_VALUE"):
        chip.load([[1, 2], [3, 4, 5]], slot=7)
    assert chip.paths == port.chip.core.paths
    assert port.count(Command.READ) == 4


def test_load_of_nothing_sends_nothing(chip, port):
    sent = len(port.commands)
    chip.load([])
    assert len(port.commands) == sent


def test_transfers_are_short_frames():
    config = Config(max_waypoints=20)
    port = SpyPort(ChipModel(config))
    chip = opened(port)
    paths = random_paths(config, random.Random(5), length=20)
    chip.load(paths)
    assert chip.read(0, 32) == paths
    writes = [payload for command, payload in port.commands if command is Command.WRITE]
    # A frame has complete paths: at most 128 bytes of waypoints, or one longer path.
    assert all(len(payload) <= 1 + 128 for payload in writes)
    assert [payload[0] for payload in writes] == list(range(32))
    chip.load(random_paths(config, random.Random(5), length=2))
    writes = [payload for command, payload in port.commands if command is Command.WRITE][32:]
    assert [payload[0] for payload in writes] == [0, 16]


def stale(chip, slot):
    """Write to a slot of the chip directly, so that the host's copy is wrong."""
    path = [0xFFF] * 5
    chip.link.request(
        Command.WRITE, write_request(SMALL).pack(slot=slot) + pack_paths(SMALL, [path])
    )


@pytest.mark.parametrize("slot", range(8))
def test_recipe_repairs_a_wrong_copy(chip, port, slot):
    chip.step(range(8), LinkMode.RECIPE)
    assert port.count(Command.READ) == 0
    stale(chip, slot)
    # The first is an elite, which stays in the population.
    order = [slot, *(other for other in range(8) if other != slot)]
    step = chip.step(order, LinkMode.RECIPE)
    assert step.paths == port.chip.core.paths
    assert step.paths[0] == [0xFFF] * 5
    reads = port.count(Command.READ)
    assert reads == 4
    # The copy is correct again.
    for _ in range(5):
        assert chip.step(range(8), LinkMode.RECIPE).paths == port.chip.core.paths
    assert port.count(Command.READ) == reads


def test_recipe_reads_the_population_periodically(port):
    chip = opened(port, verify_every=3)
    chip.load(random_paths(SMALL, random.Random(6)))
    seen = []
    for _ in range(7):
        chip.step(range(8), LinkMode.RECIPE)
        seen.append(port.count(Command.READ))
    assert seen == [0, 0, 4, 4, 4, 8, 8]


@pytest.mark.parametrize("mode", [LinkMode.POPULATION, LinkMode.RANK])
def test_rebuilds_lost_long_replies(chip, port, mode):
    """A line that transfers only short frames still transfers a recipe."""
    port.answered = lambda body, plain: body if len(body) < 24 else None
    for _ in range(3):
        step = chip.step(list(range(8))[::-1], mode)
        assert step.paths == port.chip.core.paths
        assert step.origin is not None
    assert port.chip.core.generation == 3


def test_counters_and_errors(chip, port):
    chip.step(range(8))
    counters = chip.counters()
    assert counters["generations"] == 1
    assert counters["update"] == 1
    port.chip.feed(b"\7\7\0")
    assert chip.status()["errors"] == 8
    chip.clear_errors()
    assert chip.status()["errors"] == 0


def test_reports_refusals(chip):
    sentence = (
        "The board refused the command GENERATE with BAD_VALUE: host and board disagree; "
        "use the release it was built with."
    )
    with pytest.raises(RefusedError, match=f"^{re.escape(sentence)}$"):
        chip.link.request(Command.GENERATE, bytes((LinkMode.RANK, *[0] * 8)))
    with pytest.raises(RefusedError, match=r"START with BAD_VALUE"):
        chip.start(0, (16, 0, 0))
    with pytest.raises(RefusedError, match=r"WRITE with BAD_VALUE"):
        chip.load([[1, 2]], slot=8)


def test_refuses_another_version(port):
    def newer(body, plain):
        return body[:3] + bytes((VERSION + 1,)) + body[4:] if plain else body

    port.answered = newer
    sentence = (
        f"The board speaks protocol version {VERSION + 1}, this host version {VERSION}: "
        "load a bitstream of this release, or use the release the board was built with."
    )
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        opened(port)
    assert port.count(Command.OPEN) == 0


def test_refuses_a_version_with_another_reply(port):
    port.answered = lambda body, plain: body[:3] + bytes((200, 1, 2)) if plain else body
    with pytest.raises(InputError, match=r"^The board speaks protocol version 200, this host "):
        opened(port)


@pytest.mark.parametrize("field", ["build_id", "max_waypoints", "box_percent", "clocks_per_bit"])
def test_refuses_another_build(port, field):
    layout = info_reply(SMALL)

    def changed(body, plain):
        values = layout.unpack(body[3:])
        return body[:3] + layout.pack(**values | {field: values[field] ^ 8}) if plain else body

    port.answered = changed
    built = SMALL.build_id ^ 8 if field == "build_id" else SMALL.build_id
    made = SMALL if field == "build_id" else SMALL.replace(**{field: getattr(SMALL, field) ^ 8})
    sentence = (
        f"The board was built as {built:08x}, but the sizes that it reports make "
        f"{made.build_id:08x} here: load a bitstream of this release."
    )
    with pytest.raises(InputError, match=f"^{re.escape(sentence)}$"):
        opened(port)


def test_information(chip):
    assert chip.config == SMALL
    assert chip.info["build_id"] == SMALL.build_id
    assert chip.info["session"] == 0


def test_sessions_follow_each_other(port):
    for session in range(3):
        with opened(port) as chip:
            assert chip.info["session"] == session
            assert chip.link.session == session + 1
        assert chip.link.session is None


def test_steps_are_values():
    assert Step([[1, 2]], (0,)) == Step([[1, 2]], (0,))
    assert Step([[1, 2]], (0,)) != Step([[1, 2]], None)


CONFIG = Config()
cells = st.tuples(
    st.integers(0, CONFIG.map_size - 1),
    st.integers(0, CONFIG.map_size - 1),
    st.integers(0, CONFIG.blocked_altitude),
)


@given(st.lists(cells, min_size=1, max_size=20))
def test_waypoints_survive_packing(path):
    packed = pack_waypoints(CONFIG, np.array(path))
    assert packed == [x | y << 9 | altitude << 18 for x, y, altitude in path]
    assert all(type(waypoint) is int for waypoint in packed)
    unpacked = unpack_waypoints(CONFIG, packed)
    assert unpacked.dtype == np.int64
    assert unpacked.tolist() == [list(cell) for cell in path]


@pytest.mark.parametrize("length", range(2, 8))
def test_bytes_by_mode(length):
    """Rank mode uses at most 45 % of the bytes of population mode, recipe mode at most 15 %.

    Over 300 generations, paths of ``length`` waypoints are the fittest; runs over real terrain end
    with 2 to 7.
    """
    spent = {}
    for mode in LinkMode:
        chip = opened(ModelPort(ChipModel(CONFIG)))
        chip.start(1, (511, 511, 4000))
        paths = random_paths(CONFIG, random.Random(1), 2)
        chip.load(paths)
        traffic = chip.link.traffic
        before = traffic.bytes_to_board + traffic.bytes_from_board
        total = 0
        for _ in range(300):
            order = sorted(range(32), key=lambda slot: abs(len(paths[slot]) - length))
            paths = chip.step(order, mode).paths
            total += sum(map(len, paths))
        assert total / (300 * 32) == pytest.approx(length, abs=0.3)
        spent[mode] = traffic.bytes_to_board + traffic.bytes_from_board - before
    assert spent[LinkMode.RANK] <= 0.45 * spent[LinkMode.POPULATION]
    assert spent[LinkMode.RECIPE] <= 0.15 * spent[LinkMode.POPULATION]


#: Probability of each fault, per byte and direction.
RATE = 1e-3


def breed(chip, generations, mode):
    """Run ``generations`` and return the populations of the host and of the chip."""
    rng = random.Random(8)
    chip.start(seed=21, limits=(500, 511, 4000))
    chip.load(
        [
            [rng.getrandbits(CONFIG.waypoint_bits) for _ in range(rng.randint(2, 7))]
            for _ in range(CONFIG.population)
        ]
    )
    for _ in range(generations):
        chip.step(rng.sample(range(CONFIG.population), CONFIG.population), mode)
    assert chip.read(0, CONFIG.population) == chip.paths
    return chip.paths


@pytest.mark.ci
@pytest.mark.parametrize(
    ("mode", "generations"),
    [
        (LinkMode.RANK, 2000),
        (LinkMode.POPULATION, 200),
        (LinkMode.RECIPE, 200),
        pytest.param(LinkMode.POPULATION, 2000, marks=pytest.mark.long),
        pytest.param(LinkMode.RECIPE, 2000, marks=pytest.mark.long),
    ],
    ids=lambda value: value.name.lower() if isinstance(value, LinkMode) else None,
)
def test_same_population_with_and_without_faults(mode, generations):
    rng = random.Random(mode)
    clock = VirtualClock()
    model = ChipModel(CONFIG)
    faults = [ByteFaults(RATE, rng), ByteFaults(RATE, rng)]
    port = FaultyTransport(model.feed, clock, to_board=faults[0], from_board=faults[1])
    with (
        Chip(Link(port, timeout_s=0.25, attempts=60, clock=clock)) as bad,
        Chip(Link(ModelPort(ChipModel(CONFIG)))) as good,
    ):
        assert breed(bad, generations, mode) == breed(good, generations, mode)
        assert model.core.generation == generations
        assert bad.link.traffic.frames_repeated > generations // 20
    assert all(fault.count > generations // 20 for fault in faults)

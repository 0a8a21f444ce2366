"""Model of the whole chip: the order of commands, requests that break its rules, random frames."""

import collections
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import ChipState, Command, Counter, LinkMode, Status, StickyError
from pathgene.hdl.protocol.messages import (
    counters_reply,
    generate_request,
    info_reply,
    info_values,
    read_request,
    recipe_reply,
    start_request,
    status_reply,
    survivors_reply,
)
from pathgene.hdl.protocol.paths import pack_paths, unpack_paths
from pathgene.sim.model.chip import Chip
from pathgene.sim.model.core import PaperCore
from pathgene.sim.model.mutation import Limits
from tests.support.gateware.chips import SMALL, random_paths
from tests.support.gateware.command_fuzz import CHIPS, fault_free, fuzz, table
from tests.support.gateware.frame_mix import KINDS
from tests.support.gateware.protocol_rules import ProtocolRules
from tests.support.gateware.refusals import refusals


START = start_request(SMALL)
ORDER = [3, 0, 7, 1, 2, 6, 5, 4]
GOOD_START = START.pack(seed=0x0123456789ABCDEF, x=15, y=3, altitude=14, avoid_ground=0)


def ask(chip, body, *, plain=False):
    """Return the body of the reply to ``body``, or None."""
    answers = FrameSplitter().feed(chip.feed(encode_frame(bytes(body), plain=plain)))
    if not answers:
        return None
    assert len(answers) == 1
    (answer,) = answers
    told, answer_plain = decode_frame(answer)
    assert answer_plain == plain
    return told


class Session:
    """Host that numbers its commands and expects each to be executed."""

    def __init__(self, config=SMALL):
        self.chip = Chip(config)
        assert ask(self.chip, (1, 0, Command.OPEN)) == bytes((1, 0, Status.OK))
        self.sequence = 0

    def __call__(self, command, payload=b""):
        answer = ask(self.chip, bytes((1, self.sequence, command)) + payload)
        assert answer[:3] == bytes((1, self.sequence, Status.OK))
        self.sequence = (self.sequence + 1) % 256
        return answer[3:]


@pytest.fixture
def host():
    return Session()


def test_info_is_plain_and_needs_no_session():
    chip = Chip(SMALL)
    for session in (0, 1):
        answer = ask(chip, (99, 7, Command.INFO), plain=True)
        assert answer is not None
        assert answer[:3] == bytes((99, 7, Status.OK))
        assert info_reply(SMALL).unpack(answer[3:]) == info_values(SMALL) | {"session": session}
        ask(chip, (1, 0, Command.OPEN))
    for code in Command:
        answer = ask(chip, (1, 0, code), plain=True)
        assert (answer is None) == (code is not Command.INFO)


@pytest.mark.parametrize(("code", "payload", "status"), refusals(SMALL, ORDER))
def test_refuses_bad_requests(host, code, payload, status):
    """A refusal gets a reply and is recorded, but uses no sequence number and changes nothing."""
    host(Command.WRITE, b"\0" + pack_paths(SMALL, random_paths(SMALL, random.Random(1))))
    before = [list(path) for path in host.chip.core.paths]
    answer = ask(host.chip, bytes((1, host.sequence, code)) + payload)
    assert answer == bytes((1, host.sequence, status))
    assert host.chip.core.paths == before
    assert host.chip.core.generation == 0
    told = status_reply(SMALL).unpack(host(Command.STATUS))
    assert told["errors"] == StickyError.REFUSED
    host(Command.CLEAR)
    assert status_reply(SMALL).unpack(host(Command.STATUS))["errors"] == 0


def test_order_of_commands():
    status = Command.STATUS
    script = [
        ((5, 0, status), (5, 0, Status.NO_SESSION)),  # No such session.
        ((0, 0, status), (0, 0, Status.OK)),  # Session 0 is open after reset.
        ((2, 0, Command.OPEN), (2, 0, Status.NO_SESSION)),  # Not the next session.
        ((1, 0, Command.OPEN), (1, 0, Status.OK)),
        ((0, 1, status), (0, 1, Status.NO_SESSION)),  # The previous session.
        ((1, 0, status), (1, 0, Status.OK)),
        ((1, 0, status), (1, 0, Status.OK)),  # Repeated.
        ((1, 1, status), (1, 1, Status.OK)),
        ((1, 0, Command.OPEN), (1, 0, Status.OK)),  # Open already.
        ((1, 0, status), (1, 0, Status.DUPLICATE)),  # Two numbers back.
        ((1, 3, status), (1, 2, Status.OUT_OF_ORDER)),  # One number too far.
        ((1, 0x82, status), (1, 2, Status.OUT_OF_ORDER)),  # The farthest number ahead.
        ((1, 0x83, status), (1, 0x83, Status.DUPLICATE)),
        ((1, 2, status), (1, 2, Status.OK)),
    ]
    chip = Chip(SMALL)
    for body, header in script:
        assert ask(chip, body)[:3] == bytes(header), body


def test_numbers_wrap(host):
    for _ in range(300):
        host(Command.STATUS)
    for session in [*range(2, 256), 0, 1]:
        assert ask(host.chip, (session, 3, Command.OPEN)) == bytes((session, 3, Status.OK))
    assert ask(host.chip, (1, 0, Command.STATUS))[2] == Status.OK


def test_repeated_commands_change_nothing(host):
    chip = host.chip
    rng = random.Random(2)

    def again(command, payload):
        return ask(chip, bytes((1, (host.sequence - 1) % 256, command)) + payload)[3:]

    host(Command.START, GOOD_START)
    again(Command.START, START.pack(seed=1, x=1, y=1, altitude=1, avoid_ground=0))
    assert chip.core.limits == Limits(15, 3, 14)
    paths = random_paths(SMALL, rng)
    host(Command.WRITE, b"\0" + pack_paths(SMALL, paths))
    again(Command.WRITE, b"\0" + pack_paths(SMALL, random_paths(SMALL, rng)))
    assert chip.core.paths == paths

    rank = host(Command.GENERATE, bytes((LinkMode.RANK, *ORDER)))
    assert again(Command.GENERATE, bytes((LinkMode.RANK, *ORDER))) == rank
    # A repeated command may ask for a different link mode.
    recipe = again(Command.GENERATE, bytes((LinkMode.RECIPE, *ORDER)))
    assert len(recipe) == recipe_reply(SMALL).size
    values = recipe_reply(SMALL).unpack(recipe)
    assert values["checksum"] == chip.core.checksum()
    assert [values[f"survivor_{i}"] for i in range(2)] == list(rank[:2])
    whole = again(Command.GENERATE, bytes((LinkMode.POPULATION,)))
    assert unpack_paths(SMALL, whole) == chip.core.paths
    assert chip.core.generation == 1


def test_a_repeated_command_is_refused_if_it_is_invalid(host):
    host(Command.WRITE, b"\0" + pack_paths(SMALL, random_paths(SMALL, random.Random(4))))
    whole = bytes((LinkMode.RANK, *ORDER))
    done = host(Command.GENERATE, whole)
    number = (host.sequence - 1) % 256
    for wrong in (whole[:-1], whole + b"\0"):
        answer = ask(host.chip, bytes((1, number, Command.GENERATE)) + wrong)
        assert answer == bytes((1, number, Status.BAD_LENGTH))
    assert ask(host.chip, bytes((1, number, Command.GENERATE)) + whole)[3:] == done
    assert host.chip.core.generation == 1


def test_generations_match_the_core(host):
    rng = random.Random(3)
    core = PaperCore(SMALL)
    core.start(0x0123456789ABCDEF, Limits(15, 3, 14))
    core.paths = random_paths(SMALL, rng)
    host(Command.START, GOOD_START)
    host(Command.WRITE, b"\0" + pack_paths(SMALL, core.paths))
    for number in range(12):
        mode = LinkMode(number % 3)
        order = list(range(8)) if mode is LinkMode.POPULATION else rng.sample(range(8), 8)
        payload = bytes((mode,)) + (b"" if mode is LinkMode.POPULATION else bytes(order))
        assert len(payload) == generate_request(SMALL, mode).size
        reply = host(Command.GENERATE, payload)
        done = core.run(order)
        if mode is LinkMode.POPULATION:
            assert unpack_paths(SMALL, reply) == core.paths
        elif mode is LinkMode.RANK:
            size = survivors_reply(SMALL).size
            assert tuple(reply[:size]) == done.survivors
            assert unpack_paths(SMALL, reply[size:]) == core.paths[4:]
        else:
            values = recipe_reply(SMALL).unpack(reply)
            assert tuple(values[f"parent_{i}"] for i in range(2)) == done.parents
            assert tuple(values[f"survivor_{i}"] for i in range(2)) == done.survivors
            for i, mutated in enumerate(done.mutations):
                assert values[f"applied_{i}"] == mutated.applied
                assert values[f"child_{i}"] == mutated.child
                assert values[f"index_{i}"] == mutated.index
                assert values.get(f"waypoint_{i}", 0) == mutated.waypoint
            assert values["checksum"] == core.checksum()
    slots = read_request(SMALL).pack(slot=2, count=5)
    assert unpack_paths(SMALL, host(Command.READ, slots)) == core.paths[2:7]


def test_status_has_the_states_and_the_latest_cycles(host):
    host(Command.WRITE, b"\0" + pack_paths(SMALL, [[1] * 5] * 8))
    host(Command.GENERATE, bytes((LinkMode.RANK, *ORDER)))
    told = status_reply(SMALL).unpack(host(Command.STATUS))
    listen, receive, crossover, mutate, update, transmit, _ = ChipState
    history = (receive, crossover, mutate, update, transmit, listen, receive, transmit)
    assert told["history"] == int("".join(f"{state:x}" for state in history), 16)
    assert told["state"] == ChipState.TRANSMIT
    assert told["generation"] == 1
    assert (told["crossover"], told["mutation"], told["update"]) == (6, 2, 1)


def test_counters(host):
    host(Command.WRITE, b"\0" + pack_paths(SMALL, [[1] * 5] * 8))
    host(Command.GENERATE, bytes((LinkMode.RANK, *ORDER)))
    before = counters_reply(SMALL).unpack(host(Command.COUNTERS))
    assert before["generations"] == 1
    assert (before["crossover"], before["mutation"], before["update"]) == (6, 2, 1)
    assert before["longest"] == 9
    assert before["refused_mutations"] == 1  # Paths of 5 waypoints cannot grow.
    after = counters_reply(SMALL).unpack(host(Command.COUNTERS))
    # Header 3, CRC 4, COBS 2 bytes.
    assert after["bytes_received"] - before["bytes_received"] == 9
    assert after["bytes_sent"] - before["bytes_sent"] == 9 + counters_reply(SMALL).size
    assert after["receive"] - before["receive"] == 9 * 10 * SMALL.clocks_per_bit
    assert after["clocks"] == after["receive"] + after["transmit"] + 9
    assert set(after) == set(Counter)


def test_start_keeps_the_population(host):
    paths = random_paths(SMALL, random.Random(6))
    host(Command.WRITE, b"\0" + pack_paths(SMALL, paths))
    host(Command.START, GOOD_START)
    slots = read_request(SMALL).pack(slot=0, count=8)
    assert unpack_paths(SMALL, host(Command.READ, slots)) == paths


def test_longest_generation_restarts_with_start(host):
    longest = []
    for length in (5, 2):
        host(Command.START, GOOD_START)
        host(Command.WRITE, b"\0" + pack_paths(SMALL, [[1] * length] * 8))
        host(Command.GENERATE, bytes((LinkMode.RANK, *ORDER)))
        longest.append(counters_reply(SMALL).unpack(host(Command.COUNTERS))["longest"])
    assert longest == [9, 6]


near = st.sampled_from([0, 1, 255])
bodies = st.builds(
    lambda session, sequence, code, payload: bytes((session, sequence, code)) + payload,
    st.one_of(near, st.integers(0, 255)),
    st.one_of(near, st.integers(0, 255)),
    st.one_of(st.sampled_from(Command), st.integers(0, 255)),
    st.one_of(
        st.binary(max_size=60),
        st.just(GOOD_START),
        st.permutations(range(8)).map(lambda order: bytes((1, *order))),
        st.permutations(range(8)).map(lambda order: bytes((2, *order))),
        st.just(b"\0" + pack_paths(SMALL, [[1, 2]])),
    ),
)


@given(st.lists(st.tuples(bodies, st.booleans() | st.just(False)), max_size=30))
def test_replies_to_any_bodies_by_the_rules(script):
    chip = Chip(SMALL)
    rules = ProtocolRules(SMALL)
    for body, plain in script:
        rules.judge(body, plain, ask(chip, body, plain=plain))
    # The chip still works as before.
    session = (rules.session + 1) % 256
    assert ask(chip, (session, 0, Command.OPEN)) == bytes((session, 0, Status.OK))
    whole = read_request(SMALL).pack(slot=0, count=8)
    answer = ask(chip, bytes((session, 0, Command.READ)) + whole)
    assert len(unpack_paths(SMALL, answer[3:])) == 8


@given(st.lists(st.binary(max_size=40), max_size=20))
def test_replies_after_any_bytes(pieces):
    chip = Chip(SMALL)
    for piece in pieces:
        chip.feed(piece)
    answers = FrameSplitter().feed(
        chip.feed(b"\0" + encode_frame(bytes((0, 0, Command.INFO)), plain=True))
    )
    body, plain = decode_frame(answers[-1])
    assert plain
    assert body[:3] == bytes((0, 0, Status.OK))


def test_accepts_bodies_in_pieces():
    chip, other = Chip(SMALL), Chip(SMALL)
    data = b"".join(encode_frame(bytes((0, sequence, Command.READ, 0, 3))) for sequence in range(5))
    whole = chip.feed(data)
    assert whole
    assert b"".join(other.feed(bytes((value,))) for value in data) == whole


def test_default_chip_starts_with_the_shortest_paths():
    host = Session(Config())
    paths = host(Command.READ, read_request(Config()).pack(slot=0, count=32))
    assert unpack_paths(Config(), paths) == [[0, 0]] * 32


#: Seeds, and frames of each after a reset.
SHORT, LONG = (1, 2000), (50, 10_000)


@pytest.mark.parametrize("chip", CHIPS)
@pytest.mark.parametrize(
    ("seeds", "frames"),
    [
        pytest.param(*SHORT, id="short"),
        pytest.param(*LONG, id="million", marks=pytest.mark.long),
    ],
)
def test_answers_by_the_rules_and_works_as_before(chip, seeds, frames):
    """The long run sends half a million frames to each kind of chip; see ``command_fuzz``."""
    counts = collections.Counter()
    for seed in range(seeds):
        counts += fuzz(chip, seed, frames)
    print(table(counts))
    assert counts.total() == seeds * frames
    assert {kind for kind, _ in counts} == set(KINDS)
    # No model is busy: a run is over before the next command.
    assert {status for _, status in counts} == {*Status, None} - {Status.BUSY}


def test_a_failure_names_the_command_that_repeats_it(monkeypatch):
    assert fault_free("paper")
    read = Chip._read
    monkeypatch.setattr(Chip, "_read", lambda *request: read(*request)[:-1])
    again = r"; again by: python -m tests\.support\.gateware\.command_fuzz paper 3 500$"
    with pytest.raises(AssertionError, match=rf"^frame 500 of seed 3, .*{again}"):
        fuzz("paper", 3, 600)

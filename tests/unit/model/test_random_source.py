"""The model of the random source, and its compiled twins."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathgene.hdl.protocol.random_words import LANES, WARM_UP_STEPS, WORD_BITS
from pathgene.sim.model.planner.random_words import draw, field, source, step
from pathgene.sim.model.random_source import RandomSource, Trivium
from pathgene.sim.model.random_stream import RandomStream, main
from tests.support.host.processes import Started


ROOT = Path(__file__).parents[3]

SEEDS = st.integers(0, (1 << 64) - 1)
KEYS = st.integers(0, (1 << 80) - 1)


def keystream(generator, size):
    """Return bytes as printed by the cipher's authors, lowest bit first."""
    bits = "".join(f"{generator.step():0{WORD_BITS}b}" for _ in range(size * 8 // WORD_BITS))
    return bytes(int(bits[i : i + 8][::-1], 2) for i in range(0, size * 8, 8))


def test_published_vector():
    """It is vector 0 of eSTREAM's set 1, with the top bits of key and IV in s_80 and s_173."""
    expected = (
        "38EB86FF730D7A9CAF8DF13A4420540DBB7B651464C87501552041C249F29A64"
        "D2FBF515610921EBE06C8F92CECF7F8098FF20CCCC6A62B97BE8EF7454FC80F9"
    )
    assert keystream(Trivium(1 << 72, 0), 64) == bytes.fromhex(expected)


def trivium_by_bit(key, iv):
    """Yield bits of the cipher as its specification defines it, s_1 first."""
    s = [key >> i & 1 for i in range(80)] + [0] * 13
    s += [iv >> i & 1 for i in range(80)] + [0] * 4
    s += [0] * 108 + [1] * 3
    s.insert(0, None)  # Counted from 1.
    while True:
        t1, t2, t3 = s[66] ^ s[93], s[162] ^ s[177], s[243] ^ s[288]
        yield t1 ^ t2 ^ t3
        t1 ^= s[91] & s[92] ^ s[171]
        t2 ^= s[175] & s[176] ^ s[264]
        t3 ^= s[286] & s[287] ^ s[69]
        s[1:] = [t3, *s[1:93], t1, *s[94:177], t2, *s[178:288]]


@pytest.mark.parametrize(("key", "iv"), [(0, 0), ((1 << 80) - 1, 1), (0x0F1E2D3C4B5A69788796, 77)])
def test_matches_the_specification(key, iv):
    bits = trivium_by_bit(key, iv)
    for _ in range(4 * 288):
        next(bits)
    generator = Trivium(key, iv)
    for _ in range(20):
        word = 0
        for _ in range(WORD_BITS):
            word = word << 1 | next(bits)
        assert generator.step() == word


def bit(register, i):
    return register >> (i - 1) & 1


def step_back(state):
    """Undo a bit of the cipher, which shows that its update does not lose state."""
    a, b, c = state
    # The latest bit of a register, without the terms still present, is the bit that another lost.
    a_last = b & 1 ^ bit(a, 67) ^ bit(a, 92) & bit(a, 93) ^ bit(b, 79)
    b_last = c & 1 ^ bit(b, 70) ^ bit(b, 83) & bit(b, 84) ^ bit(c, 88)
    c_last = a & 1 ^ bit(c, 67) ^ bit(c, 110) & bit(c, 111) ^ bit(a, 70)
    return a >> 1 | a_last << 92, b >> 1 | b_last << 83, c >> 1 | c_last << 110


@settings(deadline=None)
@given(KEYS, KEYS)
def test_never_stuck(key, iv):
    """Every step can be undone back to the loaded state, which is not 0."""
    generator = Trivium(key, iv)
    state = generator.state
    generator.step()
    stepped = generator.state
    assert stepped != state
    for _ in range(WORD_BITS):
        stepped = step_back(stepped)
    assert stepped == state
    for _ in range(WARM_UP_STEPS * WORD_BITS):
        state = step_back(state)
    assert state == (key, iv, 0b111 << 108)


def test_lanes():
    """The seed is the key of every lane, the lane's number is its IV."""
    lanes = [Trivium(0xDEADBEEF, lane) for lane in range(LANES)]
    source = RandomSource(0xDEADBEEF)
    for _ in range(5):
        assert source.step() == tuple(lane.step() for lane in lanes)


def test_near_seeds_are_independent():
    """Half the bits differ between any two lanes of near seeds, starting with the first word."""
    words = [word for seed in range(64) for word in RandomSource(seed).step()]
    distances = [
        (first ^ second).bit_count() for i, first in enumerate(words) for second in words[:i]
    ]
    # 8128 pairs of 64 bits: 4 standard deviations of the mean; 6 of any one.
    assert abs(np.mean(distances) - 32) < 4 * 4 / np.sqrt(len(distances))
    assert 32 - 6 * 4 < min(distances) <= max(distances) < 32 + 6 * 4


@pytest.mark.parametrize("kind", [RandomSource, RandomStream])
@pytest.mark.parametrize("seed", [-1, 1 << 64])
def test_refuses_a_bad_seed(kind, seed):
    message = rf"^Seed must be from 0 to 2\*\*64 - 1, not {seed}$"
    with pytest.raises(ValueError, match=message):
        kind(seed)


# The first call compiles.
@settings(deadline=None)
@given(SEEDS, st.lists(st.integers(0, 12), max_size=4))
def test_stream_matches_source(seed, blocks):
    source, stream = RandomSource(seed), RandomStream(seed)
    for steps in blocks:
        words = stream.words(steps)
        assert words.shape == (steps, LANES)
        assert words.tolist() == [list(source.step()) for _ in range(steps)]


def test_stream_writes_the_words_in_port_order():
    size = 3 << 18
    with Started(
        [sys.executable, "-m", "pathgene.sim.model.random_stream", "--seed", "123"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=ROOT,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        written = process.stdout.read(size)
        process.stdout.close()
        complaint = process.stderr.read()
    source = RandomSource(123)
    expected = [word.to_bytes(8, "little") for _ in range(100) for word in source.step()]
    assert written[: 100 * LANES * 8] == b"".join(expected)
    assert written == RandomStream(123).words(size // (LANES * 8)).tobytes()
    # The reader closes the pipe, which is not an error.
    assert (process.returncode, complaint) == (0, b"")


def test_stream_refuses_a_bad_seed(capsys):
    with pytest.raises(SystemExit) as exit_info:
        main(["--seed", "-1"])
    assert exit_info.value.code == 2
    assert re.search(r"Seed must be from 0 to 2\*\*64 - 1, not -1\n$", capsys.readouterr().err)


@pytest.mark.parametrize("seed", [0, 1, 2**64 - 1])
def test_words_are_those_of_the_random_source(seed):
    words, expected = source(seed), RandomSource(seed)
    for _ in range(200):
        step(words)
        first, second = expected.step()
        assert (field(words, 0, 0, 32), field(words, 0, 32, 32)) == (
            first & 0xFFFFFFFF,
            first >> 32,
        )
        assert field(words, 1, 7, 9) == second >> 7 & 511
        assert draw(words, 1, 16, 24, 22) == (second >> 16 & 0xFFFFFF) * 22 >> 24


def test_seed_is_checked():
    with pytest.raises(ValueError, match=r"^Seed must be from 0 to 2\*\*64 - 1, not -1$"):
        source(-1)

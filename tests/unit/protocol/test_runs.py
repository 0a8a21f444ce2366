import random
import re

import pytest

from pathgene.hdl.protocol.runs import RunOptions, pack_best, run_request, unpack_best
from tests.support.gateware.chips import random_path
from tests.support.planner.cases import LARGE, SMALL, USUAL


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"seed": -1}, "RunOptions.seed must be from 0 to 2**64 - 1, not -1"),
        ({"cycles": -1}, "RunOptions.cycles must be from 0 to 2**32 - 1, not -1"),
        ({"generations": -1}, "RunOptions.generations must be from 0 to 2**32 - 1, not -1"),
        ({"give_up_rank": 32}, "RunOptions.give_up_rank must be a rank, not 32"),
        ({"slopes": ()}, "RunOptions.slopes must be one or two, not ()"),
        ({"slopes": (1, 2, 3)}, "RunOptions.slopes must be one or two, not (1, 2, 3)"),
        (
            {"slopes": (1, 2), "warm": True},
            "RunOptions.slopes must be at most one on a warm start, not (1, 2)",
        ),
        ({"slopes": (16,)}, "RunOptions.slopes must be from 0 to 15, not (16,)"),
        ({"slopes": (-1,)}, "RunOptions.slopes must be from 0 to 15, not (-1,)"),
        ({"seeds": 31}, "RunOptions.seeds must be from the population to 65535, not 31"),
        ({"lifts": 5}, "RunOptions.lifts must be from 0 to 4, not 5"),
        ({"share": 17}, "RunOptions.share must be from 0 to 16, not 17"),
        ({"paths": 0}, "RunOptions.paths must be from 1 to 8, not 0"),
        ({"paths": 9}, "RunOptions.paths must be from 1 to 8, not 9"),
        ({"memo": 1}, "RunOptions.memo must be 0, or a power of two up to 65536, not 1"),
        ({"memo": 24}, "RunOptions.memo must be 0, or a power of two up to 65536, not 24"),
    ],
)
def test_a_wrong_option_names_its_rule(options, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        RunOptions(**options).check(USUAL)


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
@pytest.mark.parametrize(
    ("slopes", "warm"), [((15,), False), ((0, 15), False), ((), True), ((7,), True)]
)
def test_options_come_back_as_they_were_packed(config, slopes, warm):
    sent = RunOptions(
        seed=(1 << 64) - 2, cycles=123_456_789, generations=(1 << 32) - 1, give_up_rank=5,
        until_feasible=not warm, slopes=slopes, seeds=65_535, lifts=3, share=16, warm=warm, paths=3,
    )  # fmt: skip
    payload = sent.pack(config)
    assert len(payload) == run_request(config).size
    assert RunOptions.unpack(config, payload) == sent


def test_options_out_of_range_are_refused_on_either_side():
    with pytest.raises(ValueError, match="seeds must be from the population to 65535, not 8"):
        RunOptions(seeds=8).pack(USUAL)
    fields = run_request(USUAL).unpack(RunOptions().pack(USUAL)) | {"seeds": 8}
    with pytest.raises(ValueError, match="seeds must be from the population to 65535, not 8"):
        RunOptions.unpack(USUAL, run_request(USUAL).pack(**fields))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"islands": 3}, "slopes must be at most 2, not 3"),
        ({"islands": 0}, "slopes must be one or two, not ()"),
        ({"islands": 2, "warm": 1}, "slopes must be at most one on a warm start, not (3, 0)"),
    ],
)
def test_a_number_of_islands_that_no_chip_has_is_refused(changes, sentence):
    fields = run_request(USUAL).unpack(RunOptions().pack(USUAL)) | changes
    with pytest.raises(ValueError, match=f"^{re.escape('RunOptions.' + sentence)}$"):
        RunOptions.unpack(USUAL, run_request(USUAL).pack(**fields))


def test_the_size_of_the_memo_is_not_sent():
    assert RunOptions.unpack(USUAL, RunOptions(memo=64).pack(USUAL)) == RunOptions()


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_best_paths_come_back_as_they_were_packed(config):
    rng = random.Random(21)
    for count in range(9):
        paths = [random_path(config, rng) for _ in range(count)]
        keys = [rng.randrange(1 << 30) for _ in paths]
        assert unpack_best(config, pack_best(config, paths, keys)) == (paths, keys)


def test_best_paths_that_end_early_are_refused():
    rng = random.Random(22)
    payload = pack_best(USUAL, [random_path(USUAL, rng)], [7])
    for size in range(1, len(payload)):
        with pytest.raises(ValueError, match="must"):
            unpack_best(USUAL, payload[:size])

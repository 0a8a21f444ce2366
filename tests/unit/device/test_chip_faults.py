"""The chip's client over a line with flipped, lost, inserted, repeated and merged bytes."""

import random

import pytest

from pathgene.hdl.config import Config
from pathgene.hdl.protocol import LinkMode
from pathgene.host.device.chip import Chip
from pathgene.host.device.link import Link
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.chip import ModelPort
from tests.support.gateware.faults import ByteFaults, FaultyTransport, VirtualClock


CONFIG = Config()
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

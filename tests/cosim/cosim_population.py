# amaranth: UnusedElaboratable=no
"""The exported population: host access, lock-step reading, updates, pending mutations."""

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge, RisingEdge
from cocotb.utils import get_sim_time
from drivers import Stream

from pathgene.hdl.config import CheckerBuild, Config, MutationKind
from pathgene.hdl.ga_core.population import Population
from pathgene.hdl.protocol.breeding import crossover


TOP = "population"
CONFIG = Config(checker=CheckerBuild.NONE)

UNIT = Population(CONFIG)
KEPT = CONFIG.elites + CONFIG.survivors
PORTS = KEPT + CONFIG.crossovers
CLOCK_NS = 10


class Bench:
    """Driver of the population, with the paths that it must contain."""

    def __init__(self, dut, seed, *, stalled=False):
        self.dut = dut
        self.rng = random.Random(seed)
        self.paths = [[0] * CONFIG.MIN_WAYPOINTS for _ in range(CONFIG.population)]
        self.streams = {}
        for name in ("writes", "reads", "read_waypoints"):
            layout = UNIT.signature.members[name].signature.members["payload"].shape
            stream = Stream(dut, name, layout, dut.clk)
            stream.idle(driven=name != "read_waypoints")
            if stalled:
                stream.pauses = lambda: self.rng.choice((0, 0, 1, 5))
            self.streams[name] = stream
        for name in ("launch", "update"):
            getattr(dut, name).value = 0
        dut.allow.value = 1
        for i in range(CONFIG.mutators):
            getattr(dut, f"mutations__{i}").value = 0

    async def reset(self):
        self.dut.rst.value = 1
        Clock(self.dut.clk, CLOCK_NS, unit="ns").start()
        await FallingEdge(self.dut.clk)
        self.dut.rst.value = 0

    def drive(self, name, index, value):
        layout = UNIT.signature.members[name].shape
        getattr(self.dut, f"{name}__{index}").value = layout.const(value).as_value().value

    async def load(self, slot):
        length = self.rng.randint(CONFIG.MIN_WAYPOINTS, CONFIG.max_waypoints)
        path = [self.rng.getrandbits(CONFIG.waypoint_bits) for _ in range(length)]
        self.paths[slot] = path
        await self.streams["writes"].put(
            *(
                {"slot": slot, "index": index, "waypoint": waypoint, "last": index == length - 1}
                for index, waypoint in enumerate(path)
            )
        )

    async def check(self, slot=0, count=CONFIG.population):
        await self.streams["reads"].put({"slot": slot, "count": count})
        paths = [[]]
        for word in await self.streams["read_waypoints"].get_until("final"):
            paths[-1].append(word.waypoint)
            if word.last:
                paths.append([])
        assert paths.pop() == []
        assert paths == self.paths[slot : slot + count]

    def mutate(self, children):
        """Draw a mutation for each mutator, apply it to ``children``, and drive it."""
        numbers = self.rng.sample(range(CONFIG.children), CONFIG.mutators)
        for i, (kind, child) in enumerate(zip(CONFIG.mutations, numbers, strict=True)):
            path = children[child]
            index = self.rng.randrange(len(path))
            applied = self.rng.random() < 0.9
            patch = self.rng.getrandbits(CONFIG.waypoint_bits)
            if kind is MutationKind.DELETE:
                applied &= len(path) > CONFIG.MIN_WAYPOINTS
            else:
                getattr(self.dut, f"patches__{i}").value = patch
            if kind is MutationKind.INSERT:
                applied &= len(path) < CONFIG.max_waypoints
            self.drive("mutations", i, {"applied": applied, "child": child, "index": index})
            if applied:
                match kind:
                    case MutationKind.PERTURB:
                        path[index] = patch
                    case MutationKind.INSERT:
                        path.insert(index + 1, patch)
                    case MutationKind.DELETE:
                        del path[index]

    async def generation(self):
        """Breed, mutate and update; any port may read any slot."""
        dut = self.dut
        carried = self.rng.choices(range(CONFIG.population), k=PORTS)
        for port, slot in enumerate(carried):
            length = len(self.paths[slot])
            self.drive("carried", port, {"slot": slot, "length": length, "select": 1 << slot})
        for _ in range(3):
            await FallingEdge(dut.clk)
        if not dut.settled.value:
            await RisingEdge(dut.settled)
            await FallingEdge(dut.clk)
        dut.allow.value = 0
        dut.launch.value = 1
        await FallingEdge(dut.clk)
        dut.launch.value = 0
        await FallingEdge(dut.clk)
        begun = get_sim_time("ns")
        await RisingEdge(dut.done)
        await FallingEdge(dut.clk)
        paths = [self.paths[slot] for slot in carried]
        assert get_sim_time("ns") - begun == CLOCK_NS * max(map(len, paths))
        await FallingEdge(dut.clk)

        children = crossover(paths[KEPT:])
        self.mutate(children)
        await FallingEdge(dut.clk)
        dut.update.value = 1
        await FallingEdge(dut.clk)
        dut.update.value = 0
        dut.allow.value = 1
        self.paths = [list(path) for path in paths[:KEPT]] + children
        for slot, path in enumerate(self.paths):
            assert getattr(dut, f"lengths__{slot}").value.to_unsigned() == len(path)


@cocotb.test()
@cocotb.parametrize(stalled=[False, True])
async def generations(dut, stalled):
    """Update, with loads and reads between the generations."""
    bench = Bench(dut, seed=1, stalled=stalled)
    await bench.reset()
    if not stalled:
        # A reset does not clear the memories, so this checks their contents at power-up.
        await bench.check()
    for slot in bench.rng.sample(range(CONFIG.population), CONFIG.population):
        await bench.load(slot)
    await bench.check()
    for number in range(30):
        await bench.generation()
        slot = bench.rng.randrange(CONFIG.population)
        await bench.load(slot)
        await bench.check(slot, 1)
        if number % 3 == 2:
            await bench.check()


@cocotb.test()
async def generations_in_a_row(dut):
    """Mutate mutated paths that are copied or bred again before they are read."""
    bench = Bench(dut, seed=2)
    await bench.reset()
    for slot in range(CONFIG.population):
        await bench.load(slot)
    for _ in range(10):
        for _ in range(6):
            await bench.generation()
        await bench.check()

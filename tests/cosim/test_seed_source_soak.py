"""The exported source of seeds in Verilator, compared with the definition."""

import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from pathgene.hdl.planner.layouts import frame_layout, problem_layout
from pathgene.hdl.planner.wavefront.layouts import block_layout, found_layout, place_layout
from pathgene.hdl.protocol.planner import BLOCKS, FAR
from pathgene.sim.cache import BuildCache, build_root
from pathgene.sim.exported import exported_verilog
from pathgene.sim.model.planner import run_cycles
from pathgene.sim.model.planner.definition import wavefront
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.verilator import build_verilator
from tests.support.planner.cases import LARGE, SMALL, USUAL
from tests.support.planner.plain import seed_path
from tests.support.planner.wavefront import Words, blocks_of, corner, layer, problem, terrain


pytestmark = [pytest.mark.cosim, pytest.mark.ci]

MAIN = Path(__file__).with_name("seed_source_soak.cpp")


@dataclass
class Job:
    """A run of the source: on a new map or the previous one, with corners written first."""

    problem: object
    ground: np.ndarray
    is_new: bool
    written: np.ndarray
    limit: int
    paths: int
    by_turns: bool
    pause: int
    marked: int


def words(value, count):
    """Return an integer as 32-bit words, the lowest first."""
    return [value >> 32 * i & 0xFFFFFFFF for i in range(count)]


def frame_words(config, record):
    """Return start and goal in the frame, as the words of its port: at least two."""
    layout = frame_layout(config.coordinate_bits, config.altitude_bits)
    ends = {end: corner(*corner_of(record, end)) for end in ("start", "goal")}
    return words(layout.const(ends).as_bits(), max(-(-layout.size // 32), 2))


def packed(config, job, drawn):
    """Return a job in the form that the program reads."""
    record = problem_layout(config)
    fields = words(record.const(vars(job.problem)).as_bits(), -(-record.size // 32))
    written = [(x, y, job.ground[y, x]) for x, y in job.written.tolist()]
    head = [job.is_new, len(written), 1, job.limit, job.paths, len(drawn), job.pause, job.by_turns]
    parts = [head, fields, frame_words(config, job.problem)]
    if job.is_new:
        parts.append(job.ground.ravel())
    parts += [np.array(written).ravel(), [word & (1 << 19) - 1 for word in drawn]]
    return np.concatenate([np.asarray(part, dtype=np.uint32) for part in parts]).tobytes()


def program(config, folder):
    """Return the program of a chip: the C++ text and the sizes it asks for."""
    inner = "seed_source__DOT__"
    defines = {
        "SIZE": config.map_size,
        "LANES": config.lanes,
        "LATENCY": config.lookup_latency,
        "MOST_TURNS": config.max_waypoints,
        "COORDINATE_BITS": config.coordinate_bits,
        "SET_CORNERS": "".join(
            f"chip.corners___05F{lane} = corners[{lane}];" for lane in range(config.lanes)
        ),
        "LENGTH": inner + "route__DOT__length",
        "RECORDS": inner + "blocks__DOT__records",
        "SURFACES": inner + "wavefront__DOT__surfaces",
        "COSTS": inner + "wavefront__DOT__costs",
        "PLACES": inner + "route__DOT__places",
        "TURNS": inner + "route__DOT__turns",
        "STORED_TURNS": inner + "route__DOT__stored_turns",
    }
    text = MAIN.read_text()
    main = folder / "main.cpp"
    main.write_text("".join(f"#define {name} {value}\n" for name, value in defines.items()) + text)
    return build_verilator(
        BuildCache(build_root() / "sim"),
        exported_verilog("seed_source", config),
        "seed_source",
        main=main,
        verilate_args=["--public-flat-rw"],
    )


def drawn_jobs(config, rng, maps, runs, most_shift):
    """Return jobs: several runs per map, usually after writes of neighbouring corners."""
    size, jobs = config.map_size, []
    for _ in range(maps):
        share = float(rng.choice([0, 0.0005, 0.01, 0.2]))
        ground, scanned = terrain(config, rng, blocked=share), None
        for run in range(runs):
            if run == 0 or rng.random() < 0.4:
                shift = int(rng.integers(most_shift + 1))
                record = problem(config, rng, shift=shift, any_field=rng.random() < 0.3)
            ground = ground.copy()
            corners = np.zeros((0, 2), dtype=int)
            if run and rng.random() < 0.7:
                span = min(size, 1 << int(rng.integers(2, 7)))
                corner = rng.integers(size - span + 1, size=2)
                corners = corner + rng.integers(span, size=(int(rng.integers(1, 100)), 2))
                kinds = rng.integers(3, size=len(corners))
                heights = rng.integers(config.blocked_altitude + 1, size=len(corners))
                heights[kinds == 0] = config.blocked_altitude
                ground[corners[:, 1], corners[:, 0]] = heights
            marked = {
                tuple(each)
                for each in (corners >> record.block_shift).tolist()
                if max(each) < record.blocks
            }
            jobs.append(
                Job(
                    problem=record,
                    ground=ground,
                    is_new=run == 0,
                    written=corners,
                    limit=int(rng.choice([0, 1, 3, 5, 15])),
                    paths=int(rng.integers(1, 40)),
                    by_turns=bool(rng.integers(2)),
                    pause=int(rng.choice([0, 2, 4])),
                    marked=len(marked) if blocks_in(record) == scanned else record.blocks**2,
                )
            )
            scanned = blocks_in(record)
    return jobs


def blocks_in(record):
    """Return the size of blocks and their number: another one marks all."""
    return record.block_shift, record.blocks


@dataclass
class Expected:
    """Findings of the definition, and the random words that it takes."""

    blocks: object
    surface: dict
    passes: tuple
    field: dict
    route: list
    turns: list
    paths: list
    words: list


def expected_of(config, job, rng):
    blocks = blocks_of(config, job.problem, job.ground)
    surface, limit_passes = dict(blocks.least), 0
    if job.limit:
        limit_passes = wavefront.limit_slopes(job.problem, blocks, surface, job.limit)
    prices = wavefront.prices_of(config, job.problem, blocks.distances)
    field, passes = wavefront.spread(prices, blocks, surface)
    route = wavefront.descend(prices, blocks, surface, field)
    turns = wavefront.turns_of(route) if blocks.start in field else []
    follows = job.by_turns and config.MIN_WAYPOINTS <= len(turns) <= config.max_waypoints
    source = Words(rng)
    paths = [
        seed_path(config, job.problem, blocks, surface, route, source, turns if follows else ())
        for _ in range(job.paths)
    ]
    passes = limit_passes, passes
    return Expected(blocks, surface, passes, field, route, turns, paths, source.taken)


def used(rows, edge):
    """Return the rows of the blocks that the problem uses."""
    rows = rows.reshape(BLOCKS, BLOCKS, *rows.shape[1:])[:edge, :edge]
    return rows.reshape(edge * edge, *rows.shape[2:])


def check(config, job, expected, raw):
    """Compare a job's words with the expected ones; return the remaining words."""
    z = config.altitude_bits
    scanned, ran, seeded, passes, length, bends, waypoints, taken = raw[:8].tolist()
    raw = raw[8:]
    most = config.max_waypoints
    sizes = 2 * BLOCKS**2, BLOCKS**2, BLOCKS**2, length, most, 2 * waypoints
    records, surface, costs, places, turns, points = np.split(
        raw[: sum(sizes)], np.cumsum(sizes)[:-1]
    )
    edge = job.problem.blocks
    records = used(records.reshape(-1, 2), edge)
    surface, costs = used(surface, edge), used(costs, edge)

    layout = block_layout(config.coordinate_bits, z)
    found = [layout.from_bits(low | high << 32) for low, high in records.tolist()]
    blocks, record = expected.blocks, job.problem
    assert [(each.x, each.y) for each in found] == layer(blocks.lowest, None, edge)
    ends = {blocks.start, blocks.goal}
    for each, (place, lowest) in zip(
        found, sorted(blocks.lowest.items(), key=lambda item: item[0][::-1]), strict=True
    ):
        if each.free:
            assert each.altitude == blocks.least[place] == job.ground[lowest[::-1]]
        else:
            assert place not in blocks.least or place in ends

    free = [altitude is not None for altitude in layer(expected.surface, None, edge)]
    assert (surface & 1).tolist() == free
    assert (surface >> 1).tolist() == layer(expected.surface, 0, edge)
    assert costs.tolist() == layer(expected.field, FAR, edge)
    assert passes == sum(expected.passes)
    assert bends == min(len(expected.turns), most + 1)
    kept = turns[: min(bends, most)]
    for found, blocks_of_route in ((places, expected.route), (kept, expected.turns[:most])):
        assert [place_layout.from_bits(bits) for bits in found.tolist()] == [
            place_layout.const({"x": x, "y": y}) for x, y in blocks_of_route
        ]
    assert taken == len(expected.words)
    layout = found_layout(config.coordinate_bits, z)
    points = [layout.from_bits(low | high << 32) for low, high in points.reshape(-1, 2).tolist()]
    assert [(each.x, each.y, each.altitude, each.last) for each in points] == [
        (*waypoint[:3], i == len(path) - 1)
        for path in expected.paths
        for i, waypoint in enumerate(path)
    ]

    assert scanned == run_cycles.scanned(
        edge, job.marked, record.block_shift, config.lanes, config.lookup_latency
    )
    is_straight = blocks.start not in expected.field
    assert ran == run_cycles.launched(edge, *expected.passes, length, is_straight)
    if job.pause == 0:
        assert seeded == sum(run_cycles.seeded(len(path)) for path in expected.paths)
    return raw[sum(sizes) :]


@pytest.mark.parametrize(
    ("config", "maps", "runs", "most_shift"),
    [
        pytest.param(SMALL, 10, 5, 0, marks=pytest.mark.long),
        (USUAL, 4, 5, 4),
        pytest.param(LARGE, 1, 4, 3, marks=pytest.mark.long),
        pytest.param(SMALL, 400, 5, 0, marks=pytest.mark.long),
        pytest.param(USUAL, 100, 8, 4, marks=pytest.mark.long),
        pytest.param(LARGE, 2, 8, 7, marks=pytest.mark.long),
    ],
    ids=["small", "usual", "large", "long-small", "long-usual", "long-large"],
)
def test_matches_the_definition(tmp_path, config, maps, runs, most_shift):
    rng = np.random.default_rng(maps)
    jobs = drawn_jobs(config, rng, maps, runs, most_shift)
    expected = [expected_of(config, job, rng) for job in jobs]
    data = b"".join(
        packed(config, job, each.words) for job, each in zip(jobs, expected, strict=True)
    )
    done = subprocess.run(
        [program(config, tmp_path)], input=data, stdout=subprocess.PIPE, check=True
    )
    raw = np.frombuffer(done.stdout, dtype=np.uint32)
    for job, each in zip(jobs, expected, strict=True):
        raw = check(config, job, each, raw)
    assert raw.size == 0
    # Routes of both kinds are among them, and scans of a few blocks; one large map is too few.
    reached = [each.blocks.start in each.field for each in expected]
    if maps > 1:
        assert any(
            job.by_turns and len(each.turns) > 1 for job, each in zip(jobs, expected, strict=True)
        )
        assert any(reached)
        assert not all(reached)
        assert any(0 < job.marked < 100 for job in jobs)

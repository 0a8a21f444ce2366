"""Command receiver: the commands of the planner core, intact or broken."""

import dataclasses
from functools import partial

import numpy as np
import pytest

from pathgene.hdl.command.layouts import AnswerKind
from pathgene.hdl.protocol.codec import FrameSplitter, decode_frame, encode_frame
from pathgene.hdl.protocol.codes import Command, Status, StickyError
from pathgene.hdl.protocol.messages import coded_map_request, map_request
from pathgene.hdl.protocol.paths import pack_cells
from pathgene.hdl.protocol.planner import EDGES, NoFlyShape, no_fly_request, problem_request
from pathgene.hdl.protocol.runs import RunOptions, guide_request, run_request
from pathgene.sim.model.chip import Chip as ChipModel
from pathgene.sim.model.requests import FrameReceiverModel
from tests.support.gateware.fuzz import Fuzz
from tests.support.gateware.refusals import run_refusals
from tests.support.planner.cases import LARGE, SMALL, USUAL, any_record, headed, record, shape
from tests.unit.command.receiver_bench import Chip, after_open, refuse


RNG = np.random.default_rng(3)
PROBLEM = record(SMALL, RNG)
SHAPE = shape(SMALL, RNG)
OPTIONS = RunOptions(seed=0x0123456789ABCDEF, give_up_rank=7, seeds=500, slopes=(15, 2))
WARM = dataclasses.replace(OPTIONS, slopes=(), warm=True)
CELLS = map_request(SMALL).pack(x=3, y=4, width=2, height=1) + pack_cells(SMALL, [5, 6])
GUIDE = guide_request(SMALL).pack(index=2, x=6, y=7, altitude=8)
CODED = coded_map_request(SMALL).pack(x=3, y=4, width=2, height=2, remainder_bits=1) + b"\0"
BUSY = (
    Command.MAP,
    Command.PROBLEM,
    Command.RUN,
    Command.BEST,
    Command.BLOCK,
    Command.GUIDE,
    Command.CODED_MAP,
)
PAYLOADS = {
    Command.MAP: CELLS,
    Command.PROBLEM: PROBLEM.pack(SMALL),
    Command.RUN: OPTIONS.pack(SMALL),
    Command.BLOCK: SHAPE.pack(SMALL),
    Command.GUIDE: GUIDE,
    Command.CODED_MAP: CODED,
}


def bits_of(payload, layout):
    """Return the fields of a transferred payload as fields of the request."""
    return {name: payload[name] % (1 << width) for name, width in layout.fields}


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
@pytest.mark.parametrize("pauses", [(0,), (0, 30, 11)], ids=["steady", "stalled"])
def test_every_command(config, pauses):
    rng = np.random.default_rng(4)
    problem, block = headed(config, rng, any_record(config, rng)), shape(config, rng)
    options = dataclasses.replace(OPTIONS, warm=True, slopes=(7,), lifts=4, share=16, paths=1)
    options = dataclasses.replace(options, guided=config.max_waypoints)
    guide = guide_request(config)
    waypoint = {"index": config.max_waypoints - 1, "x": 3, "y": 4, "altitude": 9}
    chip = Chip(pauses, config)
    chip.has_population = 1
    outcomes = chip.run(
        after_open(
            (Command.MAP, map_request(config).pack(x=3, y=4, width=1, height=1) + bytes(2))
            if config.altitude_bits > 8
            else (Command.MAP, CELLS),
            (Command.PROBLEM, problem.pack(config)),
            (Command.BLOCK, block.pack(config)),
            (Command.RUN, options.pack(config)),
            (Command.STATUS, b""),
            (Command.STOP, b""),
            (Command.BEST, b""),
            (Command.COUNTERS, b""),
            (Command.CLEAR, b""),
            (Command.GUIDE, guide.pack(**waypoint)),
        )
    )
    assert outcomes == [
        (Status.OK, AnswerKind.EMPTY, 9, 0),
        (Status.OK, AnswerKind.EMPTY, 0, 0),
        (Status.OK, AnswerKind.EMPTY, 1, 0),
        (Status.OK, AnswerKind.EMPTY, 2, 0),
        (Status.OK, AnswerKind.EMPTY, 3, 0),
        (Status.OK, AnswerKind.STATUS, 4, 0),
        (Status.OK, AnswerKind.EMPTY, 5, 0),
        (Status.OK, AnswerKind.BEST, 6, 0),
        (Status.OK, AnswerKind.COUNTERS, 7, 0),
        (Status.OK, AnswerKind.EMPTY, 8, 0),
        (Status.OK, AnswerKind.EMPTY, 9, 0),
    ]
    assert [(cell.x, cell.y) for cell in chip.cells[:1]] == [(3, 4)]
    [told] = chip.problems
    assert {name: told[name] for name, _ in told.shape()} == dataclasses.asdict(problem)
    [told], layout = chip.shapes, no_fly_request(config)
    assert bits_of(told, layout) == layout.unpack(block.pack(config))
    edges = [[told[f"{name}_{i}"] for name in ("at", "east", "north")] for i in range(EDGES)]
    assert edges == [list(edge) for edge in NoFlyShape.unpack(config, block.pack(config)).edges]
    [told], layout = chip.runs, run_request(config)
    assert bits_of(told, layout) == layout.unpack(options.pack(config))
    [told] = chip.guides
    assert bits_of(told, guide) == waypoint
    assert (chip.stops, chip.errors) == (1, StickyError(0))


def test_cycles():
    """A request is refused or executed at most 6 cycles after its last byte."""
    chip = Chip(config=SMALL)
    chip.run(
        after_open(
            (Command.STOP, b""),
            (Command.BEST, b""),
            *(
                (code, PAYLOADS[code])
                for code in (Command.PROBLEM, Command.RUN, Command.BLOCK, Command.GUIDE)
            ),
            (Command.RUN, WARM.pack(SMALL)),
        )
    )
    assert chip.cycles == 6


@pytest.mark.parametrize("config", [SMALL, USUAL, LARGE], ids=["small", "usual", "large"])
def test_refused(config):
    """Only the values differ between the chips."""
    rows = run_refusals(config)
    if config is not SMALL:
        rows = [row for row in rows if row[-1] == Status.BAD_VALUE]
    chip = refuse(config, rows)
    assert (chip.problems, chip.runs, chip.shapes, chip.cells) == ([], [], [], [])
    assert (chip.guides, chip.stops) == ([], 0)


@pytest.mark.parametrize("code", BUSY, ids=lambda code: code.name)
def test_while_a_run_goes_on_its_end_must_come_first(code):
    chip = Chip(config=SMALL)
    chip.running = 1
    payload = PAYLOADS.get(code, b"")
    outcomes = chip.run(after_open((code, payload)))
    assert outcomes[1:] == [(Status.BUSY, AnswerKind.EMPTY, 0, 0)]
    assert chip.errors == StickyError.REFUSED
    assert (chip.problems, chip.runs, chip.shapes, chip.cells) == ([], [], [], [])


def test_while_a_run_goes_on_other_commands_are_answered():
    chip = Chip(config=SMALL)
    chip.running = 1
    outcomes = chip.run(
        [
            (bytes((77, 5, Command.INFO)), 1),
            *after_open(
                (Command.STATUS, b""), (Command.COUNTERS, b""), (Command.CLEAR, b""),
                (Command.STOP, b""),
            ),
        ]
    )  # fmt: skip
    assert {status for status, *_ in outcomes} == {Status.OK}
    assert (chip.stops, chip.errors) == (1, StickyError(0))


def test_a_length_counts_before_a_run_and_a_run_before_values():
    chip = Chip(config=SMALL)
    chip.running, chip.has_problem = 1, 0
    bodies = after_open((Command.RUN, OPTIONS.pack(SMALL)))
    bodies.append((bytes((1, 0, Command.RUN)) + OPTIONS.pack(SMALL)[:-1], 0))
    bodies.append((bytes((1, 0, Command.RUN)) + OPTIONS.pack(SMALL) + b"\0", 0))
    assert [status for status, *_ in chip.run(bodies)[1:]] == [
        Status.BUSY, Status.BAD_LENGTH, Status.BAD_LENGTH,
    ]  # fmt: skip


def test_a_run_needs_a_problem_and_a_warm_one_a_population():
    for warm, has_problem, has_population, status in (
        (False, 0, 0, Status.BAD_VALUE),
        (False, 0, 1, Status.BAD_VALUE),
        (False, 1, 0, Status.OK),
        (True, 1, 0, Status.BAD_VALUE),
        (True, 0, 1, Status.BAD_VALUE),
        (True, 1, 1, Status.OK),
    ):
        chip = Chip(config=SMALL)
        chip.has_problem, chip.has_population = has_problem, has_population
        options = WARM if warm else OPTIONS
        assert chip.run(after_open((Command.RUN, options.pack(SMALL))))[1][0] == status
        assert len(chip.runs) == (status == Status.OK)


def test_repeated_commands_change_nothing():
    """A RUN is repeated during its run, whatever the state of the population."""
    bodies = [(bytes((1, 0, Command.OPEN)), 0)]
    commands = [(Command.STOP, b""), (Command.BEST, b""), *PAYLOADS.items()]
    for sequence, (code, payload) in enumerate(commands):
        bodies += [(bytes((1, sequence, code)) + payload, 0)] * 2
    chip = Chip(config=SMALL)
    outcomes = chip.run(bodies)
    assert {status for status, *_ in outcomes} == {Status.OK}
    assert [outcome[1] for outcome in outcomes[3:5]] == [AnswerKind.BEST] * 2
    assert [len(each) for each in (chip.problems, chip.runs, chip.shapes, chip.cells)] == [
        1, 1, 1, 6,
    ]  # fmt: skip
    assert chip.stops == 1

    chip = Chip(config=SMALL)
    chip.running, chip.has_problem = 1, 0
    again = [(bytes((1, 255, Command.RUN)) + WARM.pack(SMALL), 0)]
    again.append((bytes((1, 255, Command.BEST)), 0))
    outcomes = chip.run([(bytes((1, 9, Command.OPEN)), 0), *again])
    assert outcomes[1:] == [
        (Status.OK, AnswerKind.EMPTY, 255, 0),
        (Status.BUSY, AnswerKind.EMPTY, 255, 0),
    ]
    assert chip.runs == []


def test_lacks_the_hardware_of_checks():
    unit = Chip(config=SMALL).unit
    assert not {"points", "checks", "check", "forget", "start_requests"} & set(
        unit.signature.members
    )


class Reference:
    """The model, and the requests that reach its core."""

    def __init__(self):
        self.model = ChipModel(SMALL)
        self.reached = {code: [] for code in (*PAYLOADS, Command.STOP)}
        for code in (*self.reached.keys() - {Command.MAP},):
            self.model._commands[code] = partial(self._execute, code, self.model._commands[code])
        self._mark = self.model.checking.terrain.observer
        self.model.checking.terrain.observer = self._write

    @property
    def state(self):
        """Inputs of the receiver that describe the core's state."""
        running = self.model.running
        return {
            "has_problem": running.record is not None,
            "has_population": len(running.latest.population) > 0,
        }

    def _execute(self, code, execute, payload, repeated):
        reply = execute(payload, repeated)
        if not repeated:
            self.reached[code].append(payload)
        return reply

    def _write(self, x, y, columns, rows):
        heights = self.model.checking.terrain.heights
        self.reached[Command.MAP] += [
            (x + u, y + v, int(heights[y + v, x + u])) for v in range(rows) for u in range(columns)
        ]
        self._mark(x, y, columns, rows)

    def ask(self, body, plain):
        """Return the status and sequence of the answer, if there is one."""
        answers = FrameSplitter().feed(self.model.feed(encode_frame(body, plain=plain)))
        return [(Status(answer[2]), answer[1]) for answer, _ in map(decode_frame, answers)]


@pytest.mark.ci
@pytest.mark.parametrize("pauses", [(0,), (0, 5, 1)], ids=["steady", "stalled"])
def test_random_requests(pauses):
    """Match the model's statuses, and the requests that reach its core."""
    fuzz, receiver, reference = Fuzz(SMALL, seed=6), FrameReceiverModel(SMALL), Reference()
    bodies, states, expected = [], [], []
    while fuzz.frames < 300:
        for body, plain in receiver.feed(fuzz.batch()[0]):
            states.append(reference.state)
            bodies.append((body, plain))
            expected += reference.ask(body, plain)
    chip = Chip(pauses, SMALL)
    outcomes = chip.run(bodies, states=states)
    assert expected == [
        (status, sequence) for status, kind, sequence, _ in outcomes if kind != AnswerKind.SILENCE
    ]
    reached = reference.reached
    assert [(cell.x, cell.y, cell.altitude) for cell in chip.cells] == reached[Command.MAP]
    for code, told, layout in (
        (Command.PROBLEM, chip.problems, problem_request(SMALL)),
        (Command.RUN, chip.runs, run_request(SMALL)),
        (Command.BLOCK, chip.shapes, no_fly_request(SMALL)),
        (Command.GUIDE, chip.guides, guide_request(SMALL)),
    ):
        assert len(told) > 5
        assert [bits_of(each, layout) for each in told] == [
            layout.unpack(payload) for payload in reached[code]
        ]
    assert chip.stops == len(reached[Command.STOP]) > 5
    assert all(fuzz.statuses[status] for status in Status if status is not Status.BUSY)

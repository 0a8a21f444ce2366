"""Kernels of the planner core's model for tuples and lists, and runs without a compiler."""

import os
import pickle
import subprocess
import sys
from bisect import bisect_right
from typing import NamedTuple
from unittest import mock

import numpy as np

from pathgene.hdl.protocol.planner import BLOCKS
from pathgene.hdl.protocol.random_words import LANES
from pathgene.sim.model.planner import breeder, random_words, seeds, walk
from pathgene.sim.model.planner.course import (
    Course,
    Members,
    Route,
    Scratch,
    problem_vector,
    sizes_vector,
)
from pathgene.sim.model.planner.cycles import WALK, counters_vector, delays_vector
from pathgene.sim.model.planner.definition.score import corner_of
from pathgene.sim.model.planner.evaluation import evaluate
from pathgene.sim.model.planner.random_words import WORD
from pathgene.sim.model.planner.score import WORK_ROWS
from pathgene.sim.model.run_commands import block


_INTERPRETED = """
import pickle, sys
from pathgene.sim.model.planner.run import plan
arguments, options = pickle.load(sys.stdin.buffer)
pickle.dump(plan(*arguments, **options), sys.stdout.buffer)
"""


class Waypoint(NamedTuple):
    """A waypoint: corner, altitude step, margin."""

    x: int
    y: int
    z: int
    margin: int = 0


def bits(word, low, width):
    """Return bits ``low`` to ``low + width - 1`` of a word."""
    return word >> low & (1 << width) - 1


def draw(word, low, width, limit):
    """Return a draw below ``limit`` from bits of a word."""
    return bits(word, low, width) * limit >> width


def interpreted_plan(*arguments, **options):
    """Return the outcome of a plan by the same kernels, interpreted."""
    done = subprocess.run(
        [sys.executable, "-c", _INTERPRETED],
        input=pickle.dumps((arguments, options)),
        stdout=subprocess.PIPE,
        check=True,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
    )
    return pickle.loads(done.stdout)


def _words(selection=0, mutation=0):
    words = np.zeros((LANES, 7), dtype=np.uint64)
    words[:2, WORD] = selection, mutation
    return words


def _with_words_of(source, kernel, *arguments):
    """Run a kernel's Python function on the words of ``source``, any object with ``step``."""

    def step(words):
        words[:2, WORD] = source.step()

    with mock.patch.object(sys.modules[kernel.__module__], "step", step):
        return kernel.py_func(*arguments)


def _write(points, path):
    """Write points, with margins or without, to the rows of a path; return their number."""
    for row, point in zip(path, points, strict=False):
        row[: len(point)] = point
    return len(points)


def breed(config, record, ends, paths, source):
    """Return the children of sorted ``paths``, and the ranks of the survivors.

    ``source`` is an object with ``step``, or the seed of the compiled source.
    """
    slots = config.population + config.children
    shape = slots, config.max_waypoints + 2, 4
    members = Members(
        np.zeros(shape, dtype=np.int64),
        np.zeros(slots, dtype=np.int64),
        np.zeros(slots, dtype=np.int64),
        np.arange(slots + 1),
    )
    for slot, path in enumerate(paths):
        members.points[slot] = _write([ends[0], *path, ends[1]], members.paths[slot])
    ground = np.zeros((1, 1), dtype=np.uint16)
    course = Course(problem_vector(config, record), sizes_vector(config, 0), ground)
    free = np.arange(config.population, slots)
    survivors, others = (np.zeros(slots, dtype=np.int64) for _ in range(2))
    arguments = course, members, free, survivors, others
    if isinstance(source, int):
        breeder.breed(*arguments, random_words.source(source))
    else:
        _with_words_of(source, breeder.breed, *arguments, _words())
    children = [
        [Waypoint(*row) for row in members.paths[slot, 1 : members.points[slot] - 1].tolist()]
        for slot in free
    ]
    return children, survivors[: config.survivors].tolist()


def cross(head, tail, word):
    """Return the head of one sequence and the tail of another, cut as specified by the word."""
    items = [*head, *tail]
    numbers = iter(range(len(items)))
    parents = []
    for parent in (head, tail):
        rows = np.full((len(parent) + 2, 4), -1, dtype=np.int64)
        rows[1:-1, 0] = [next(numbers) for _ in parent]
        parents += [rows, len(rows)]
    child = np.zeros((len(items) + 2, 4), dtype=np.int64)
    length = breeder.cross(*parents, child, 2 * bits(word, *breeder.CUT) + 1)
    return [items[number] for number in child[1 : length - 1, 0]]


def mutate(config, record, ends, path, word):
    """Return ``path`` after the mutation of ``word``."""
    rows = np.zeros((config.max_waypoints + 2, 4), dtype=np.int64)
    points = _write([ends[0], *path, ends[1]], rows)
    vectors = problem_vector(config, record), sizes_vector(config, 0)
    points = breeder.mutate(*vectors, rows, points, _words(0, word))
    return [Waypoint(*row) for row in rows[1 : points - 1].tolist()]


def seed_path(config, record, blocks, surface, route, source, turns=(), guide=()):
    """Return a seed along ``route``; blocks are keys x, y of ``blocks.lowest`` and ``surface``.

    If there are ``turns``, its waypoints are there; if there is a ``guide``, above its waypoints.
    """
    size = BLOCKS
    layers = np.zeros((3, size, size), dtype=np.int64)
    heights = np.full((size, size), -1, dtype=np.int64)
    for (x, y), lowest in blocks.lowest.items():
        layers[[seeds.LOWEST_X, seeds.LOWEST_Y], y, x] = lowest
    for (x, y), height in surface.items():
        heights[y, x] = height
    path = np.zeros((config.max_waypoints + 2, 4), dtype=np.int64)
    course = Course(
        problem_vector(config, record),
        sizes_vector(config, 0),
        np.zeros((1, 1), dtype=np.uint16),
    )
    rows = [np.array(each, dtype=np.int64).reshape(-1, 2) for each in (route, turns)]
    guided = np.array(guide, dtype=np.int64).reshape(-1, 3)
    way = Route(layers, heights, rows[0], len(route), rows[1], len(turns), guided, len(guide))
    ends = np.zeros(6, dtype=np.int64)
    points = _with_words_of(source, seeds.seed_path, course, ends, way, _words(), path)
    return [Waypoint(*row) for row in path[1 : points - 1].tolist()]


def drawn(shape):
    """Return the corners in ``shape``, by rows."""
    size = max(shape.last_x, shape.last_y) + 1
    ground = np.zeros((size, size), dtype=np.uint16)
    block(ground, 1, shape)
    return [(x, y) for y, x in np.argwhere(ground).tolist()]


class Memo:
    """Memo of segments: hits and margins of previously walked segments, by their ends.

    Parameters
    ----------
    size : int
        Segments: 0, or a power of two.
    """

    def __init__(self, config, size):
        self._bits = config.coordinate_bits
        self._width = max(size.bit_length() - 1, 0)
        self.rows = walk.empty_memo(size)

    def get(self, start, stop):
        """Return hits and margin of a segment, or None."""
        row, ends = self._place(start, stop)
        if row == walk.NO_ROW or self.rows[row, [walk.START, walk.STOP]].tolist() != ends:
            return None
        return tuple(self.rows[row, [walk.HITS, walk.MARGIN]].tolist())

    def put(self, start, stop, walked):
        """Store the hits and margin of a segment."""
        row, ends = self._place(start, stop)
        if row != walk.NO_ROW:
            self.rows[row, [walk.START, walk.STOP, walk.HITS, walk.MARGIN]] = *ends, *walked

    def _place(self, start, stop):
        ends = [walk.packed(self._bits, *end) for end in (start, stop)]
        return walk.row_of(len(self.rows), self._width, *ends), ends


class Evaluator:
    """Evaluation of paths over one map, with a memo of ``rows``.

    Attributes
    ----------
    ends : (Point, Point)
        Corners of start and goal.
    walk : int
        Cycles of the walker.
    """

    def __init__(self, config, record, ground, rows):
        self.config, self.record, self.ground = config, record, ground
        self.ends = corner_of(record, "start"), corner_of(record, "goal")
        self._course = Course(problem_vector(config, record), sizes_vector(config, rows), ground)
        # One work space for all paths, as in a run, with remains of earlier paths.
        work = np.full((WORK_ROWS, config.max_waypoints + 4), 1 << 40, dtype=np.int64)
        memory = walk.empty_memo(rows)
        self._scratch = Scratch(memory, delays_vector(config), counters_vector(), work)

    @property
    def walk(self):
        """Return the cycles of the walker."""
        return int(self._scratch.counters[WALK])

    def evaluate(self, path, margins, limit, *, first):
        """Return the key of ``path``, including its ends; write its margins if it is walked."""
        rows = np.zeros((len(path), 4), dtype=np.int64)
        rows[:, :3] = path
        # Not a margin of a walk: marks a path that is not walked.
        rows[:, 3] = unknown = 1 << 40
        key = int(evaluate(self._course, self._scratch, rows, len(path), limit, first))
        for at in range(1, len(path) - 1):
            if rows[at, 3] != unknown:
                margins[at] = int(rows[at, 3])
        return key


class Sorting:
    """Members in the sorter, from best to worst; initially empty.

    Parameters
    ----------
    capacity : int
        Maximum number of members; an additional member drops the worst.
    """

    def __init__(self, capacity):
        self._capacity = capacity
        self._inside = []

    def insert(self, key, *, late):
        """Insert a member and return how many worse members it passes.

        A ``late`` member follows equal members that are not late; otherwise the earlier one stays
        first.
        """
        place = bisect_right(self._inside, (key, late))
        passed = len(self._inside) - place
        self._inside.insert(place, (key, late))
        del self._inside[self._capacity :]
        return passed

"""Uploads with faults, in virtual time: the autopilot's own lists beside the sentence about them.

A session uploads a second mission, with its fence and rally points, to a simulated autopilot that
holds a first one. A seed chooses the autopilot, the delay, losses and duplicates of its link, and
one fault: the link dies for a while or for good, the autopilot restarts and keeps or loses its
lists, or the user interrupts the upload. The verdict compares the lists in the autopilot with both
missions and with the sentence; it shares no code with the comparison of the upload.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from bench.report import Options, Report
from pathgene.host.errors import JobError
from pathgene.host.evaluation import Evaluator
from pathgene.host.formats.flight_plan import FenceCircle, FlightPlan
from pathgene.host.mission.autopilot.flight_plan import flight_plan
from pathgene.host.mission.autopilot.mavlink_link import Link, NoReplyError
from pathgene.host.mission.autopilot.upload import upload
from pathgene.host.problem.problem import Problem
from pathgene.host.problem.zones import Circle, Polygon
from pathgene.host.terrain import Terrain
from pathgene.sim.autopilot.autopilot import Autopilot, Start
from pathgene.sim.autopilot.connection import Connection
from pathgene.sim.autopilot.items import FENCE, MISSION, RALLY, Item
from pathgene.sim.autopilot.link import Faults
from pathgene.sim.autopilot.pilot import Kind


__all__ = ["FAULTS", "SESSIONS", "Session", "run", "session"]

#: Number of sessions.
SESSIONS = 5000
#: Faults of a session, and their shares.
FAULTS = {
    "none": 0.25,
    "link dead for a while": 0.15,
    "link dead for good": 0.15,
    "restart, lists kept": 0.15,
    "restart, lists lost": 0.1,
    "interrupt": 0.2,
}
_VERDICTS = ("uploaded", "restored", "untouched", "cleared", "unknown, and said so", "violated")
_MOST_DELAY_S, _MOST_LOSS, _MOST_TWICE = 2.0, 0.2, 0.2
# Late messages arrive within this time after the session.
_AFTER_S = 20.0
_NAMES = {MISSION: "mission", FENCE: "fence", RALLY: "rally list"}


@dataclass(frozen=True)
class Session:
    """A session and its verdict.

    Parameters
    ----------
    sentence : str
        The sentence of the upload; empty after a success.
    """

    seed: int
    kind: Kind
    fault: str
    verdict: str
    sentence: str
    seconds: float


@cache
def _plans() -> tuple[FlightPlan, FlightPlan]:
    """Return two plans with different missions, fences and rally points."""
    rng = np.random.default_rng(7)
    terrain = Terrain(
        "hills", 300 + 100 * rng.random((41, 61)), 100.0, 100.0, "EPSG:32632", (4e5, 5.2e6)
    )
    made = []
    for side, zone in (
        (1000.0, Circle(3000.0, 3400.0, 200.0)),
        (3000.0, Polygon(((2800.0, 600.0), (3200.0, 600.0), (3000.0, 1000.0)))),
    ):
        path = np.array(
            [(400.0, side, 700.0), (3000.0, side + 400.0, 800.0), (5600.0, side, 700.0)]
        )
        problem = Problem(terrain, path[0], path[-1], zones=(zone,))
        track = Evaluator(problem, threads=1).track(path)
        made.append(flight_plan(problem, track, feasible=True))
    first, second = made
    return first, second


def _kept(items: Sequence[Item], is_first_home: bool) -> list[tuple[float, ...]]:
    """Return the commands, places and heights of a list that an autopilot holds."""
    held = items[1:] if is_first_home else items
    return [(item.command, item.x, item.y, item.z) for item in held]


def _sent(plan: FlightPlan) -> dict[int, list[tuple[float, ...]]]:
    """Return the commands, places and heights of a plan."""

    def place(command: int, lat: float, lon: float, z: float) -> tuple[float, ...]:
        return command, round(lat * 1e7), round(lon * 1e7), z

    fence = []
    for each in plan.fence:
        if isinstance(each, FenceCircle):
            fence.append(place(5004, each.lat, each.lon, 0.0))
        else:
            fence += [place(5002, lat, lon, 0.0) for lat, lon in each.corners]
    return {
        MISSION: [place(item.command, item.lat, item.lon, item.alt_m) for item in plan.items],
        FENCE: fence,
        RALLY: [place(5100, *point) for point in plan.rally],
    }


def _equal(held: Sequence[tuple[float, ...]], sent: Sequence[tuple[float, ...]]) -> bool:
    """Return whether lists agree, heights within the centimetres that ArduPilot keeps."""
    return len(held) == len(sent) and all(
        a[:3] == b[:3] and abs(a[3] - b[3]) < 0.03 for a, b in zip(held, sent, strict=True)
    )


class _Interrupted(Connection):
    """A connection whose user interrupts the program at an instant."""

    interrupt_s = float("inf")

    def recv_match(self, type: Any = None, **options: Any) -> Any:
        """Return the next message, unless the user interrupts."""
        if self.now_s >= self.interrupt_s:
            self.interrupt_s = float("inf")
            raise KeyboardInterrupt
        return super().recv_match(type, **options)


class _Restarting:
    """An autopilot that restarts at an instant."""

    def __init__(self, autopilot: Autopilot, at_s: float, silent_s: float, keeps: bool) -> None:
        self.autopilot = autopilot
        self.system, self.component = autopilot.system, autopilot.component
        self.connection: Connection | None = None
        self._at_s, self._silent_s, self._keeps = at_s, silent_s, keeps
        self._restarted_s = -float("inf")
        self._held: dict[int, list[Item]] = {}

    def held_until(self, instant_s: float) -> dict[int, list[Item]] | None:
        """Return the lists before a restart after an instant, or None; restart no more."""
        is_late = self._at_s == float("inf") and self._restarted_s > instant_s
        self._at_s = float("inf")
        return self._held if is_late else None

    @property
    def time_s(self) -> float:
        """Instant up to which the autopilot has acted."""
        return self.autopilot.time_s

    def handle(self, message: Any, now_s: float) -> list[Any]:
        """Return the answers to a message."""
        return self.autopilot.handle(message, now_s)

    def advance(self, now_s: float) -> list[Any]:
        """Act up to an instant; restart if it is time."""
        if now_s >= self._at_s:
            self._at_s, self._restarted_s = float("inf"), now_s
            self._held = {kind: list(items) for kind, items in self.autopilot.lists.items.items()}
            self.autopilot.restart(self._silent_s, keeps_lists=self._keeps)
            assert self.connection is not None
            self.connection.down.restart()
        return self.autopilot.advance(now_s)


def session(seed: int) -> Session:
    """Upload once, with the faults of a seed, and judge the result."""
    rng = np.random.default_rng(seed)
    old, new = _plans()
    kind = (Kind.ARDUPLANE, Kind.PX4)[rng.integers(2)]
    fault = str(rng.choice(list(FAULTS), p=list(FAULTS.values())))
    autopilot = Autopilot(kind, Start(old.home, armed=False))
    clean = Connection(autopilot)
    link = Link(clean, clock=clean.clock)
    link.find(5.0, 1)
    upload(old, link)
    before = {each: list(items) for each, items in autopilot.lists.items.items()}

    delay_s = float(rng.choice([0.02, rng.uniform(0, 0.5), rng.uniform(0, _MOST_DELAY_S)]))
    up = Faults(
        delay_s,
        float(rng.choice([0.0, 0.3 * delay_s])),
        float(rng.choice([0.0, rng.uniform(0, _MOST_LOSS)])),
        float(rng.choice([0.0, rng.uniform(0, _MOST_TWICE)])),
    )
    # About the time of an upload: two trips for each of some 60 messages.
    at_s = autopilot.time_s + 1.0 + float(rng.uniform(0, 1)) * (1.0 + 130 * (delay_s + 0.02))
    if fault.startswith("link"):
        heals_s = at_s + rng.uniform(1, 30) if fault.endswith("while") else float("inf")
        up = replace(up, dies_s=at_s, heals_s=heals_s)
    endpoint = _Restarting(
        autopilot,
        at_s if fault.startswith("restart") else float("inf"),
        float(rng.uniform(1, 8)),
        fault.endswith("kept"),
    )
    connection = _Interrupted(endpoint, up, up, seed=seed)
    endpoint.connection = connection
    if fault == "interrupt":
        connection.interrupt_s = at_s
    link = Link(connection, clock=connection.clock)
    begun_s, sentence = connection.now_s, ""
    try:
        link.find(20.0, 1)
        upload(new, link)
    except NoReplyError:
        sentence = "No autopilot answers; nothing is uploaded."
    except KeyboardInterrupt:
        sentence = "Interrupted before anything was sent; nothing is uploaded."
    except JobError as error:
        sentence = str(error)
    seconds = connection.now_s - begun_s
    # A restart after the last answer was sent is none in the upload.
    held = endpoint.held_until(connection.now_s - up.delay_s - up.jitter_s)
    # The judge reads the autopilot itself, after late messages have arrived.
    end_s = connection.now_s + _AFTER_S
    while connection.now_s < end_s:
        Connection.recv_match(connection, timeout=1.0)
    lists = autopilot.lists.items if held is None else held
    verdict = _verdict(kind, lists, before, new, sentence, fault)
    return Session(seed, kind, fault, verdict, sentence, seconds)


def _verdict(
    autopilot: Kind,
    lists: dict[int, list[Item]],
    before: dict[int, list[Item]],
    new: FlightPlan,
    sentence: str,
    fault: str,
) -> str:
    """Return the verdict on a sentence about lists."""
    has_home = autopilot is Kind.ARDUPLANE
    wanted = _sent(new)
    claims = set()
    for kind, name in _NAMES.items():
        is_home = has_home and kind == MISSION
        held = _kept(lists[kind], is_home)
        is_old = _equal(held, _kept(before[kind], is_home))
        is_new = _equal(held, wanted[kind])
        if not sentence:
            claim, is_true = "uploaded", is_new
        elif "nothing is uploaded" in sentence:
            # Nothing is claimed of lists that a restart has lost.
            claim, is_true = "untouched", is_old or (fault == "restart, lists lost" and not held)
        elif f"its earlier {name} (" in sentence:
            claim, is_true = "restored", is_old
        elif f"the new {name} (" in sentence:
            claim, is_true = "new", is_new
        elif f"no {name}, because" in sentence:
            claim, is_true = "cleared", not held
        else:
            claim, is_true = "unknown, and said so", f"an unknown {name}" in sentence
            # Only a link that is dead excuses a list of two halves.
            is_whole = is_old or is_new or not held
            is_true &= is_whole or fault.startswith("link dead")
        # A restart while the link is silent loses lists that were there at the last answer.
        is_lost = fault == "restart, lists lost" and "when it last answered" in sentence
        if not is_true and not (is_lost and not held):
            return "violated"
        claims.add(claim)
    order = ("unknown, and said so", "cleared", "restored", "untouched", "uploaded", "new")
    first = next(each for each in order if each in claims)
    return "uploaded" if first == "new" else first


def run(options: Options) -> Report:
    """Run all sessions and count their verdicts."""
    sessions = [session(seed) for seed in range(SESSIONS)]
    return report(sessions)


def report(sessions: Sequence[Session]) -> Report:
    """Return the table of sessions by fault and autopilot."""
    made = Report(
        f"{len(sessions):,} uploads with faults to the simulated autopilots",
        ["autopilot", "fault", "sessions", *_VERDICTS],
    )
    for kind in Kind:
        for fault in FAULTS:
            some = [each for each in sessions if (each.kind, each.fault) == (kind, fault)]
            counts = Counter(each.verdict for each in some)
            made.rows.append(
                (kind.name.lower(), fault, len(some), *(counts[each] for each in _VERDICTS))
            )
    violated = [each for each in sessions if each.verdict == "violated"]
    seconds = sorted(each.seconds for each in sessions if each.verdict == "uploaded")
    made.notes.append(
        f"Each way takes up to {_MOST_DELAY_S:g} s, loses up to {100 * _MOST_LOSS:.0f} % of the "
        f"messages and delivers up to {100 * _MOST_TWICE:.0f} % twice. Half of the uploads take "
        f"less than {seconds[len(seconds) // 2]:.0f} s, the slowest {seconds[-1]:.0f} s."
    )
    made.failed = bool(violated)
    made.notes += [f"Seed {each.seed}: {each.sentence or 'uploaded'}" for each in violated[:10]]
    return made

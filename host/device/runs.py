"""Runs of the planner core: its commands over a link."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from pathgene.hdl.config import Config
from pathgene.hdl.protocol.codes import UNITS, Command
from pathgene.hdl.protocol.messages import status_reply
from pathgene.hdl.protocol.planner import VALUE_BITS, NoFlyShape, PathClass, ProblemRecord
from pathgene.hdl.protocol.runs import RunOptions, guide_request, unpack_best
from pathgene.host.device.chip_map import MapCopy
from pathgene.host.device.link import Link, LinkTimeoutError
from pathgene.host.device.orders import Orders


__all__ = ["BestPaths", "RunStatus", "Runs"]


@dataclass(frozen=True)
class RunStatus:
    """Progress of a run.

    During a run, the board ``model:`` knows neither the key nor the cycles of units.

    Attributes
    ----------
    running : bool
        The run is not over.
    generations, cycles : int
        Generations bred and cycles elapsed since the beginning of the run.
    key : int
        Key of the best path found.
    breed, score, walk, sort, wavefront : int
        Cycles of the chip's units, which overlap: see :class:`pathgene.hdl.protocol.runs.Outcome`.
    """

    running: bool
    generations: int
    cycles: int
    key: int
    breed: int = 0
    score: int = 0
    walk: int = 0
    sort: int = 0
    wavefront: int = 0


@dataclass(frozen=True)
class BestPaths:
    """Paths that a run returns.

    Attributes
    ----------
    paths : list of list of int
        Packed waypoints, the best path first; start and goal are left out.
    """

    paths: list[list[int]]
    keys: list[int]

    @property
    def classes(self) -> list[PathClass]:
        """Classes of the paths."""
        return [PathClass(key >> VALUE_BITS) for key in self.keys]


class Runs:
    """Runs of the planner on a chip.

    During a run, only :meth:`status`, :meth:`stop`, :meth:`end` and :meth:`poll` are answered; the
    chip refuses all other methods, and writes of the map, with
    :attr:`pathgene.hdl.protocol.codes.Status.BUSY`.

    Parameters
    ----------
    config : Config
        The chip's; it must have the planner core.

    Attributes
    ----------
    started : int
        Number of runs begun. The population changes only when this number does.
    may_continue : bool
        Nothing has told yet that the latest run is over.

    Raises
    ------
    RefusedError
        From every method: if the chip refuses the command.
    """

    def __init__(self, config: Config, link: Link, orders: Orders, map_copy: MapCopy) -> None:
        self._config, self._link, self._orders, self._map = config, link, orders, map_copy
        self.started = 0
        self.may_continue = False

    def together(
        self, meanwhile: Callable[[], object] = lambda: None
    ) -> AbstractContextManager[None]:
        """Return a context that sends its commands together and waits once for all of them.

        When they have been sent, ``meanwhile`` is called, before the wait.

        It takes writes of the map and the commands of this object, except :meth:`status`,
        :meth:`best` and :meth:`poll`, which must not be called in it. Values out of range
        are refused immediately. Refusals by the chip and failures of the line are raised when the
        context ends. If the chip refuses one of several commands, the session ends.
        """
        return self._orders.together(meanwhile)

    def set_problem(self, record: ProblemRecord) -> None:
        """Give the chip a problem on its map of corners.

        The paths of earlier runs are void; the latest population stays for a warm run.

        Raises
        ------
        ValueError
            If a field of the record does not fit.
        """
        self._orders.give([(Command.PROBLEM, record.pack(self._config))])

    def block(self, shape: NoFlyShape) -> None:
        """Block the corners in a shape; the chip draws it.

        A later :meth:`pathgene.host.device.chip.Chip.update_map` treats them as blocked.

        Raises
        ------
        ValueError
            If a field of the shape does not fit, or its box has no corner.
        """
        if not shape.is_valid():
            raise ValueError(f"The box of a shape must have a corner at least, not as in {shape}")
        self._map.block(shape)

    def guide(self, waypoints: Sequence[tuple[int, int, int]]) -> None:
        """Store the corners and steps of a path for runs whose ``guided`` is their number.

        Raises
        ------
        ValueError
            If a waypoint does not fit the map, or there are more than a path has.
        """
        most = self._config.max_waypoints
        if len(waypoints) > most:
            raise ValueError(f"A guide must have at most {most} waypoints, not {len(waypoints)}")
        layout = guide_request(self._config)
        self._orders.give(
            [
                (Command.GUIDE, layout.pack(index=i, x=x, y=y, altitude=altitude))
                for i, (x, y, altitude) in enumerate(waypoints)
            ]
        )

    def start(self, options: RunOptions) -> None:
        """Begin a run on the problem; :meth:`status` says when it is over.

        A warm run continues from the population of the latest run, even if :meth:`set_problem` was
        called since.

        Raises
        ------
        ValueError
            If an option is out of its range.
        """
        payload = options.pack(self._config)
        # Whatever the answer, the population may have changed.
        self.started += 1
        self.may_continue = True
        self._orders.give([(Command.RUN, payload)])

    def status(self) -> RunStatus:
        """Return the progress of the latest run."""
        return self._status(self._link.request(Command.STATUS))

    def _status(self, payload: bytes) -> RunStatus:
        fields = status_reply(self._config).unpack(payload)
        return RunStatus(
            bool(fields["running"]),
            fields["generation"],
            fields["cycles"],
            fields["key"],
            **{unit: fields[unit] for unit in UNITS},
        )

    def stop(self) -> None:
        """End the run after its current generation; :meth:`status` says when it is over.

        The first population is always completed.
        """
        self._orders.give([(Command.STOP, b"")])

    def end(self) -> None:
        """Stop a run in progress, and wait for its end.

        Raises
        ------
        LinkTimeoutError
            If the run has not ended within the link's patience.
        """
        if self.status().running:
            self.stop()
            limit = self._link.now() + self._link.patience_s
            while self.status().running:
                if self._link.now() > limit:
                    raise LinkTimeoutError(
                        f"The board continues a run {self._link.patience_s:g} s after it was told "
                        "to stop: reset it."
                    )
        self.may_continue = False

    def best(self) -> BestPaths:
        """Return the paths of the latest run, best first; empty if the problem had no run."""
        return self._best(self._link.request(Command.BEST))

    def _best(self, payload: bytes) -> BestPaths:
        best = BestPaths(*unpack_best(self._config, payload))
        self.may_continue = False
        return best

    def poll(self) -> tuple[BestPaths, RunStatus] | None:
        """Return the paths and counts of the latest run, or None before its end.

        Both are asked for together, so that the host waits once.
        """
        paths, told = self._link.poll(Command.BEST)
        if paths is None:
            return None
        return self._best(paths), self.status() if told is None else self._status(told)

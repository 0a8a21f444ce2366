"""Runs of a planner on the chip: its commands over a link."""

from __future__ import annotations

from dataclasses import dataclass

from hdl.config import Config
from hdl.protocol import Command, status_reply
from hdl.protocol.planner import VALUE_BITS, PathClass, ProblemRecord
from hdl.protocol.runs import RunOptions, unpack_best
from host.device.link import Link


__all__ = ["BestPaths", "RunStatus", "Runs"]


@dataclass(frozen=True)
class RunStatus:
    """Progress of a run.

    Attributes
    ----------
    running : bool
        The run is not over.
    generations, cycles : int
        Generations bred and cycles passed since its beginning.
    key : int
        Key of the best path so far.
    """

    running: bool
    generations: int
    cycles: int
    key: int


@dataclass(frozen=True)
class BestPaths:
    """Paths that a run returns.

    Attributes
    ----------
    paths : list of list of int
        Packed waypoints, the best path first; start and goal are left out.
    keys : list of int
        Their keys, all different.
    """

    paths: list[list[int]]
    keys: list[int]

    @property
    def classes(self) -> list[PathClass]:
        """Classes of the paths."""
        return [PathClass(key >> VALUE_BITS) for key in self.keys]


class Runs:
    """Runs of the planner on a chip.

    Parameters
    ----------
    config : Config
        The chip's; it must have a streaming genetic core.
    link : Link
        Link to the chip.
    """

    def __init__(self, config: Config, link: Link) -> None:
        self._config, self._link = config, link

    def set_problem(self, record: ProblemRecord) -> None:
        """Give the chip a problem on its map of corners; the paths of earlier runs are void.

        Raises
        ------
        ValueError
            If a field of the record does not fit.
        """
        self._link.request(Command.PROBLEM, record.pack(self._config))

    def start(self, options: RunOptions) -> None:
        """Begin a run on the problem; :meth:`status` says when it is over.

        Raises
        ------
        ValueError
            If an option is out of its range.
        """
        self._link.request(Command.RUN, options.pack(self._config))

    def status(self) -> RunStatus:
        """Return the progress of the latest run."""
        layout = status_reply(self._config)
        fields = layout.unpack(self._link.request(Command.STATUS))
        return RunStatus(
            bool(fields["running"]), fields["generation"], fields["cycles"], fields["key"]
        )

    def stop(self) -> None:
        """End the run with its present generation."""
        self._link.request(Command.STOP)

    def best(self) -> BestPaths:
        """Return the paths of the latest run, the best first; none before the first run."""
        return BestPaths(*unpack_best(self._config, self._link.request(Command.BEST)))

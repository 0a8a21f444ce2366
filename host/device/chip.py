"""A chip at a link: the commands of :mod:`pathgene.hdl.protocol` as methods."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from pathgene.hdl.config import CheckerBuild
from pathgene.hdl.protocol.breeding import Recipe, breed, keep
from pathgene.hdl.protocol.codes import Command, LinkMode
from pathgene.hdl.protocol.layout import Layout
from pathgene.hdl.protocol.messages import (
    counters_reply,
    generate_request,
    read_request,
    recipe_reply,
    start_request,
    status_reply,
    survivors_reply,
    write_request,
)
from pathgene.hdl.protocol.paths import PathResult, pack_paths, unpack_paths
from pathgene.host.device.chip_map import MapCopy
from pathgene.host.device.identity import built_config, request_info
from pathgene.host.device.link import Link
from pathgene.host.device.orders import Orders
from pathgene.host.device.paths import CheckReport, check_points, check_slots
from pathgene.host.device.runs import Runs
from pathgene.host.errors import InputError


__all__ = ["CheckReport", "Chip", "LinkMode", "PathResult", "Step"]

#: Maximum bytes of waypoints in one frame of a transfer: a short frame survives a bad line.
_TRANSFER_BYTES = 128


@dataclass(frozen=True)
class Step:
    """Result of one generation.

    Attributes
    ----------
    paths : list of list of int
        Packed waypoints of every slot: elites, survivors, children.
    origin : tuple of int, or None
        Previous slots of the elites and survivors. None in population mode, which does not report
        them.
    """

    paths: list[list[int]]
    origin: tuple[int, ...] | None


class Chip:
    """A chip with an open session.

    Parameters
    ----------
    url : str
        Address of the board; empty for none.
    verify_every : int
        In recipe mode, generations between full reads of the population.

    Attributes
    ----------
    config : Config
        Configuration that the chip was built from, as the chip reports it.
    info : dict
        Fields of the chip's reply to ``INFO``.

    Raises
    ------
    LinkTimeoutError
        If nothing answers.
    InputError
        If the board has another protocol version, or an unknown build.
    """

    def __init__(self, link: Link, *, verify_every: int = 256, url: str = "") -> None:
        self.link, self.url = link, url
        self._verify_every = verify_every
        # The host's copy of the population; None while the population is unknown.
        self._paths: list[list[int]] | None = None
        self._steps = 0
        self.info = request_info(link)
        self.config = built_config(self.info)
        self._orders = Orders(link)
        self._map = MapCopy(self.config, self._orders)
        self._runs = Runs(self.config, link, self._orders, self._map)
        self._beside: Chip | None = None
        self.closed = False
        link.open(self.info["session"], credit=self.config.receive_buffer)
        self._end_earlier_run()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()

    @property
    def paths(self) -> list[list[int]]:
        """Packed waypoints of every slot.

        This is the host's copy. Before the first :meth:`load` of all slots, and after a failed
        call, there is no copy, and the slots are read from the chip.
        """
        return [list(path) for path in self._known()]

    def close(self) -> None:
        """Close the link, end its simulated board, and close its second chip."""
        self.closed = True
        self.link.close()
        if self._beside is not None:
            self._beside.close()

    def reopen(self) -> None:
        """Open a new session after a failed one.

        Raises
        ------
        LinkError
            If the board still does not answer, or was reset in the meantime.
        """
        self.link.reopen()
        self._end_earlier_run()

    def _end_earlier_run(self) -> None:
        """End a run that an earlier session left: a run makes other commands wait."""
        if self.config.planner_core:
            self._runs.end()

    def beside(self, opened: Callable[[], Chip]) -> Chip:
        """Return a chip that is closed with this one; ``opened`` makes it at the first call."""
        if self._beside is None:
            self._beside = opened()
        return self._beside

    def _known(self) -> list[list[int]]:
        if self._paths is None:
            self._paths = self.read(0, self.config.population)
        return self._paths

    def _ask(self, command: Command, layout: Layout) -> dict[str, int]:
        return layout.unpack(self.link.request(command))

    def start(self, seed: int, limits: tuple[int, int, int], *, avoid_ground: bool = False) -> None:
        """Seed the random source and start at generation 0.

        Parameters
        ----------
        seed : int
            0..2**64 - 1.
        limits : tuple of int
            Highest x and y cell and altitude step of a new waypoint.
        avoid_ground : bool
            Redraw a new waypoint that lies below the ground of the chip's map. After the number of
            draws that the chip was built for, it skips the mutation.

        Raises
        ------
        InputError
            If the chip has no paper core; so do :meth:`load`, :meth:`read`, :meth:`step` and
            :meth:`check_population`.
        """
        self._require_core()
        x, y, altitude = limits
        layout = start_request(self.config)
        request = layout.pack(seed=seed, x=x, y=y, altitude=altitude, avoid_ground=avoid_ground)
        self.link.request(Command.START, request)
        self._steps = 0

    def load(self, paths: Sequence[Sequence[int]], slot: int = 0) -> None:
        """Write ``paths`` (packed waypoints) into consecutive slots, starting at ``slot``."""
        self._require_core()
        config = self.config
        requests = []
        at, part = slot, b""
        for number, path in enumerate(paths):
            packed = pack_paths(config, [path])
            if part and len(part) + len(packed) > _TRANSFER_BYTES:
                requests.append((Command.WRITE, write_request(config).pack(slot=at) + part))
                at, part = slot + number, b""
            part += packed
        if part:
            requests.append((Command.WRITE, write_request(config).pack(slot=at) + part))
        # After a transfer that fails, the contents of the slots are unknown.
        before, self._paths = self._paths, None
        self.link.transfer(requests)
        loaded = [list(path) for path in paths]
        if len(loaded) == config.population:
            self._paths = loaded
        elif before is not None:
            self._paths = [*before[:slot], *loaded, *before[slot + len(loaded) :]]

    def read(self, slot: int, count: int) -> list[list[int]]:
        """Return the packed paths of ``count`` slots, starting at ``slot``."""
        self._require_core()
        layout = read_request(self.config)
        requests = [
            (Command.READ, layout.pack(slot=first, count=min(2, slot + count - first)))
            for first in range(slot, slot + count, 2)
        ]
        return unpack_paths(self.config, b"".join(self.link.transfer(requests)))

    def upload_map(
        self,
        heights: NDArray[np.integer],
        x: int = 0,
        y: int = 0,
        *,
        progress: Callable[[int, int], object] | None = None,
    ) -> None:
        """Write a rectangle of the chip's map; :meth:`update_map` resumes a failed upload.

        Parameters
        ----------
        heights : ndarray
            ``(rows, columns)`` integers, altitude steps, row 0 the southernmost; the highest step
            marks a cell that no path may cross.
        x, y : int
            Cell of ``heights[0, 0]``.
        progress : callable, optional
            Called repeatedly with the number of cells written and the number of all cells.

        Raises
        ------
        InputError
            If the chip has no map.
        ValueError
            If ``heights`` is not such an array, or leaves the map.
        """
        self._require_checker()
        self._map.upload(heights, x, y, progress=progress)

    def update_map(
        self, heights: NDArray[np.integer], *, progress: Callable[[int, int], object] | None = None
    ) -> None:
        """Make ``heights`` the chip's map; each frame has only the cells around changes.

        Heights are compared with the cells that this object has written: the first call sends
        the whole map, and a call with the same map sends nothing. After a failed upload, the call
        sends the cells that the chip has not acknowledged, in a new session if the failure ended
        the session: it resumes the upload.

        Parameters
        ----------
        heights : ndarray
            ``(map_size, map_size)`` integers, as for :meth:`upload_map`.
        progress : callable, optional
            As for :meth:`upload_map`.

        Raises
        ------
        InputError
            If the chip has no map.
        LinkError
            If the board still does not answer, or was reset in the meantime.
        ValueError
            If ``heights`` is not a whole map.
        """
        self._require_checker()
        if self.link.session is None:
            self.reopen()
        self._map.update(heights, progress=progress)

    def check_path(self, points: Sequence[int], *, counting: bool = False) -> CheckReport:
        """Check one path against the chip's map.

        Parameters
        ----------
        points : sequence of int
            Packed waypoints: the aircraft, 0 to ``max_waypoints`` waypoints, the goal.
        counting : bool
            Count the colliding cells of every segment, instead of stopping at the first.

        Raises
        ------
        InputError
            If the chip has no map, or does not check paths sent over the link.
        """
        self._require_checker()
        if self.config.planner_core:
            raise InputError(
                "The board has the planner core, which checks the paths that it breeds and no "
                "others: use one that was built with core=paper."
            )
        return check_points(self.config, self.link, points, counting=counting)

    def check_population(
        self,
        start: int,
        goal: int,
        *,
        slot: int = 0,
        count: int | None = None,
        counting: bool = False,
    ) -> CheckReport:
        """Check paths in the chip's slots against its map, without sending them.

        Parameters
        ----------
        start, goal : int
            Start and goal of each path, as packed waypoints.
        slot, count : int
            First slot and number of slots; by default all slots, starting at ``slot``.
        counting : bool
            As for :meth:`check_path`.

        Raises
        ------
        InputError
            If the chip has no map, or no paper core.
        """
        self._require_checker()
        self._require_core()
        if count is None:
            count = self.config.population - slot
        return check_slots(
            self.config, self.link, start, goal, slot=slot, count=count, counting=counting
        )

    @property
    def runs(self) -> Runs:
        """Runs of the planner core.

        Raises
        ------
        InputError
            If the chip has no planner core.
        """
        if not self.config.planner_core:
            raise InputError(
                "The board has no planner core: use one that was built with core=planner."
            )
        return self._runs

    def _require_core(self) -> None:
        if self.config.planner_core:
            raise InputError(
                "The board has the planner core, which breeds without the host: use one that was "
                "built with core=paper."
            )
        if not self.config.paper_core:
            raise InputError(
                "The board has no genetic core, it only checks paths: use one that was built with "
                "core=paper."
            )

    def _require_checker(self) -> None:
        if self.config.checker is CheckerBuild.NONE:
            raise InputError(
                "The board has no collision checker: use one that was built with "
                "checker=parallel or checker=two-tier."
            )

    def counters(self) -> dict[str, int]:
        """Return every ``Counter`` by name: cycles and bytes since reset."""
        return self._ask(Command.COUNTERS, counters_reply(self.config))

    def status(self) -> dict[str, int]:
        """Return the fields of :func:`pathgene.hdl.protocol.messages.status_reply`."""
        return self._ask(Command.STATUS, status_reply(self.config))

    def clear_errors(self) -> None:
        """Clear the sticky errors."""
        self.link.request(Command.CLEAR)

    def step(self, order: Sequence[int], mode: LinkMode = LinkMode.RANK) -> Step:
        """Run one generation.

        Parameters
        ----------
        order : sequence of int
            The slots from the best path to the worst.
        mode : LinkMode
            Data that goes over the link. The new population is the same in all three modes.

        Raises
        ------
        LinkError
            If the board is lost.
        """
        self._require_core()
        config = self.config
        order = list(order)
        if mode is LinkMode.POPULATION:
            known = self._known()
            self.load([known[slot] for slot in order])
            order = list(range(config.population))
            request = generate_request(config, mode).pack(mode=mode)
        else:
            named = {f"slot_{rank}": slot for rank, slot in enumerate(order)}
            request = generate_request(config, mode).pack(mode=mode, **named)

        before, self._paths = self._known(), None
        # A long reply may never get through a bad line. The short recipe does, and carries the same
        # information.
        recipe_only = bytes((LinkMode.RECIPE,)) + bytes(order)
        reply = self.link.request(Command.GENERATE, request, shorter=recipe_only)
        self._steps += 1
        if len(reply) == recipe_reply(config).size:
            return self._rebuild(before, order, reply)
        if mode is LinkMode.POPULATION:
            self._paths = unpack_paths(config, reply)
            return Step(self.paths, None)

        size = survivors_reply(config).size
        origin = keep(config, order, reply[:size])
        children = unpack_paths(config, reply[size:])
        self._paths = [before[slot] for slot in origin] + children
        return Step(self.paths, origin)

    def _rebuild(self, paths: list[list[int]], order: Sequence[int], reply: bytes) -> Step:
        """Repeat the generation of a recipe on the host's copy of the previous population."""
        recipe, checksum = Recipe.unpack(self.config, reply)
        self._paths = breed(self.config, paths, order, recipe)
        rebuilt_wrong = zlib.crc32(pack_paths(self.config, self._paths)) != checksum
        if rebuilt_wrong or self._steps % self._verify_every == 0:
            self._paths = self.read(0, self.config.population)
        return Step(self.paths, keep(self.config, order, recipe.survivors))

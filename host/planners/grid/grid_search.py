"""Cheapest routes over a coarse grid of the terrain, as seen from above.

The cost of a route is the cost, as in :mod:`pathgene.host.evaluation`, of flying it at the altitude
of a surface over the ground: half for altitude times length, half for fuel, each relative to the
straight line.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pathgene.host.evaluation.fuel import air_distance
from pathgene.host.evaluation.reference import problem_utopia
from pathgene.host.planners.grid.shortest_paths import Graph, shortest_paths
from pathgene.host.problem.limits import pressure_on_wing
from pathgene.host.problem.problem import Problem


__all__ = ["LEAST_COST", "MOST_NODES", "Place", "Prices", "SearchGrid"]

Floats = NDArray[np.float64]
Place = tuple[float, float]

#: Nodes on the longer side of a quick search's grid: more nodes improve routes by 0.0005 in F, but
#: take longer.
MOST_NODES = 200
# Steps to 16 neighbours: with 8, a route on level ground is up to 8 % longer than the line.
_QUARTER = ((1, 0), (1, 1), (2, 1), (1, 2))
_STEPS = tuple(step for x, y in _QUARTER for step in ((x, y), (-y, x), (-x, -y), (y, -x)))
#: Minimum cost of a step: Dijkstra's algorithm needs positive costs.
LEAST_COST = 1e-12


class Prices:
    """The cost of equation (2) as prices of altitude, climb and glide.

    Parameters
    ----------
    problem : Problem
        The aircraft, and the straight line that costs are relative to.

    Attributes
    ----------
    base_m : float
        Altitude that the price of altitude counts from.
    area : float
        Price of a metre of altitude over a metre of length.
    work : float
        Price of a metre of climb, or of the equivalent thrust.
    glide : float
        Thrust of level flight as the tangent of a slope: a descent this steep needs no thrust.
    """

    def __init__(self, problem: Problem) -> None:
        best = problem_utopia(problem)
        aircraft = problem.aircraft
        lift_area = pressure_on_wing(aircraft)
        drag = (
            lift_area * aircraft.zero_lift_drag_coefficient
            + aircraft.induced_drag_factor * aircraft.weight_N**2 / lift_area
        )
        burn_per_m = aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
        self.base_m = problem.cost_base_m
        self.area = 0.5 / (best.altitude_m * best.length_m)
        self.work = 0.5 / best.fuel_N * burn_per_m * aircraft.weight_N
        self.glide = drag / aircraft.weight_N


class SearchGrid:
    """The terrain reduced to at most 200 x 200 nodes, each as high as the highest ground it covers.

    Voids, no-fly zones, and ground that the aircraft cannot climb over on a straight line from the
    start or to the goal are blocked.

    Parameters
    ----------
    margin_m : float
        Distance of routes from blocked nodes, so that turns may cut corners.
    most_nodes : int
        Maximum number of nodes on the longer side.
    gain_m : float
        Altitude that the aircraft gains by circling at the start.
    blocked : (ny, nx) bool, optional
        Nodes of the terrain that are blocked in addition to the problem's.
    """

    def __init__(
        self,
        problem: Problem,
        margin_m: float = 0.0,
        *,
        most_nodes: int = MOST_NODES,
        gain_m: float = 0.0,
        blocked: NDArray[np.bool_] | None = None,
    ) -> None:
        terrain = problem.surface
        self.problem = problem
        self.prices = Prices(problem)
        #: Cells of the terrain along a side of a node.
        self.every = math.ceil(max(terrain.shape) / most_nodes)
        self.dx_m, self.dy_m = self.every * terrain.dx_m, self.every * terrain.dy_m
        void = np.isnan(terrain.elevation)
        self.ground = self._pooled(np.where(void, np.nanmin(terrain.elevation), terrain.elevation))
        self.shape = self.ground.shape
        rows, columns = np.indices(self.shape)
        # A node of the grid is one of the terrain: no line between nodes follows a border of cells.
        middle = self.every // 2
        x = np.minimum(columns * self.every + middle, terrain.shape[1] - 1) * terrain.dx_m
        y = np.minimum(rows * self.every + middle, terrain.shape[0] - 1) * terrain.dy_m
        self._x, self._y = x.ravel(), y.ravel()

        climb, descent = math.tan(problem.limits.climb_rad), math.tan(problem.limits.descent_rad)
        (x0, y0, z0), (x1, y1, z1) = problem.start, problem.goal
        away_0, away_1 = np.hypot(x - x0, y - y0), np.hypot(x - x1, y - y1)
        # The highest ground of a node may be this far from the node.
        reach = math.hypot(self.dx_m, self.dy_m)
        #: Blocked cells of the terrain: voids and zones, (ny, nx) bool.
        self.blocked_cells = problem.blocked_raster
        if blocked is not None:
            self.blocked_cells = self.blocked_cells | blocked
        out = self._pooled(self.blocked_cells)
        out |= self.ground > z0 + gain_m + climb * (away_0 + reach)
        out |= self.ground > z1 + descent * (away_1 + reach)
        self._start, self._goal = self._node(x0, y0), self._node(x1, y1)
        out.flat[[self._start, self._goal]] = False
        self.blocked = out
        self._shunned = out
        #: Blocked nodes cost this many times the dearest open one, instead of an infinite price.
        self.blocked_factor: float | None = None
        #: Factors of the costs at the nodes, (rows, columns), 1 or more; None stands for 1.
        self.factors: Floats | None = None
        if margin_m > 0 and out.any():
            self._shunned = _widened(out, self.dy_m, self.dx_m, margin_m)
            self._shunned.flat[[self._start, self._goal]] = False
        # The lowest altitude on a climb from the start and a descent to the goal.
        self._lowest = np.maximum(z0 - descent * away_0, z1 - climb * away_1)
        self._link()

    def surface(self, steepness: float) -> Floats:
        """Return the lowest surface of limited slope over the ground, (rows, columns) metres.

        Each node is at least as high as any other node minus ``steepness`` times the distance
        between them; with an infinite ``steepness`` the surface is the ground. It is never lower
        than the climb from the start and the descent to the goal allow.
        """
        surface = self.ground
        if math.isfinite(steepness):
            # One extra node, whose distance to each other node is that node's depth below the top.
            top = surface.max()
            costs = np.concatenate((steepness * self._length, (top - surface).ravel()))
            below = shortest_paths(*self._graph(costs), len(self._x))[0][:-1]
            surface = top - below.reshape(self.shape)
        lowest: Floats = np.maximum(surface, self._lowest)
        return lowest

    def route(
        self, surface: Floats, first: Place | None = None, last: Place | None = None
    ) -> Floats | None:
        """Return the cheapest route from start to goal at the altitudes of ``surface``.

        Parameters
        ----------
        first, last : (float, float), optional
            Ends of the route instead of start and goal, metres on the map.

        Returns
        -------
        ndarray or None
            Points x, y from start to goal, (n, 2) float64 metres; None if there is no route.
        """
        altitude = surface.ravel()
        tail, head = altitude[self._tail], altitude[self._head]
        thrust = np.maximum(self.prices.glide + (head - tail) / self._length, 0.0)
        costs = (
            self.prices.area * (0.5 * (tail + head) - self.prices.base_m) * self._length
            + self.prices.work * thrust * self._air
        )
        costs = np.maximum(costs, LEAST_COST)
        if self.factors is not None:
            costs *= self.factors.ravel()[self._head]
        costs[self._barred] = math.inf
        graph = self._graph(np.concatenate((costs, np.full(len(self._x), math.inf))))
        start = self._start if first is None else self._node(*first)
        goal = self._goal if last is None else self._node(*last)
        _, before = shortest_paths(*graph, start)
        nodes = [goal]
        while nodes[-1] != start:
            if before[nodes[-1]] < 0:
                return None
            nodes.append(int(before[nodes[-1]]))
        nodes.reverse()
        points: Floats = np.stack((self._x[nodes], self._y[nodes]), axis=1)
        ends = np.array([first or self.problem.start[:2], last or self.problem.goal[:2]])
        return np.concatenate((ends[:1], points[1:-1], ends[1:]))

    def price_per_m(self, surface: Floats) -> Floats:
        """Return the cost of a metre of level flight on ``surface``; infinite at blocked nodes.

        With ``blocked_factor`` it is finite there.
        """
        level = self.level_price_per_m(surface)
        if self.factors is not None:
            level = level * self.factors
        barred = math.inf
        if self.blocked_factor is not None:
            barred = self.blocked_factor * float(level.max(where=~self.blocked, initial=LEAST_COST))
        return np.where(self.blocked, barred, level)

    def level_price_per_m(self, surface: Floats) -> Floats:
        """Return the cost of a metre of level flight on ``surface``, as if no node was blocked."""
        above = surface - self.prices.base_m
        return self.prices.area * above + self.prices.work * self.prices.glide

    def nodes(self, x: Floats, y: Floats) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Return row and column of the nodes that cover points on the map, metres."""
        row, column = self.problem.terrain.nearest_nodes(x, y)
        return row // self.every, column // self.every

    def _node(self, x: float, y: float) -> int:
        row, column = self.nodes(np.array([x]), np.array([y]))
        return int(row[0] * self.shape[1] + column[0])

    def _pooled(self, raster: NDArray[Any]) -> NDArray[Any]:
        """Return the highest value of every block of a raster of the terrain."""
        rows, columns = (np.arange(0, nodes, self.every) for nodes in raster.shape)
        return np.maximum.reduceat(np.maximum.reduceat(raster, rows, axis=0), columns, axis=1)

    def _link(self) -> None:
        """List the steps between nodes, in the order of a sparse matrix."""
        rows, columns = self.shape
        count = rows * columns
        node = np.arange(count, dtype=np.int32)
        row, column = np.divmod(node, columns)
        across, up = np.array(_STEPS).T
        to_row, to_column = row[:, None] + up, column[:, None] + across
        inside = (to_row >= 0) & (to_row < rows) & (to_column >= 0) & (to_column < columns)
        self._head = (to_row * columns + to_column)[inside].astype(np.int32)
        self._tail = np.repeat(node, inside.sum(axis=1))
        # A knight's move passes two nodes on its way.
        blocked = self._shunned.ravel()
        self._barred = blocked[self._head]
        for half in (np.floor, np.ceil):
            passed = (row[:, None] + half(up / 2)) * columns + column[:, None] + half(across / 2)
            self._barred |= blocked[passed[inside].astype(np.int32)]
        step = np.broadcast_to(np.arange(len(_STEPS)), inside.shape)[inside]
        runs = np.hypot(across * self.dx_m, up * self.dy_m)
        self._length, self._air = runs[step], self._air_runs(runs)[step]
        # The last node is the additional one of surface().
        self._heads = np.concatenate((self._head, node))
        first = np.concatenate(([0], np.cumsum(inside.sum(axis=1))))
        self._firsts = np.append(first, first[-1] + count).astype(np.int32)

    def _air_runs(self, runs: Floats) -> Floats:
        """Return the air distance of each step; infinite if the wind makes it impossible."""
        problem = self.problem
        air = []
        for run, (across, up) in zip(runs.tolist(), _STEPS, strict=True):
            heading = across * self.dx_m / run, up * self.dy_m / run, run
            flown = air_distance(
                run, run, [heading], problem.frame_wind, problem.aircraft.cruise_speed_m_s
            )
            air.append(math.inf if flown is None else flown)
        return np.array(air)

    def _graph(self, costs: Floats) -> Graph:
        """Return the graph of the grid and the extra node, with the costs of all steps."""
        return Graph(costs, self._heads, self._firsts)


def _widened(
    raster: NDArray[np.bool_], dy_m: float, dx_m: float, margin_m: float
) -> NDArray[np.bool_]:
    """Return the nodes within ``margin_m`` of a true node, (rows, columns) bool.

    SciPy's distances give the same, but SciPy's module of images takes longer to load.
    """
    rows, columns = raster.shape
    before = np.zeros((rows, columns + 1), dtype=np.int64)
    np.cumsum(raster, axis=1, out=before[:, 1:])
    column = np.arange(columns)
    widened = np.zeros(raster.shape, dtype=bool)
    for up in range(min(rows, int(margin_m / dy_m) + 2)):
        near = np.sqrt((up * dy_m) ** 2 + (column * dx_m) ** 2) <= margin_m
        if not near[0]:
            break
        reach = int(near.sum()) - 1
        first, last = np.maximum(column - reach, 0), np.minimum(column + reach + 1, columns)
        # The nodes of a row with a true node up to `reach` columns away.
        along = before[:, last] > before[:, first]
        widened[up:] |= along[: rows - up]
        widened[: rows - up] |= along[up:]
    return widened

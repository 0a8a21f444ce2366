"""The rules of safe flight by dense samples, as an oracle for the strict rule.

Nothing here shares code with the kernels: pieces come from the plain smoothing, everything else
is written from the definition with NumPy and shapely.
"""

import math
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter

from pathgene.host.evaluation.geometry import Arc, smooth
from tests.support.host.zone_oracle import distances


STEP_M = 0.1
#: Violations up to this many metres need not be found.
TOLERANCE_M = 1e-3
_COARSE_M = 4.0
_ACROSS_M = 2.5
_RELATIVE = 1e-6
_GRAVITY = 9.80665
_DENSITY = 1.225


@dataclass
class Findings:
    """Excess of a path over each limit; negative if it has room.

    ``metres`` has excesses in metres by limit, ``shares`` excesses relative to the limit,
    ``corners`` the turns that do not fit.
    """

    metres: dict
    shares: dict
    corners: int

    @property
    def rejected(self):
        return (
            self.corners > 0
            or max(self.metres.values()) > TOLERANCE_M
            or max(self.shares.values()) > _RELATIVE
        )

    @property
    def accepted_with_a_metre(self):
        roomy = max(self.metres.values()) < -1 and max(self.shares.values()) < -0.01
        return roomy and self.corners == 0

    @property
    def near(self):
        return min(abs(value) for value in self.metres.values()) <= 1


def surface(terrain, x, y):
    """Return the greater of nearest node and bilinear height under points; infinite over voids.

    Off the map, the nearest point of its edge is used.
    """
    rows, columns = terrain.elevation.shape
    gx = np.clip(np.asarray(x) / terrain.dx_m, 0, columns - 1)
    gy = np.clip(np.asarray(y) / terrain.dy_m, 0, rows - 1)
    heights = terrain.elevation
    nearest = heights[np.floor(gy + 0.5).astype(int), np.floor(gx + 0.5).astype(int)]
    column, row = np.floor(gx).astype(int), np.floor(gy).astype(int)
    right, up = np.minimum(column + 1, columns - 1), np.minimum(row + 1, rows - 1)
    east, north = gx - column, gy - row
    total = np.zeros_like(east)
    for iy, ix, weight in (
        (row, column, (1 - north) * (1 - east)),
        (row, right, (1 - north) * east),
        (up, column, north * (1 - east)),
        (up, right, north * east),
    ):
        total += np.where(weight > 0, weight * heights[iy, ix], 0.0)
    highest = np.maximum(nearest, total)
    return np.where(np.isnan(nearest) | np.isnan(total), np.inf, highest)


def known_surface(terrain, x, y):
    """Return the surface under points, infinite over voids and off the map."""
    # Coordinates are rounded.
    beyond = 1e-9
    on_x = (x >= -beyond) & (x <= terrain.width_m + beyond)
    on_y = (y >= -beyond) & (y <= terrain.height_m + beyond)
    return np.where(on_x & on_y, surface(terrain, x, y), np.inf)


def examine(problem, path):
    """Return the findings on ``path``, (n, 3), under the rules of ``problem``."""
    rules, aircraft = problem.rules, problem.aircraft
    speed = aircraft.cruise_speed_m_s
    radius = aircraft.turn_radius_m * (1 + math.hypot(*problem.wind) / speed) ** 2
    bank = math.atan(speed**2 / (_GRAVITY * aircraft.turn_radius_m))
    if aircraft.lift_coefficient_max is not None:
        lift = 0.5 * _DENSITY * speed**2 * aircraft.wing_area_m2 * aircraft.lift_coefficient_max
        if lift < aircraft.weight_N / math.cos(bank):
            radius = math.inf
    smoothed = smooth(path, radius, problem.headings)
    metres, shares = {"map": -np.inf}, {"none": -1.0}
    fuel = flown_s = 0.0
    for piece in smoothed.pieces:
        times, air_m, fastest = _flight(piece, problem.wind, speed)
        _look(metres, problem, piece, flown_s + times)
        flown_s += times[-1]
        if piece.rise_m and piece.run_m:
            vertical = fastest * piece.rise_m / piece.run_m
        else:
            vertical = math.copysign(speed, piece.rise_m) if piece.rise_m else 0.0
        climb = speed * math.sin(math.radians(aircraft.max_climb_deg))
        descent = speed * math.sin(math.radians(aircraft.max_descent_deg))
        _worst(shares, "climb", vertical / climb - 1)
        _worst(shares, "descent", -vertical / descent - 1)
        thrust, burned = _burn(aircraft, aircraft.weight_N - fuel, piece, air_m)
        if aircraft.engine_power_W is not None:
            power = thrust * speed / aircraft.propeller_efficiency
            _worst(shares, "power", power / aircraft.engine_power_W - 1)
        fuel += burned
    if aircraft.fuel_weight_N is not None:
        shares["fuel"] = fuel / (aircraft.fuel_weight_N * (1 - rules.reserve)) - 1
    return Findings(metres, shares, smoothed.impossible_arcs)


def _worst(table, name, value):
    table[name] = max(table.get(name, -np.inf), float(value))


def _headings(piece, fractions):
    """Return the unit directions of a piece at fractions of its length."""
    east, north = piece.heading
    angle = getattr(piece, "turn_rad", 0.0) * fractions
    return east * np.cos(angle) - north * np.sin(angle), east * np.sin(angle) + north * np.cos(
        angle
    )


def _flight(piece, wind, speed):
    """Return seconds at 9 places (8 parts), the air distance, and the maximum ground speed."""
    if not any(wind) or piece.run_m == 0:
        seconds = piece.length_m / speed
        return np.linspace(0, seconds, 9), piece.length_m, speed * piece.run_m / piece.length_m

    def ground_speed(fractions):
        east, north = _headings(piece, fractions)
        flat = speed * piece.run_m / piece.length_m
        along, cross = wind[0] * east + wind[1] * north, wind[0] * north - wind[1] * east
        # If the wind cannot be flown, the aircraft stands still, so the time is infinite.
        return np.maximum(along + np.sqrt(np.maximum(flat**2 - cross**2, 0)), 1e-9)

    parts = piece.run_m / 8 / ground_speed((np.arange(8) + 0.5) / 8)
    times = np.concatenate(([0.0], np.cumsum(parts)))
    return times, speed * times[-1], ground_speed(np.linspace(0, 1, 201)).max()


def _burn(aircraft, weight, piece, air_m):
    """Return the maximum thrust on a piece and the fuel burned, computed in small steps."""
    pressure = 0.5 * _DENSITY * aircraft.cruise_speed_m_s**2 * aircraft.wing_area_m2
    cos, sin = piece.run_m / piece.length_m, piece.rise_m / piece.length_m

    def thrust(weight):
        induced = aircraft.induced_drag_factor * (weight * cos) ** 2 / pressure
        return pressure * aircraft.zero_lift_drag_coefficient + induced + weight * sin

    first, full = thrust(weight), weight
    rate = aircraft.specific_fuel_consumption_N_per_Ws / aircraft.propeller_efficiency
    if first <= 0:
        return first, 0.0
    for _ in range(16):
        step = rate * air_m / 16
        middle = weight - 0.5 * step * max(thrust(weight), 0)
        weight = max(weight - step * max(thrust(middle), 0), 0.0)
    return first, full - weight


def _look(metres, problem, piece, times):
    """Record the worst values of a piece with respect to terrain, map, ceilings and zones."""
    parts = max(int(np.ceil(piece.length_m / _COARSE_M)), 1)
    coarse = np.linspace(0, 1, parts + 1)
    points = piece.points(coarse)
    fine = np.linspace(0, 1, int(np.ceil(piece.length_m / parts / STEP_M)) + 1)
    rules, terrain = problem.rules, problem.terrain
    z = points[:, 2]
    places = np.linspace(0, 1, 2001) if isinstance(piece, Arc) else coarse
    x, y, _ = piece.points(places).T
    east, north = _headings(piece, places)
    wide = max(rules.corridor_m - TOLERANCE_M, 0.0) if piece.run_m else 0.0
    for aside in (-wide, wide):
        rim_x, rim_y = x - aside * north, y + aside * east
        off = np.stack((-rim_x, rim_x - terrain.width_m, -rim_y, rim_y - terrain.height_m))
        _worst(metres, "map", off.max())
    ceilings = [c for c in (rules.ceiling_m, problem.aircraft.service_ceiling_m) if c is not None]
    if ceilings:
        _worst(metres, "ceiling", z.max() - min(ceilings))
    _clearance(metres, problem, piece, coarse, points, fine / parts)
    for number, zone in enumerate(problem.zones):
        if metres.get(f"zone {number}", -np.inf) < 1e3:
            _worst(metres, f"zone {number}", _intrusion(problem, zone, piece, times))


def _clearance(metres, problem, piece, coarse, points, fine):
    rules, terrain = problem.rules, problem.terrain
    cells = math.ceil((rules.corridor_m + _COARSE_M) / min(terrain.dx_m, terrain.dy_m)) + 1
    heights = np.where(np.isnan(terrain.elevation), np.inf, terrain.elevation)
    around = maximum_filter(heights, 2 * cells + 1, mode="nearest")
    rows, columns = terrain.shape
    ix = np.clip(np.round(points[:, 0] / terrain.dx_m), 0, columns - 1).astype(int)
    iy = np.clip(np.round(points[:, 1] / terrain.dy_m), 0, rows - 1).astype(int)
    # No point of the corridor around a stretch is above the highest node around.
    room = points[:, 2] - around[iy, ix] - rules.clearance_m
    x, y = points[:, :2].T
    away = np.min((x, terrain.width_m - x, y, terrain.height_m - y), axis=0)
    room = np.where(away < rules.corridor_m + _COARSE_M, -np.inf, room)
    near = np.flatnonzero(np.minimum(room[:-1], room[1:]) < 1.5)
    _worst(metres, "clearance", -1.5)
    if near.size:
        fractions = np.unique((coarse[near, None] + fine).ravel())
        _worst(metres, "clearance", _excess(problem, piece, fractions).max())
    if rules.ceiling_agl_m is not None:
        fractions = np.unique((coarse[:-1, None] + fine).ravel())
        x, y, z = piece.points(fractions).T
        height = z - surface(terrain, x, y)
        _worst(metres, "ceiling-agl", height.max() - rules.ceiling_agl_m)


def _excess(problem, piece, fractions):
    """Return the excess of the corridor around places of a piece over the allowed height."""
    rules, terrain, aircraft = problem.rules, problem.terrain, problem.aircraft
    x, y, z = piece.points(fractions).T
    required = np.full(x.shape, rules.clearance_m)
    below = required.copy()
    for end, degrees in (
        (problem.start, aircraft.max_climb_deg),
        (problem.goal, aircraft.max_descent_deg),
    ):
        height, beside = (end[2] - ground for ground in _around(problem, end))
        away = np.hypot(x - end[0], y - end[1]) * 0.5 * math.tan(math.radians(degrees))
        required = np.minimum(required, max(beside, -rules.corridor_m) + away)
        below = np.minimum(below, height + away)
    east, north = _headings(piece, fractions)
    # Rounding at the very edge of the corridor proves nothing.
    wide = max(rules.corridor_m - TOLERANCE_M, 0.0)
    spacing = min(_ACROSS_M, 0.25 * terrain.dx_m, 0.25 * terrain.dy_m)
    asides = np.linspace(-wide, wide, 2 * math.ceil(wide / spacing) + 1)
    highest = known_surface(terrain, x, y)
    for aside in (*asides, *_borders(terrain, x, y, east, north, wide)) if piece.run_m else ():
        highest = np.maximum(highest, known_surface(terrain, x - aside * north, y + aside * east))
    return np.maximum(highest + required, known_surface(terrain, x, y) + below) - z


def _borders(terrain, x, y, east, north, wide):
    """Yield where lines across a track, ``wide`` to either side, cross a border.

    At the borders of the squares of nodes, and of the squares between nodes, the surface has its
    steps and edges; within a square it is smooth. Each item is a value for every place, just before
    and after the border.
    """
    for place, across, side in ((x, -north, terrain.dx_m), (y, east, terrain.dy_m)):
        half = 0.5 * side
        first = np.ceil((place - wide) / half)
        with np.errstate(divide="ignore", invalid="ignore"):
            for number in range(math.ceil(2 * wide / half) + 1):
                aside = ((first + number) * half - place) / across
                for shifted in (aside - 1e-6, aside + 1e-6):
                    yield np.clip(np.nan_to_num(shifted), -wide, wide)


def _around(problem, end):
    """Return the surface below an end, and the highest within the corridor and on the map.

    Ground that is unknown must not lower the requirement.
    """
    x, y = np.array([end[0]]), np.array([end[1]])
    own = surface(problem.terrain, x, y)[0]
    corridor = problem.rules.corridor_m
    angles = np.linspace(0, 2 * np.pi, 36001)
    around = own
    for radius in (corridor - 1e-6, corridor, corridor + 1e-6):
        rim = surface(problem.terrain, x + radius * np.cos(angles), y + radius * np.sin(angles))
        around = max(around, rim.max())
    # Inside, no place is higher than the highest node whose square the circle meets.
    terrain = problem.terrain
    rows, columns = terrain.shape
    gap_x = np.abs(np.arange(columns) * terrain.dx_m - end[0]) - terrain.dx_m / 2
    gap_y = np.abs(np.arange(rows) * terrain.dy_m - end[1]) - terrain.dy_m / 2
    met = np.hypot(np.maximum(gap_x, 0), np.maximum(gap_y, 0)[:, None]) <= corridor
    nodes = terrain.elevation[met]
    around = max(around, np.where(np.isnan(nodes), np.inf, nodes).max(initial=-np.inf))
    # No height of an end next to a void would lower the requirement.
    return (own if math.isfinite(own) else end[2]), (around if math.isfinite(around) else end[2])


def _intrusion(problem, zone, piece, times):
    """Return how deep a piece comes into a widened zone, in metres; negative outside."""
    margin = problem.rules.zone_margin_m
    parts = max(int(np.ceil(piece.length_m / _COARSE_M)), 1)
    coarse = np.linspace(0, 1, parts + 1)
    gaps = distances(zone, *piece.points(coarse)[:, :2].T)
    near = np.flatnonzero(np.minimum(gaps[:-1], gaps[1:]) <= margin + 1.5 + _COARSE_M)
    if not near.size:
        return -1.5
    fine = np.linspace(0, 1, int(np.ceil(piece.length_m / parts / STEP_M)) + 1) / parts
    fractions = np.unique((coarse[near, None] + fine).ravel())
    x, y, z = piece.points(fractions).T
    depth = margin - distances(zone, x, y)
    if zone.lower_m is not None:
        depth = np.minimum(depth, z - (zone.lower_m - margin))
    if zone.upper_m is not None:
        depth = np.minimum(depth, zone.upper_m + margin - z)
    seconds = np.interp(fractions, np.linspace(0, 1, 9), times)
    # A metre to spare in time is a metre flown at the speed through the air.
    second = 1 / problem.aircraft.cruise_speed_m_s
    if zone.t0_s is not None:
        depth = np.where(seconds < zone.t0_s - second, -np.inf, depth)
        depth = np.where(seconds < zone.t0_s, np.minimum(depth, 0.0), depth)
    if zone.t1_s is not None:
        depth = np.where(seconds > zone.t1_s + second, -np.inf, depth)
        depth = np.where(seconds > zone.t1_s, np.minimum(depth, 0.0), depth)
    return float(depth.max())

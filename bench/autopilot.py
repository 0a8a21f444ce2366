"""The simulated autopilot beside flights of a real one: the same missions from the same place.

A folder of flights has one folder a flight: ``mission.waypoints`` as it was uploaded, ``track.csv``
with the true track, ``events.txt`` with the autopilot's messages, and ``conditions.txt`` with the
wind and the airspeed. Every constant is a published one and the same for all flights; the direction
of the wind, which the conditions leave out, is estimated from the ground speeds of the track.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bench.report import Options, Report
from pathgene.host.errors import InputError
from pathgene.sim.autopilot.airframe import SIMULATED_PLANE, eas2tas
from pathgene.sim.autopilot.flown import Flown
from pathgene.sim.autopilot.items import Command, Item
from pathgene.sim.autopilot.parameters import ARDUPLANE, Parameters
from pathgene.sim.autopilot.parameters import SIMULATED_PLANE as SIMULATED_PARAMETERS
from pathgene.sim.autopilot.pilot import Kind, Pilot, start_vehicle
from pathgene.sim.autopilot.places import Plane
from pathgene.sim.autopilot.targets import Earth
from pathgene.sim.autopilot.vehicle import PERIOD_S
from pathgene.sim.autopilot.wind import Wind


__all__ = ["ALLOWED", "RealFlight", "figures", "fly", "from_legs", "read_flight", "run"]

#: Allowed difference of the double from the flight, as a share.
ALLOWED = 0.3
# Legs that rise or fall by this slope count as climbs or descents.
_SLOPE = 0.05
# The last seconds of a flight, in which the loiter is steady.
_STEADY_S = 10.0
# Starts of the double, displaced along the track over the way of a tick: whether a waypoint is
# passed or flown back to depends on where the ticks fall.
_PHASES = 8
# The simulator's turbulence: a standard deviation of 1 m/s for each unit, decaying in 0.04 s.
_TURBULENCE_S = 0.04
# Largest distance off the track of a flight without a circle.
_OFF_M = 60.0

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RealFlight:
    """A flight of a real autopilot.

    Parameters
    ----------
    items : list of Item
        The mission, home first.
    home_m : float
        Altitude of home, AMSL.
    airspeed_m_s : float
        Demanded equivalent airspeed.
    """

    name: str
    items: list[Item]
    plane: Plane
    home_m: float
    airspeed_m_s: float
    wind: Wind
    flown: Flown

    @property
    def waypoints(self) -> Array:
        """Return (n, 3) metres east, north and AMSL of all items."""
        places = [self.plane.local(item.lat, item.lon) for item in self.items]
        return np.array([(*place, item.z) for place, item in zip(places, self.items, strict=True)])


def read_items(path: Path) -> list[Item]:
    """Return the items of a file of QGC WPL 110."""
    items = []
    for row in csv.reader(path.read_text().splitlines()[1:], delimiter="\t"):
        first, second, third, fourth, lat, lon, z = map(float, row[4:11])
        params = (first, second, third, fourth)
        place = round(lat * 1e7), round(lon * 1e7)
        items.append(Item(int(row[3]), int(row[2]), params, *place, z))
    return items


def read_flight(folder: Path) -> RealFlight:
    """Return the flight of a folder."""
    items = read_items(folder / "mission.waypoints")
    plane = Plane(items[0].lat, items[0].lon)
    with (folder / "track.csv").open() as file:
        rows = list(csv.DictReader(file))

    def column(name: str) -> Array:
        return np.array([float(row[name]) for row in rows])

    time_s, altitude = column("t_s"), column("alt_amsl_m")
    places = zip(column("lat").tolist(), column("lon").tolist(), strict=True)
    place = np.array([plane.local(lat, lon) for lat, lon in places])
    begun = re.findall(r"^([\d.]+) Mission: (\d+)", (folder / "events.txt").read_text(), re.M)
    times = np.array([float(begin) for begin, _ in begun])
    numbers = np.array([int(number) for _, number in begun])
    index = numbers[np.clip(np.searchsorted(times, time_s, side="right") - 1, 0, None)]
    conditions = (folder / "conditions.txt").read_text()
    speed = re.search(r"AIRSPEED(?:_CRUISE)? (\d+)", conditions)
    if speed is None:
        raise InputError(f"{folder}/conditions.txt states no AIRSPEED.")
    airspeed = float(speed.group(1))
    flown = Flown(time_s, place, altitude, column("roll_deg"), index)
    wind = Wind()
    blown = re.search(r"wind ([\d.]+) m/s(?:, SIM_WIND_TURB (\d+))?", conditions)
    if blown is not None:
        east, north = _wind(flown, airspeed)
        size = float(blown.group(1)) / math.hypot(east, north)
        gusts = float(blown.group(2) or 0)
        wind = Wind(east * size, north * size, gusts, up=1.0, gust_s=_TURBULENCE_S)
    home_m = float(np.median(altitude - column("tecs_height_m")))
    return RealFlight(folder.name, items, plane, home_m, airspeed, wind, flown)


def _wind(flown: Flown, airspeed_m_s: float) -> tuple[float, float]:
    """Return the wind for which all ground speeds agree best with the airspeed."""
    velocity = np.gradient(flown.place, flown.time_s, axis=0)
    true = airspeed_m_s * np.array([eas2tas(z) ** 2 for z in flown.altitude_m.tolist()])
    wind = np.zeros(2)
    for _ in range(20):
        through = velocity - wind
        speed = np.hypot(*through.T)
        step, *_ = np.linalg.lstsq(-through / speed[:, None], true - speed, rcond=None)
        wind += step
    return float(wind[0]), float(wind[1])


def fly(
    real: RealFlight, shift_m: float = 0.0, changes: Mapping[str, float] | None = None
) -> Flown:
    """Return the double's flight of the same mission.

    Parameters
    ----------
    shift_m : float
        Distance by which the double starts farther back than the real flight.
    changes : mapping, optional
        Parameters in which the double differs from the real flight.
    """
    track = real.flown
    steps = int(np.searchsorted(track.time_s, track.time_s[0] + 0.6))
    velocity = (track.place[steps] - track.place[0]) / (track.time_s[steps] - track.time_s[0])
    air = velocity - (real.wind.east_m_s, real.wind.north_m_s)
    start = track.place[0] - shift_m * velocity / np.hypot(*velocity)
    parameters = Parameters(
        ARDUPLANE,
        SIMULATED_PARAMETERS,
        {"AIRSPEED_CRUISE": real.airspeed_m_s},
        changes or {},
    )
    vehicle = start_vehicle(
        Kind.ARDUPLANE,
        parameters,
        SIMULATED_PLANE,
        real.wind,
        place=(float(start[0]), float(start[1]), float(track.altitude_m[0])),
        heading_rad=math.atan2(*air),
        airspeed_m_s=float(np.hypot(*air)),
    )
    earth = Earth(real.plane, real.home_m, lambda _place: real.home_m)
    pilot = Pilot(Kind.ARDUPLANE, parameters, vehicle, earth, lambda: real.items)
    pilot.fly_mission()
    rows = []
    last = track.index[-1]
    # As long in the final loiter as the real flight.
    left_s = float(track.time_s[-1] - track.time_s[track.index == last][0])
    while left_s > 0 and pilot.time_s < 3 * track.time_s[-1]:
        pilot.tick()
        if pilot.sequencer.index == last:
            left_s -= PERIOD_S
        rows.append(
            (
                *(pilot.time_s, *vehicle.place, vehicle.altitude_m),
                *(math.degrees(vehicle.roll_rad), pilot.sequencer.index),
            )
        )
    table = np.array(rows)
    return Flown(table[:, 0], table[:, 1:3], table[:, 3], table[:, 4], table[:, 5].astype(np.int64))


def figures(real: RealFlight, flown: Flown) -> dict[str, float]:
    """Return the figures of a flight that are compared, by name.

    Distances and heights count from the first waypoint on and before the final loiter. Missing:
    climbs, descents and circles that the flight has none of.
    """
    waypoints = real.waypoints
    final = len(real.items) - 1
    under_way = (flown.index > 1) & (flown.index < final)
    off, above, slope = from_legs(flown, waypoints)
    off, above, slope = off[under_way], above[under_way], slope[under_way]
    is_circle = off > _OFF_M
    begins = flown.time_s[under_way]
    calm = np.ones(len(off), bool)
    if is_circle.any():
        first, last = begins[is_circle][[0, -1]]
        calm = (begins < first - 15) | (begins > last + 30)
    made = {
        "cross-track rms, m": float(np.sqrt(np.mean(off[calm] ** 2))),
        "time to the last waypoint, s": float(begins[-1] - begins[0]),
    }
    up, down = calm & (slope > _SLOPE), calm & (slope < -_SLOPE)
    if up.sum() * np.median(np.diff(flown.time_s)) > 20:
        made["under the line in climbs, m"] = float(-np.median(above[up]))
    if down.sum() * np.median(np.diff(flown.time_s)) > 20:
        made["over the line in descents, m"] = float(np.median(above[down]))
    away = np.hypot(*(flown.place - waypoints[-1, :2]).T)
    steady = flown.time_s > flown.time_s[-1] - _STEADY_S
    if real.items[-1].command == Command.LOITER:
        made["loiter radius, m"] = float(away[steady].mean())
        made["widest at entry, m"] = float(away[flown.index == final].max())
        made["bank in the loiter, deg"] = float(np.abs(flown.roll_deg[steady]).mean())
    made["largest bank, deg"] = float(np.abs(flown.roll_deg[flown.index > 1]).max())
    if is_circle.any():
        first, last = begins[is_circle][[0, -1]]
        inside = (begins >= first - 2) & (begins <= last)
        made["circle: off the track, m"] = float(off.max())
        made["circle: bank, deg"] = float(np.abs(flown.roll_deg[under_way][inside]).mean())
    return made


def from_legs(flown: Flown, waypoints: Array) -> tuple[Array, Array, Array]:
    """Return each place's distance from the nearest leg, its height over it, and the leg's slope.

    Only the legs around the item under way count.
    """
    off, above, slope = (np.empty(len(flown.time_s)) for _ in range(3))
    for row, (place, z, index) in enumerate(
        zip(flown.place, flown.altitude_m, flown.index, strict=True)
    ):
        off[row] = math.inf
        for stop in range(max(index - 2, 2), min(index + 2, len(waypoints))):
            start, end = waypoints[stop - 1], waypoints[stop]
            leg = end[:2] - start[:2]
            length = math.hypot(*leg)
            if length < 1e-3:
                continue
            share = min(max(float((place - start[:2]) @ leg) / length**2, 0.0), 1.0)
            gap = math.hypot(*(place - start[:2] - share * leg))
            if gap < off[row]:
                off[row] = gap
                above[row] = z - (start[2] + share * (end[2] - start[2]))
                slope[row] = (end[2] - start[2]) / length
    return off, above, slope


def compare(
    real: RealFlight, phases: int = _PHASES, changes: Mapping[str, float] | None = None
) -> list[tuple[str, str, float, float, float]]:
    """Return flight, quantity, real, double and the double's share more or less, a row each.

    The double's figure is the median over starts at different phases of its ticks.

    Parameters
    ----------
    phases : int
        Number of these starts.
    changes : mapping, optional
        Parameters in which the double differs from the real flight.
    """
    measured = figures(real, real.flown)
    speed = float(np.median(np.hypot(*np.gradient(real.flown.place, real.flown.time_s, axis=0).T)))
    shifts = np.arange(phases) * speed * PERIOD_S / phases
    flights = [figures(real, fly(real, float(shift), changes)) for shift in shifts]
    rows = []
    for name, value in measured.items():
        doubles = [flight[name] for flight in flights if name in flight]
        double = float(np.median(doubles)) if doubles else math.nan
        rows.append((real.name, name, value, double, double / value - 1))
    return rows


def run(options: Options) -> Report:
    """Fly every mission of the folder of flights and compare."""
    if options.flights is None:
        raise InputError("Name the folder of real flights (--flights FOLDER).")
    report = Report(
        "The simulated autopilot beside real flights",
        ["flight", "quantity", "real", "double", "difference"],
    )
    worst = 0.0
    for folder in sorted(options.flights.iterdir()):
        if not (folder / "track.csv").exists():
            continue
        for name, quantity, real, double, difference in compare(read_flight(folder)):
            report.rows.append(
                (name, quantity, round(real, 2), round(double, 2), f"{100 * difference:+.0f} %")
            )
            worst = max(worst, abs(difference)) if math.isfinite(difference) else math.inf
    report.notes.append(
        f"Medians over {_PHASES} starts of the double, displaced along the track over the way of a "
        f"tick. The largest difference is {100 * worst:.0f} %, {100 * ALLOWED:.0f} % are allowed."
    )
    return report

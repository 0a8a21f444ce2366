"""Tracks and terrains of the flights."""

import math

import numpy as np
import pytest

from pathgene.host.evaluation.geometry import Arc, Straight
from pathgene.host.flight.flight import Flight, fly_track
from pathgene.host.flight.models import MODELS
from pathgene.host.problem import aircraft
from pathgene.host.terrain import Terrain


@pytest.fixture(scope="session")
def flat():
    """A plain at sea level, 20 x 20 km."""
    return Terrain("plain", np.zeros((201, 201)), 100, 100)


def straight(start, length_m, heading_deg=90.0, rise_m=0.0):
    """A straight line with a heading clockwise from north."""
    angle = math.radians(heading_deg)
    east, north = math.sin(angle), math.cos(angle)
    x, y, z = start
    stop = (x + length_m * east, y + length_m * north, z + rise_m)
    return Straight(start, stop, (east, north), length_m, rise_m)


def arc(start, radius_m, turn_deg, heading_deg=90.0):
    angle = math.radians(heading_deg)
    return Arc(start, (math.sin(angle), math.cos(angle)), radius_m, math.radians(turn_deg), 0.0)


def flown(terrain, pieces, name="silver-fox", wind=(0.0, 0.0), **options):
    """Fly pieces with the model of that name."""
    figures = aircraft.load(name)
    flight = Flight(pieces, terrain, figures, MODELS[name], wind=wind, **options)
    speed = figures.cruise_speed_m_s
    return fly_track(flight, speed, speed - math.hypot(*wind))

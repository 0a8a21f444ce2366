"""The International Standard Atmosphere: density of the air by altitude."""

from __future__ import annotations

import math


__all__ = ["SEA_LEVEL_DENSITY_KG_M3", "air_density", "equivalent_m_s", "true_m_s"]

SEA_LEVEL_DENSITY_KG_M3 = 1.225


def air_density(altitude_m: float) -> float:
    """Return the density of the International Standard Atmosphere, kg/m^3, up to 20 km.

    Altitudes are geopotential. Troposphere below 11 km, isothermal above.
    """
    lapse_k_m, exponent, tropopause_m = 0.0065, 4.255876, 11_000.0
    density = SEA_LEVEL_DENSITY_KG_M3 * math.pow(
        1.0 - lapse_k_m * min(altitude_m, tropopause_m) / 288.15, exponent
    )
    if altitude_m > tropopause_m:
        density *= math.exp(-(altitude_m - tropopause_m) / 6341.62)
    return density


def equivalent_m_s(true_m_s: float, altitude_m: float) -> float:
    """Return the equivalent airspeed of a true one at an altitude."""
    return true_m_s * math.sqrt(air_density(altitude_m) / SEA_LEVEL_DENSITY_KG_M3)


def true_m_s(equivalent_m_s: float, altitude_m: float) -> float:
    """Return the true airspeed of an equivalent one at an altitude."""
    return equivalent_m_s * math.sqrt(SEA_LEVEL_DENSITY_KG_M3 / air_density(altitude_m))

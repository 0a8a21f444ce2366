"""The frame of a terrain on Earth: a reference system of true metres with north up."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from rasterio.crs import CRS

from pathgene.host.errors import InputError
from pathgene.host.remarks import Grade, Remark
from pathgene.host.terrain import geodesy, warp
from pathgene.host.terrain.metric import Metric, measure, measure_at
from pathgene.host.terrain.raster import Raster


__all__ = ["Framed", "framed"]

Floats = NDArray[np.float64]

# UTM ends at this latitude, degrees.
_UTM_ENDS_DEG = 84.0
# Width of a local frame over which its metres differ by 0.1 %, and from their mean by 0.05 %.
_WIDEST_KM = 560
# Side of the cross by which UTM is measured, metres.
_CROSS_M = 100.0


@dataclass(frozen=True)
class Framed:
    """A raster in the frame of its terrain.

    Parameters
    ----------
    raster : Raster
        Heights in a projected reference system.
    metres_per_unit : tuple of float
        Metres on the ground for a unit of the system, east and north.
    is_warped : bool
        Whether the raster was in a different system.
    remarks : tuple of Remark
        Remarks on the projection.
    """

    raster: Raster
    metres_per_unit: tuple[float, float]
    is_warped: bool
    remarks: tuple[Remark, ...] = ()


def framed(raster: Raster, max_cells: int | None) -> Framed:
    """Return a raster in a metric system with north up, warped if its own system is different.

    A geographic raster is shown in its UTM zone if that is such a system, otherwise in a local one.
    A projected raster stays unchanged, or is shown in a local system.

    Parameters
    ----------
    raster : Raster
        North up along its own axes, with a reference system.
    max_cells : int, optional
        As for :func:`pathgene.host.terrain.warp.to_frame`.

    Raises
    ------
    InputError
        If the system is neither geographic nor projected, the raster lies outside it, or the raster
        is so large that metres of a local frame differ by more than 0.1 % over it.
    """
    crs = raster.crs
    assert crs is not None
    if crs.is_geographic:
        return _warped(raster, _of_degrees(raster), max_cells, ())
    name = geodesy.crs_name(crs)
    if not crs.is_projected:
        raise InputError(
            f"{raster.name}: {geodesy.its_crs(crs)} is neither geographic nor "
            "projected, so it has no map; warp it first (gdalwarp -t_srs EPSG:4326 IN.tif OUT.tif)."
        )
    rows, columns = raster.heights.shape
    side = raster.transform
    first_x, first_y = side.c + 0.5 * side.a, side.f + 0.5 * side.e
    last_x, last_y = first_x + (columns - 1) * side.a, first_y + (rows - 1) * side.e
    try:
        metric = measure(name, (first_x, last_x), (first_y, last_y), (side.a, side.e))
        if not (np.isfinite(metric.east_m).all() and np.isfinite(metric.north_m).all()):
            raise InputError("")
    except InputError:
        raise InputError(
            f"{raster.name}: a part of it lies where {geodesy.its_crs(crs)} is no map "
            f"of the Earth, between {first_x:g}, {last_y:g} and {last_x:g}, {first_y:g}; check the "
            "system and the place that the file states."
        ) from None
    if metric.is_metric and metric.is_north_up:
        return Framed(raster, metric.middle, is_warped=False, remarks=_kept(metric, crs))
    middle_x, middle_y = 0.5 * (first_x + last_x), 0.5 * (first_y + last_y)
    lon, lat = geodesy.place_points(name, geodesy.WGS84, np.array([middle_x]), np.array([middle_y]))
    return _warped(
        raster, geodesy.local_crs(float(lat[0]), float(lon[0])), max_cells, (_why(metric, crs),)
    )


def _of_degrees(raster: Raster) -> str:
    """Return the frame of a geographic raster: its UTM zone, or a local system."""
    assert raster.crs is not None
    rows, columns = raster.heights.shape
    side, name = raster.transform, geodesy.crs_name(raster.crs)
    x = side.c + side.a * np.array((0.5, 0.5 * columns, columns - 0.5))
    y = side.f + side.e * np.array((rows - 0.5, 0.5 * rows, 0.5))
    lon, lat = (each.ravel() for each in np.meshgrid(x, y))
    if name != geodesy.WGS84:
        lon, lat = geodesy.place_points(name, geodesy.WGS84, lon, lat)
    middle = float(np.clip(lat[4], -90, 90)), (float(lon[4]) + 180.0) % 360.0 - 180.0
    if np.abs(lat).max() <= _UTM_ENDS_DEG:
        zone = geodesy.utm_zone(*middle)
        try:
            east, north = geodesy.place_points(geodesy.WGS84, zone, lon, lat)
            metric = measure_at(zone, east, north, (_CROSS_M, _CROSS_M))
        except InputError:
            return geodesy.local_crs(*middle)
        if metric.is_metric and metric.is_north_up:
            return zone
    return geodesy.local_crs(*middle)


def _warped(
    raster: Raster, frame: str, max_cells: int | None, remarks: tuple[Remark, ...]
) -> Framed:
    """Return a raster in a different system, with that system's measure."""
    shown = warp.to_frame(raster, frame, max_cells)
    rows, columns = shown.heights.shape
    side = shown.transform
    metric = measure(
        frame,
        (side.c + 0.5 * side.a, side.c + (columns - 0.5) * side.a),
        (side.f + 0.5 * side.e, side.f + (rows - 0.5) * side.e),
        (side.a, side.e),
    )
    scale = metric.middle if metric.is_metric else (metric.between,) * 2
    if scale[0] is None or scale[1] is None:
        width_km, height_km = (1e-3 * count * side.a for count in (columns, rows))
        raise InputError(
            f"{raster.name}: is {width_km:.0f} x {height_km:.0f} km large, and over so large a map "
            f"metres differ by {metric.spread:.2%}; cut out the part you need, at most about "
            f"{_WIDEST_KM:g} km from west to east."
        )
    if metric.is_north_up:
        remarks = (*remarks, *_turned(metric))
    return Framed(
        replace(shown, crs=CRS.from_user_input(frame)), (scale[0], scale[1]), is_warped=True,
        remarks=remarks,
    )  # fmt: skip


def _kept(metric: Metric, crs: CRS) -> tuple[Remark, ...]:
    unit_m = geodesy.unit_m(geodesy.crs_name(crs))
    east, north = (length / unit_m for length in metric.middle)
    notes = _turned(metric)
    if max(abs(east - 1), abs(north - 1)) <= 1e-5:
        return notes
    scales = f"{east:.5f}" if east == north else f"{east:.5f} east and {north:.5f} north"
    return (
        Remark(
            Grade.NOTE,
            f"A metre of {geodesy.crs_short(crs)} is {scales} m on the ground here; "
            "cells have their true size.",
        ),
        *notes,
    )


def _turned(metric: Metric) -> tuple[Remark, ...]:
    """Return the note on grid north if it differs from true north."""
    degrees = metric.convergence_at_middle_deg
    if abs(degrees) <= 0.1:
        return ()
    side = "east" if degrees > 0 else "west"
    return (
        Remark(
            Grade.NOTE,
            f"Grid north lies {abs(degrees):.2f} degrees {side} of true north at the map's middle; "
            "winds and headings count from true north.",
        ),
    )


def _why(metric: Metric, crs: CRS) -> Remark:
    """Return the note on a system that is replaced."""
    if metric.spread > 0.0005:
        cause = f"its metres differ by {metric.spread:.2%} over the map or between its axes"
    elif not metric.is_north_up:
        cause = f"its north lies {abs(metric.convergence_at_middle_deg):.0f} degrees off true north"
    else:
        cause = "its axes are not at right angles"
    unit_m = geodesy.unit_m(geodesy.crs_name(crs))
    return Remark(
        Grade.NOTE,
        f"The map is warped from {geodesy.crs_short(crs)} to a local frame, because {cause}; "
        f"a metre of it is {metric.middle[0] / unit_m:.4f} m on the ground at the middle.",
    )

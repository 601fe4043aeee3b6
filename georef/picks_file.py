"""Picks as a table (CSV), one pick a row, with a header.

====================================  ==================================================================
``u_px, v_px``                        the pixel; the first pixel's centre is (0, 0)
``name``                              optional, for messages
``x_m, y_m, z_m``                     the place: east, north and, optionally, height in local metres; or
``latitude_deg, longitude_deg, z_m``  the same in WGS84; or
``feature``                           a feature of the map: ``lamp/west_in/2``, or ``stop/west_in#2`` for the second
                                      corner of a line or an area; a line without ``#``: anywhere along it
``x2_m, y2_m, z2_m``                  optional: the pixel lies anywhere on the straight line from the place to
``latitude2_deg, longitude2_deg``     this second one
``sigma_m``                           optional: standard deviation per axis of the map's place; 0 if not given
====================================  ==================================================================

Kinds of places may be mixed row by row; empty cells count as not given.
"""

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contracts import FloatArray, InputError
from georef.geo_reference import GeoReference
from georef.hd_map import Area, Feature, HdMap, Line, Link, Point
from georef.picks import LinePicks, PointPicks

_NUMBERS = (
    *("u_px", "v_px", "x_m", "y_m", "z_m", "latitude_deg", "longitude_deg", "sigma_m"),
    *("x2_m", "y2_m", "z2_m", "latitude2_deg", "longitude2_deg"),
)
COLUMNS = ("name", *_NUMBERS, "feature")
_BORDER_PX = 1.0  # beyond the image's edge: rounding, and programs that count from elsewhere


@dataclass(frozen=True)
class _Row:
    """One row; messages begin with its file and line."""

    where: str
    cells: dict[str, str]

    def number(self, column: str) -> float | None:
        text = self.cells.get(column, "")
        if not text:
            return None
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise InputError(f'{self.where}, column {column}: "{text}" is no number')
        return value

    def required(self, column: str) -> float:
        value = self.number(column)
        if value is None:
            raise InputError(f"{self.where}, column {column}: is empty")
        return value


@dataclass(frozen=True, eq=False)
class PicksFile:
    """Points, pixels on lines, and where on the Earth the local metres begin, if the file or the map says so."""

    points: PointPicks
    lines: LinePicks
    geo: GeoReference | None


def read_picks(
    path: Path | str,
    *,
    hd_map: HdMap | None = None,
    geo: GeoReference | None = None,
    size_px: tuple[int, int] | None = None,
) -> PicksFile:
    """The picks in the table at ``path``.

    hd_map: for rows that name a feature. geo: of the local metres; the map's own if there is one, else the first WGS84
    place of the file is taken as the origin. size_px: width and height of the image in which they must lie.
    Raises InputError naming file, line and column of what is wrong.
    """
    rows = read_table(path, COLUMNS, required=("u_px", "v_px"))
    geo = hd_map.geo if hd_map else geo or _first_place(rows)
    features = {feature.id: feature for feature in hd_map.features()} if hd_map else None
    names, pixels, places, sigmas = [], [], [], []
    for number, row in enumerate(rows):
        names.append(row.cells.get("name") or row.cells.get("feature") or f"pick {number + 1}")
        pixels.append(_pixel(row, size_px))
        places.append(_place(row, geo, features))
        sigma = row.number("sigma_m") or 0.0
        if sigma < 0:
            raise InputError(f"{row.where}, column sigma_m: {sigma:g} must not be negative")
        sigmas.append(sigma)
    on_line = np.array([len(place) > 1 for place in places], dtype=bool)
    pixels_px, sigmas_m = np.array(pixels).reshape(-1, 2), np.array(sigmas)
    points = np.array([place[0] for place in places if len(place) == 1]).reshape(-1, 3)
    return PicksFile(
        PointPicks(
            tuple(n for n, line in zip(names, on_line, strict=True) if not line),
            pixels_px[~on_line],
            points,
            sigmas_m[~on_line],
        ),
        LinePicks(
            tuple(n for n, line in zip(names, on_line, strict=True) if line),
            pixels_px[on_line],
            tuple(place for place in places if len(place) > 1),
            sigmas_m[on_line],
        ),
        geo,
    )


def read_table(path: Path | str, columns: tuple[str, ...], required: tuple[str, ...]) -> list[_Row]:
    """Rows of a CSV file whose header holds ``required`` and nothing beside ``columns``. Raises InputError."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is no UTF-8 text, so no table") from error
    reader = csv.reader(text.splitlines())
    header = [cell.strip() for cell in next(reader, [])]
    for column in required:
        if column not in header:
            raise InputError(f"{path}, line 1: the column {column} is missing; accepted are {', '.join(columns)}")
    for column in header:
        if column not in columns or header.count(column) > 1:
            what = "is there twice" if column in columns else f"is not known; accepted are {', '.join(columns)}"
            raise InputError(f'{path}, line 1: the column "{column}" {what}')
    rows = []
    for cells in reader:
        where = f"{path}, line {reader.line_num}"
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(header):
            raise InputError(f"{where}: has {len(cells)} cells, but the header names {len(header)} columns")
        rows.append(_Row(where, {name: cell.strip() for name, cell in zip(header, cells, strict=True)}))
    if not rows:
        raise InputError(f"{path}: holds no row below its header")
    return rows


def _first_place(rows: list[_Row]) -> GeoReference | None:
    for row in rows:
        latitude, longitude = row.number("latitude_deg"), row.number("longitude_deg")
        if latitude is not None and longitude is not None:
            try:
                return GeoReference(latitude, longitude)
            except InputError as error:
                raise InputError(f"{row.where}: {error}") from error
    return None


def _pixel(row: _Row, size_px: tuple[int, int] | None) -> tuple[float, float]:
    u_px, v_px = row.required("u_px"), row.required("v_px")
    if size_px is not None:
        width, height = size_px
        beyond = 0.5 + _BORDER_PX
        if not (-beyond <= u_px <= width - 1 + beyond and -beyond <= v_px <= height - 1 + beyond):
            raise InputError(f"{row.where}: the pixel {u_px:g}, {v_px:g} lies outside the image of {width}x{height}")
    return u_px, v_px


def _place(row: _Row, geo: GeoReference | None, features: Mapping[str, Feature] | None) -> FloatArray:
    """(1, 3) a point, or (M, 3) a line."""
    ways = {
        "x_m and y_m": ("x_m", "y_m"),
        "latitude_deg and longitude_deg": ("latitude_deg", "longitude_deg"),
        "feature": ("feature",),
    }
    given = [name for name, columns in ways.items() if any(row.cells.get(column) for column in columns)]
    if len(given) != 1:
        raise InputError(f"{row.where}: give the place by one of {'; '.join(ways)}; {len(given)} are given")
    if given == ["feature"]:
        return _of_map(row, features)
    first = _position(row, geo, "")
    if not any(row.cells.get(column) for column in ("x2_m", "y2_m", "latitude2_deg", "longitude2_deg")):
        return first[None]
    second = _position(row, geo, "2")
    if not np.linalg.norm(second - first) > 0:
        raise InputError(f"{row.where}: the line's two places are one and the same")
    return np.stack([first, second])


def _position(row: _Row, geo: GeoReference | None, which: str) -> FloatArray:
    height = row.number(f"z{which}_m") or 0.0
    if row.cells.get(f"x{which}_m") or row.cells.get(f"y{which}_m"):
        return np.array([row.required(f"x{which}_m"), row.required(f"y{which}_m"), height])
    place = row.required(f"latitude{which}_deg"), row.required(f"longitude{which}_deg")
    assert geo is not None  # a file with such a place has an origin at least there
    try:
        return np.append(geo.to_local(place), height)
    except InputError as error:
        raise InputError(f"{row.where}: {error}") from error


def _of_map(row: _Row, features: Mapping[str, Feature] | None) -> FloatArray:
    told = row.cells["feature"]
    if features is None:
        raise InputError(f'{row.where}, column feature: "{told}" needs a map, and none is given')
    name, _, corner = told.partition("#") if told not in features else (told, "", "")
    feature = features.get(name)
    if feature is None or isinstance(feature, Link):
        raise InputError(f'{row.where}, column feature: the map has no point, line or area "{name}"')
    if isinstance(feature, Point):
        return np.asarray(feature.position_m)[None]
    places = feature.points_m if isinstance(feature, Line) else feature.ring_m
    if not corner:
        if isinstance(feature, Area):
            raise InputError(f'{row.where}, column feature: name a corner of the area: "{name}#1" to #{len(places)}')
        return places
    if not corner.isdecimal() or not 1 <= int(corner) <= len(places):
        raise InputError(f'{row.where}, column feature: "{name}" has the corners #1 to #{len(places)}, not "#{corner}"')
    return np.asarray(places[int(corner) - 1], dtype=np.float64)[None]

"""The HD map as GeoJSON: WGS84 coordinates as RFC 7946 wants them, one feature per line, point, area, node and link.

``properties.table`` names the table, the other properties are the feature's own fields. A link has no geometry of its
own (``null``): it lies where its lanes lie. The member ``origin`` of the collection says where the local metres begin.
"""

import json
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

import msgspec
import numpy as np

from contracts import FloatArray, InputError
from contracts.files import write_whole
from georef.geo_reference import GeoReference
from georef.hd_map import Area, Feature, HdMap, Line, Link

_T = TypeVar("_T")
_TABLES: dict[str, type[Feature]] = {
    name: get_args(hint)[0] for name, hint in get_type_hints(HdMap).items() if name != "geo"
}
_GEOMETRY = {Line: ("points_m", "LineString"), Area: ("ring_m", "Polygon")}  # else a point


def write_map(path: Path, hd_map: HdMap) -> None:
    """Write ``hd_map``; reading it gives every coordinate back within 0.1 mm. Raises InputError if it cannot."""
    write_whole(path, map_to_geojson(hd_map))


def read_map(path: Path) -> HdMap:
    """Read a map that ``write_map`` or somebody else wrote in this form. Raises InputError naming file and fault."""
    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot read the map {path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"cannot read the map {path}: it is no UTF-8 text") from error
    try:
        return map_from_geojson(text)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def map_to_geojson(hd_map: HdMap) -> str:
    """The text of the file, one feature a line."""
    rows = [json.dumps(_written(feature, table, hd_map.geo)) for table in _TABLES for feature in getattr(hd_map, table)]
    origin = {"latitude_deg": hd_map.geo.latitude_deg, "longitude_deg": hd_map.geo.longitude_deg}
    head = f'{{"type": "FeatureCollection", "origin": {json.dumps(origin)}, "features": ['
    return head + "\n" + ",\n".join(rows) + "\n]}\n"


def map_from_geojson(text: str) -> HdMap:
    """The inverse of ``map_to_geojson``. Raises InputError for what is no such map."""
    try:
        document = json.loads(text)
    except json.JSONDecodeError as error:
        raise InputError(f"is no JSON: {error}") from error
    if not isinstance(document, dict) or document.get("type") != "FeatureCollection":
        raise InputError("is no GeoJSON FeatureCollection")
    origin = _converted(document.get("origin"), GeoReference, "the member origin (latitude_deg, longitude_deg)")
    features = document.get("features")
    if not isinstance(features, list):
        raise InputError("has no list of features")
    tables: dict[str, list[Feature]] = {table: [] for table in _TABLES}
    for index, row in enumerate(features):
        table, feature = _read(row, origin, f"feature {index}")
        tables[table].append(feature)
    return HdMap(origin, **{table: tuple(rows) for table, rows in tables.items()})  # type: ignore[arg-type]


def _written(feature: Feature, table: str, geo: GeoReference) -> dict[str, Any]:
    name, kind = _geometry_of(type(feature))
    own = {f.name: getattr(feature, f.name) for f in fields(feature) if f.name not in ("id", name)}
    geometry = None
    if name:
        coordinates = _to_geojson(getattr(feature, name), geo)
        if kind == "Polygon":
            coordinates = [[*coordinates, coordinates[0]]]
        geometry = {"type": kind, "coordinates": coordinates}
    return {"type": "Feature", "id": feature.id, "geometry": geometry, "properties": {"table": table, **own}}


def _read(row: Any, geo: GeoReference, where: str) -> tuple[str, Feature]:
    if not isinstance(row, dict) or not isinstance(row.get("properties"), dict):
        raise InputError(f"{where} is no GeoJSON feature with properties")
    where = f"{where} ({row.get('id')!r})"
    own = dict(row["properties"])
    table = own.pop("table", None)
    if table not in _TABLES:
        raise InputError(f"{where} has the table {table!r}; accepted: {', '.join(_TABLES)}")
    type_ = _TABLES[table]
    name, kind = _geometry_of(type_)
    accepted = [f.name for f in fields(type_) if f.name not in ("id", name)]
    if unknown := [key for key in own if key not in accepted]:
        raise InputError(f"{where} has the unknown property {unknown[0]!r}; accepted: {', '.join(accepted) or 'none'}")
    own["id"] = row.get("id")
    if name:
        own[name] = _from_geojson(row.get("geometry"), kind, geo, where)
    return table, _converted(own, type_, where)


def _geometry_of(type_: type[Feature]) -> tuple[str, str]:
    """Name of the field that holds the geometry and its GeoJSON type; empty for a link."""
    if issubclass(type_, Link):
        return "", ""
    return next((found for base, found in _GEOMETRY.items() if issubclass(type_, base)), ("position_m", "Point"))


def _to_geojson(points_m: FloatArray, geo: GeoReference) -> list[Any]:
    """Longitude, latitude, height."""
    places = geo.to_wgs84(points_m[..., :2])
    coordinates: list[Any] = np.concatenate([places[..., ::-1], points_m[..., 2:]], axis=-1).tolist()
    return coordinates


def _from_geojson(geometry: Any, kind: str, geo: GeoReference, where: str) -> FloatArray:
    if not isinstance(geometry, dict) or geometry.get("type") != kind:
        raise InputError(f"{where} needs a geometry of the type {kind}")
    coordinates = geometry.get("coordinates")
    if kind == "Polygon":
        if not isinstance(coordinates, list) or len(coordinates) != 1:
            raise InputError(f"{where} needs a polygon of one ring, without holes")
        if not coordinates[0] or coordinates[0][0] != coordinates[0][-1]:
            raise InputError(f"{where}: its ring does not end where it begins")
        coordinates = coordinates[0][:-1]
    try:
        places = np.asarray(coordinates, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{where}: its coordinates are no numbers") from error
    if places.ndim != (1 if kind == "Point" else 2) or places.shape[-1] not in (2, 3):
        raise InputError(f"{where}: its coordinates are no longitudes and latitudes, with or without height")
    heights = places[..., 2:] if places.shape[-1] == 3 else np.zeros((*places.shape[:-1], 1))
    try:
        return np.concatenate([geo.to_local(places[..., 1::-1]), heights], axis=-1)
    except InputError as error:
        raise InputError(f"{where}: {error}") from error


def _converted(value: Any, type_: type[_T], where: str) -> _T:
    """``value`` as ``type_``; strict, arrays as they are."""
    try:
        return msgspec.convert(value, type_, strict=True, dec_hook=lambda _, array: array)
    except (msgspec.ValidationError, InputError) as error:
        raise InputError(f"{where}: {error}") from error

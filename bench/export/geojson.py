"""GeoJSON (RFC 7946): every position of the truth and of the estimate as a feature.

The standard knows longitude and latitude on WGS84 only. A world that lies on the globe (``Manifest.geo``) is converted.
A plant in a room is not, as any place on a map would be made up: its features have the geometry ``null``, which the
standard provides for unlocated features, and ``position_m`` says where they are in the world's own metres. A member
``local_frame`` at the top says so too.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pyproj

from bench.recording import RecordedStep, Recording
from bench.recording_file import load_recording
from contracts import InputError

FILE_NAME = "tracks.geojson"
LOCAL_FRAME = {
    "unit": "metre",
    "axes": "x east, y north",
    "note": "this world lies nowhere on the globe; positions are in properties.position_m, not on WGS84",
}
_DECIMALS = 9  # of a degree: a tenth of a millimetre
Place = Callable[[float, float], dict[str, Any] | None]


def local_metres(*, lat_deg: float, lon_deg: float) -> str:
    """PROJ string of metres east and north of a point on the globe: a transverse Mercator map centred there."""
    return f"+proj=tmerc +lat_0={lat_deg!r} +lon_0={lon_deg!r} +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def export_geojson(directory: Path, out: Path) -> Path:
    """Write the run in ``directory`` to ``out/tracks.geojson``, which is returned."""
    content = feature_collection(load_recording(directory))
    out.mkdir(parents=True, exist_ok=True)
    path = out / FILE_NAME
    path.write_bytes(msgspec.json.encode(content))
    return path


def feature_collection(recording: Recording) -> dict[str, Any]:
    """The run as a GeoJSON object.

    Raises InputError if the manifest's ``geo`` is no PROJ string.
    """
    place = _place(recording.manifest.geo)
    features = [feature for step in recording.steps for feature in _features(step, place)]
    collection: dict[str, Any] = {"type": "FeatureCollection", "features": features}
    return collection if recording.manifest.geo else collection | {"local_frame": LOCAL_FRAME}


def _features(step: RecordedStep, place: Place) -> Iterator[dict[str, Any]]:
    if step.truth:
        for one, label, (x, y, _) in zip(
            step.truth.ids, step.truth.labels, step.truth.positions_m.tolist(), strict=True
        ):
            yield _feature(step, place, (x, y), kind="truth", identity=one, label=label)
    fused = step.fused
    for number, label, (x, y), valid in zip(
        fused.ids.tolist(), fused.labels, fused.positions_m.tolist(), fused.valid, strict=True
    ):
        if valid:
            yield _feature(step, place, (x, y), kind="estimate", identity=number, label=label)


def _feature(step: RecordedStep, place: Place, position_m: tuple[float, float], **told: str | int) -> dict[str, Any]:
    properties = {**told, "index": step.index, "time_ns": step.time_ns, "position_m": position_m}
    return {"type": "Feature", "geometry": place(*position_m), "properties": properties}


def _place(geo: str | None) -> Place:
    if geo is None:
        return lambda x_m, y_m: None
    try:
        to_wgs84 = pyproj.Transformer.from_crs(geo, "EPSG:4326", always_xy=True)
    except pyproj.exceptions.CRSError as error:
        raise InputError(f"the manifest's geo {geo!r} is no PROJ string: {error}") from error

    def point(x_m: float, y_m: float) -> dict[str, Any]:
        lon_deg, lat_deg = to_wgs84.transform(x_m, y_m)
        return {"type": "Point", "coordinates": [round(lon_deg, _DECIMALS), round(lat_deg, _DECIMALS)]}

    return point

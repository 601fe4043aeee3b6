"""``gantry views``: the ground that cameras see, and the road that none of them sees, as a layer for any map viewer."""

import json
from collections.abc import Sequence
from pathlib import Path

import shapely
from shapely.geometry.base import BaseGeometry

from contracts import InputError
from contracts.files import write_whole
from georef.blind_spots import blind_spots, layer, view
from georef.camera_file import read_stored
from georef.camera_forms import StoredCamera
from georef.geo_reference import GeoReference
from georef.hd_map import HdMap
from georef.hd_map_file import read_map

BLIND_SPOTS = "blind spots"


def write_views(files: Sequence[Path], map_path: Path | None, farthest_m: float, out: Path) -> dict[str, float]:
    """Write the view of each camera, and with a map its road's blind spots, as GeoJSON; returns areas in m2 by name.

    Raises InputError for cameras that tell no place on the Earth, or not the same origin.
    """
    stored = [read_stored(file) for file in files]
    names = [camera.name for camera in stored]
    if len(set(names)) < len(names):
        raise InputError(f"the cameras must have different names, not {', '.join(names)}: calibrate with --name")
    hd_map = read_map(map_path) if map_path else None
    geo = _origin(files, stored, hd_map)
    cameras = [camera.calibrated.camera for camera in stored]
    parts: dict[str, BaseGeometry] = {camera.name: view(camera, farthest_m) for camera in cameras}
    if hd_map is not None:
        parts[BLIND_SPOTS] = blind_spots(cameras, carriageway(hd_map), farthest_m)
    write_whole(out, json.dumps(layer(parts, geo)))
    return {name: float(part.area) for name, part in parts.items()}


def carriageway(hd_map: HdMap) -> BaseGeometry:
    """The lanes of a map, each as wide as it says. Raises InputError for a map without any."""
    lanes = [
        shapely.LineString(lane.points_m[:, :2]).buffer(lane.width_m / 2, cap_style="flat")
        for lane in hd_map.centrelines
    ]
    if not lanes:
        raise InputError("the map has no lane centrelines: what of the road is unseen cannot be told")
    return shapely.union_all(lanes)


def _origin(files: Sequence[Path], stored: Sequence[StoredCamera], hd_map: HdMap | None) -> GeoReference:
    geo = hd_map.geo if hd_map else stored[0].geo
    for file, camera in zip(files, stored, strict=True):
        if camera.geo is None:
            raise InputError(f"{file} tells no geo_reference: calibrate against a map, or with --origin")
        if camera.geo != geo:
            raise InputError(f"{file}: its metres begin elsewhere than {'the map' if hd_map else str(files[0])}'s")
    assert geo is not None
    return geo

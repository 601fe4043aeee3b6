"""``gantry locate``: a table of pixels, placed on the ground."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from contracts import FloatArray, InputError
from georef.geo_reference import GeoReference
from georef.hd_map_file import read_map
from georef.homography_file import read_found
from georef.locate import Located, locate_pixels
from georef.map_ground import MapGround
from georef.picks_file import read_table

_PIXEL_COLUMNS = ("name", "u_px", "v_px", "height_m", "sigma_px")


@dataclass(frozen=True, eq=False)
class Places:
    """Located pixels with their names; latitudes and longitudes (N, 2) where the camera's file says where it stands."""

    names: tuple[str, ...]
    located: Located
    places_deg: FloatArray | None


def locate_table(camera: Path, table: Path, map_path: Path | None = None) -> Places:
    """Place the pixels of a table: u_px, v_px and perhaps height_m, sigma_px (1 if not given), name.

    map_path: of the map whose ground the heights count from; from z = 0 without. Raises InputError.
    """
    found, geo = read_found(camera)
    rows = read_table(table, _PIXEL_COLUMNS, required=("u_px", "v_px"))
    pixels = np.array([[row.required("u_px"), row.required("v_px")] for row in rows])
    heights = np.array([row.number("height_m") or 0.0 for row in rows])
    told = [row.number("sigma_px") for row in rows]
    sigmas = np.array([1.0 if sigma is None else sigma for sigma in told])
    if (sigmas < 0).any():
        raise InputError(f"{rows[int(sigmas.argmin())].where}, column sigma_px: must not be negative")
    covs = sigmas[:, None, None] ** 2 * np.eye(2)
    located = locate_pixels(found, pixels, heights_m=heights, covs_px2=covs, ground=_ground(map_path, geo))
    names = tuple(row.cells.get("name") or str(number + 1) for number, row in enumerate(rows))
    return Places(names, located, geo.to_wgs84(located.positions_m) if geo else None)


def _ground(map_path: Path | None, geo: GeoReference | None) -> MapGround | None:
    if map_path is None:
        return None
    hd_map = read_map(map_path)
    if geo is not None and hd_map.geo != geo:
        raise InputError(f"{map_path}: its metres begin elsewhere than the camera's")
    return MapGround.of(hd_map)

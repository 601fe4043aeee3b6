"""Local metres to WGS84 and back: a transverse Mercator projection about an origin of one's own.

East and north are those of the origin's meridian; the scale is 1 along it and grows by 5e-8 at 2 km beside it, so that
local distances are distances on the ellipsoid within 0.1 mm over 2 km.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from pyproj import CRS, Transformer

from contracts import FloatArray, InputError

_FARTHEST_M = 50_000.0  # the scale is off by 3e-5 there: what lies beyond is a mistaken origin, no local place


@dataclass(frozen=True)
class GeoReference:
    """Where the local origin lies on the Earth.

    latitude_deg, longitude_deg: WGS84 (EPSG:4326) of the local (0, 0); x points east, y north there.
    Raises InputError for an origin that is no place within 84 degrees of the equator.
    """

    latitude_deg: float
    longitude_deg: float

    def __post_init__(self) -> None:
        if not (abs(self.latitude_deg) <= 84 and abs(self.longitude_deg) <= 180):
            raise InputError(
                f"the origin {self.latitude_deg}, {self.longitude_deg} is no latitude within -84 .. 84 and longitude "
                "within -180 .. 180 degrees"
            )

    @property
    def crs(self) -> CRS:
        """The local coordinates as other programs know them (PROJ)."""
        return _crs(self.latitude_deg, self.longitude_deg)

    def to_wgs84(self, positions_m: ArrayLike) -> FloatArray:
        """Local positions (..., 2) east, north in metres to (..., 2) latitude, longitude in degrees; NaN stays NaN.

        Raises InputError for positions farther than 50 km from the origin.
        """
        positions = _pairs(positions_m, "positions_m")
        self._check_near(positions)
        longitude, latitude = _to_wgs84(self).transform(positions[..., 0], positions[..., 1])
        return _stacked(latitude, longitude)

    def to_local(self, latitudes_longitudes_deg: ArrayLike) -> FloatArray:
        """WGS84 (..., 2) latitude, longitude in degrees to local (..., 2) east, north in metres; NaN stays NaN.

        Raises InputError for what is no latitude and longitude, and for places farther than 50 km from the origin.
        """
        places = _pairs(latitudes_longitudes_deg, "latitudes_longitudes_deg")
        if (np.abs(places[..., 0]) > 90).any() or (np.abs(places[..., 1]) > 180).any():
            raise InputError("a latitude lies outside -90 .. 90 or a longitude outside -180 .. 180 degrees")
        east, north = _to_wgs84(self).transform(places[..., 1], places[..., 0], direction="INVERSE")
        positions = _stacked(east, north)
        positions[np.isnan(places).any(axis=-1)] = np.nan
        self._check_near(positions)
        return positions

    def _check_near(self, positions: FloatArray) -> None:
        farthest_m = float(np.nan_to_num(np.abs(positions), nan=0.0).max(initial=0.0))
        if farthest_m > _FARTHEST_M:
            raise InputError(
                f"a place lies {farthest_m / 1000:.0f} km from the origin {self.latitude_deg}, {self.longitude_deg}; "
                f"local metres reach {_FARTHEST_M / 1000:.0f} km: choose an origin nearby"
            )


@lru_cache(maxsize=32)
def _crs(latitude_deg: float, longitude_deg: float) -> CRS:
    return CRS.from_proj4(
        f"+proj=tmerc +lat_0={latitude_deg!r} +lon_0={longitude_deg!r} +k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m"
    )


@lru_cache(maxsize=32)
def _to_wgs84(reference: GeoReference) -> Transformer:
    return Transformer.from_crs(reference.crs, CRS.from_proj4("+proj=longlat +ellps=WGS84 +no_defs"), always_xy=True)


def _pairs(values: ArrayLike, name: str) -> FloatArray:
    pairs = np.asarray(values, dtype=np.float64)
    if pairs.ndim < 1 or pairs.shape[-1] != 2:
        raise InputError(f"{name} has shape {pairs.shape}, expected (..., 2)")
    return pairs


def _stacked(first: FloatArray, second: FloatArray) -> FloatArray:
    """(..., 2) with PROJ's infinities, its "no such place", as NaN."""
    pairs = np.stack([np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)], axis=-1)
    return np.where(np.isfinite(pairs).all(axis=-1, keepdims=True), pairs, np.nan)

"""Pixels to places with their covariance, for cameras and homographies alike."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from contracts import BoolArray, FloatArray, GroundTracks, InputError, Tracks
from contracts.arrays import frozen_array
from georef.calibrated import CalibratedCamera
from georef.ground_homography import GroundHomography, place_by_homography
from georef.location import place
from georef.map_ground import MapGround, place_on_ground


@dataclass(frozen=True, eq=False)
class Located:
    """N places. positions_m: (N, 2) east, north. covs_m2: (N, 2, 2). Both NaN where not valid (N,)."""

    positions_m: FloatArray
    covs_m2: FloatArray
    valid: BoolArray


def locate_pixels(
    found: CalibratedCamera | GroundHomography,
    pixels: ArrayLike,
    *,
    heights_m: ArrayLike = 0.0,
    covs_px2: ArrayLike = 0.0,
    ground: MapGround | None = None,
) -> Located:
    """Where the rays through ``pixels`` (N, 2) meet the planes at ``heights_m`` (N,) or one number.

    ground: heights count from it; from z = 0 if not given.
    covs_px2: (N, 2, 2) or anything that broadcasts to it: the pixels' own error, added to the calibration's.
    Raises InputError for pixels that are no (N, 2), and with a homography for heights or a ground that climbs.
    """
    image = frozen_array(pixels, name="pixels", shape=(None, 2))
    heights = np.broadcast_to(np.asarray(heights_m, dtype=np.float64), (len(image),))
    covs = np.broadcast_to(np.asarray(covs_px2, dtype=np.float64), (len(image), 2, 2))
    if isinstance(found, GroundHomography):
        if heights.any() or ground is not None:
            raise InputError(f'homography "{found.name}" knows the ground, z = 0, and no height above it')
        on_ground = place_by_homography(found, image)
        positions, valid = on_ground.positions_m, on_ground.valid
        by_pixel, by_found = on_ground.by_pixel, on_ground.by_entries
    else:
        camera = found.camera
        placed = place(camera, image, heights) if ground is None else place_on_ground(camera, image, heights, ground)
        positions, valid = placed.positions_m, placed.valid
        by_pixel, by_found = placed.by_pixel, placed.by_parameters
    spread = by_pixel @ covs @ np.swapaxes(by_pixel, 1, 2) + by_found @ found.covariance @ np.swapaxes(by_found, 1, 2)
    return Located(positions, 0.5 * (spread + np.swapaxes(spread, 1, 2)), valid)


class HomographyLocator:
    """Places tracks by their cameras' homographies, every anchor at z = 0; implements ``contracts.Locator``.

    homographies: by camera name.
    """

    def __init__(self, homographies: Mapping[str, GroundHomography]) -> None:
        self._homographies = dict(homographies)

    def locate(self, tracks: Tracks) -> GroundTracks:
        """Positions as if every anchor lay on the ground; raises InputError for a camera without homography."""
        objects = tracks.objects
        if objects.camera not in self._homographies:
            known = ", ".join(sorted(self._homographies))
            raise InputError(f'no homography for camera "{objects.camera}"; there are: {known}')
        located = locate_pixels(
            self._homographies[objects.camera], objects.anchors_px, covs_px2=objects.anchor_covs_px2
        )
        return GroundTracks(
            source=objects.camera,
            time_ns=objects.time_ns,
            ids=tracks.ids,
            labels=objects.labels,
            positions_m=located.positions_m,
            covs_m2=located.covs_m2,
            valid=located.valid,
        )

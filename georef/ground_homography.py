"""The homography between an image and the ground z = 0, with how far it can be trusted, and its calibration."""

from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, CalibrationError, FloatArray, InputError
from contracts.arrays import freeze
from georef.homography import fit_homography, transform
from georef.mixture import Observed
from georef.picks import PointPicks

_SAMPLES = 250
_SAMPLE_SIZE = 4
_CORE_SHARE = 0.005  # of the image's width: residuals that the lens leaves with good picks


@dataclass(frozen=True, eq=False)
class GroundHomography:
    """An estimated homography of the ground z = 0.

    name: the camera's. width_px, height_px: of its image.
    image_from_ground: (3, 3), of unit norm, positive before the camera; east, north in metres to pixels.
    covariance: (9, 9) of its entries row by row; of rank 8, since its length means nothing.
    """

    name: str
    width_px: int
    height_px: int
    image_from_ground: FloatArray
    covariance: FloatArray

    def __post_init__(self) -> None:
        freeze(self, "image_from_ground", shape=(3, 3))
        freeze(self, "covariance", shape=(9, 9))
        if abs(np.linalg.det(self.image_from_ground)) < 1e-300:
            raise InputError(f'homography "{self.name}" is singular')


@dataclass(frozen=True, eq=False)
class GroundImage:
    """Images of places on the ground.

    pixels: (N, 2); NaN where not valid. valid: (N,) before the camera.
    by_entries: (N, 2, 9) with respect to the homography's entries. by_place: (N, 2, 2) px per metre.
    """

    pixels: FloatArray
    valid: BoolArray
    by_entries: FloatArray
    by_place: FloatArray


def image_of_ground(image_from_ground: FloatArray, places_m: FloatArray) -> GroundImage:
    """Image ``places_m`` (N, 2) with derivatives."""
    east, north = places_m[:, 0], places_m[:, 1]
    place = np.stack([east, north, np.ones_like(east)], axis=-1)  # (N, 3)
    mapped = place @ image_from_ground.T
    valid = mapped[:, 2] > 0
    depth = np.where(valid, mapped[:, 2], np.nan)
    pixels = mapped[:, :2] / depth[:, None]
    by_entries = np.zeros((len(places_m), 2, 9))
    scaled = place / depth[:, None]
    by_entries[:, 0, 0:3] = by_entries[:, 1, 3:6] = scaled
    by_entries[:, :, 6:9] = -pixels[:, :, None] * scaled[:, None, :]
    by_mapped = (image_from_ground[None, :2, :2] - pixels[:, :, None] * image_from_ground[2, :2]) / depth[:, None, None]
    return GroundImage(pixels, valid, by_entries, by_mapped)


@dataclass(frozen=True, eq=False)
class GroundPlaces:
    """Places on the ground and how they move with what they were computed from; compare ``georef.location.Placement``.

    positions_m: (N, 2); NaN where not valid. by_pixel: (N, 2, 2). by_entries: (N, 2, 9).
    """

    positions_m: FloatArray
    valid: BoolArray
    by_pixel: FloatArray
    by_entries: FloatArray


def place_by_homography(homography: GroundHomography, pixels: FloatArray) -> GroundPlaces:
    """Places (N, 2) on the ground of ``pixels`` (N, 2); not valid at or above the horizon.

    Derivatives by the implicit function image(homography, place) = pixel, as in ``georef.location.place``.
    """
    h = homography.image_from_ground
    ground_from_image: FloatArray = np.linalg.inv(h).astype(np.float64)
    positions = transform(ground_from_image, np.asarray(pixels, dtype=np.float64))
    seen = image_of_ground(h, positions)
    by_pixel = np.linalg.inv(np.where(seen.valid[:, None, None], seen.by_place, np.eye(2)))
    by_pixel = np.where(seen.valid[:, None, None], by_pixel, np.nan)
    return GroundPlaces(
        np.where(seen.valid[:, None], positions, np.nan), seen.valid, by_pixel, -by_pixel @ seen.by_entries
    )


@dataclass(frozen=True, eq=False)
class HomographyState:
    """A homography of unit norm between normalised coordinates, which a fit moves on the sphere of all of them."""

    entries: FloatArray  # (3, 3)

    @property
    def tangent(self) -> FloatArray:
        """(9, 8) directions along the sphere."""
        return np.linalg.svd(self.entries.reshape(1, 9))[2][1:].T

    def moved(self, step: FloatArray) -> "HomographyState":
        """After a step (8,) along the sphere."""
        entries = self.entries + (self.tangent @ step).reshape(3, 3)
        return HomographyState(entries / np.linalg.norm(entries))


class HomographyModel:
    """How picks on the ground look through a homography; implements ``georef.mixture.Model``.

    Fitted in coordinates of about unit size; ``unit_px`` pixels and ``unit_m`` metres are one there.
    """

    def __init__(self, picks: PointPicks, width_px: int, height_px: int) -> None:
        self.picks = picks
        self.origin_m = picks.points_m[:, :2].mean(axis=0)
        self.unit_m = float(np.abs(picks.points_m[:, :2] - self.origin_m).max()) or 1.0
        self.centre_px = np.array([width_px - 1, height_px - 1]) / 2
        self.unit_px = max(width_px, height_px) / 2
        self._places = (picks.points_m[:, :2] - self.origin_m) / self.unit_m
        self._sigmas = picks.sigmas_m / self.unit_m

    def observe(self, state: HomographyState) -> tuple[Observed, ...]:
        """Points alone."""
        seen = image_of_ground(state.entries, self._places)
        covs = np.nan_to_num(self._sigmas[:, None, None] ** 2 * seen.by_place @ np.swapaxes(seen.by_place, 1, 2))
        return (
            Observed(
                self.unit_px * seen.pixels + self.centre_px - self.picks.pixels,
                self.unit_px * seen.by_entries @ state.tangent,
                self.unit_px**2 * covs,
            ),
        )

    def beliefs(self, _state: HomographyState) -> tuple[FloatArray, FloatArray]:
        """None."""
        return np.empty(0), np.empty((0, 8))

    def move(self, state: HomographyState, step: FloatArray) -> HomographyState:
        """Along the sphere."""
        return state.moved(step)

    def first(self, rng: np.random.Generator) -> HomographyState:
        """The most likely of many homographies through four picks each (MLESAC: Torr & Zisserman 2000).

        Raises CalibrationError if no four picks determine one.
        """
        pixels = (self.picks.pixels - self.centre_px) / self.unit_px
        core = 2 * _CORE_SHARE
        best, least = None, np.inf
        for _ in range(_SAMPLES):
            sample = rng.choice(len(self.picks), _SAMPLE_SIZE, replace=False)
            try:
                entries = fit_homography(self._places[sample], pixels[sample])
            except CalibrationError:
                continue
            entries /= np.linalg.norm(entries)
            weights = np.column_stack([self._places, np.ones(len(pixels))]) @ entries[2]
            entries *= np.sign(np.median(weights)) or 1.0
            gaps = image_of_ground(entries, self._places).pixels - pixels
            loss = float(np.log1p(np.nan_to_num((gaps**2).sum(axis=1), nan=4.0) / core**2).sum())
            if loss < least:
                best, least = HomographyState(entries), loss
        if best is None:
            raise CalibrationError("no four picks determine a homography: too many lie on one line")
        return best

    def finished(
        self, name: str, size: tuple[int, int], state: HomographyState, spread: FloatArray
    ) -> GroundHomography:
        """In pixels and metres, with the covariance (8, 8) of the step carried over."""
        u, v = self.centre_px
        to_pixels = np.array([[self.unit_px, 0, u], [0, self.unit_px, v], [0, 0, 1]])
        x, y = self.origin_m / self.unit_m
        to_units = np.array([[1 / self.unit_m, 0, -x], [0, 1 / self.unit_m, -y], [0, 0, 1]])
        whole = to_pixels @ state.entries @ to_units
        length = np.linalg.norm(whole)
        by_entries = np.kron(to_pixels, to_units.T) / length  # row by row: vec(A X B) = (A kron B^T) vec(X)
        unit = whole.ravel() / length
        by_entries = by_entries - np.outer(unit, unit @ by_entries)
        root = by_entries @ state.tangent
        return GroundHomography(name, *size, whole / length, root @ spread @ root.T)

"""Colour models learned from frames whose vehicles are marked."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from contracts import BoolArray, Camera, FloatArray, Frame, ImageArray, InputError
from contracts.arrays import freeze
from perception.anchor_errors import KnownRoof, anchor_moments
from perception.colour_models import REGIMES, ColourModel, ColourModels, Pair
from perception.hue_saturation import SHAPE, histogram, hue_saturation_value, ratio_histogram, widened
from perception.silhouette import silhouette_at
from perception.view import LocalView, RoofView

MARGIN = 1.25  # the least fill is so much below what training showed
LEAST_VISIBLE = 0.8  # a vehicle hidden by more teaches a wrong size and colour
LEAST_CUT = 0.25  # a vehicle that the border leaves less of teaches nothing


@dataclass(frozen=True, eq=False)
class LabelledFrame:
    """A frame and the vehicles in it; N rows.

    camera: that took it, as well as it is known.
    labels: N colour names.
    roof_quads_px: (N, 4, 2) corners of the roofs, in order round each; they may leave the image.
    heights_m: (N,) of the roofs above ground.
    visible_fractions: (N,) in [0, 1].
    """

    frame: Frame
    camera: Camera
    labels: tuple[str, ...]
    roof_quads_px: FloatArray
    heights_m: FloatArray
    visible_fractions: FloatArray

    def __post_init__(self) -> None:
        n = len(self.labels)
        object.__setattr__(self, "labels", tuple(self.labels))
        freeze(self, "roof_quads_px", shape=(n, 4, 2))
        freeze(self, "heights_m", shape=(n,))
        freeze(self, "visible_fractions", shape=(n,))

    @property
    def inside(self) -> BoolArray:
        """(N,) the whole roof lies inside the image."""
        height, width = self.frame.image.shape[:2]
        corners = self.roof_quads_px  # (N, 4, 2)
        return np.asarray(((corners >= 0) & (corners <= (width - 1, height - 1))).all(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class _Example:
    """One vehicle, cut out of its frame; pixels of the cut-out.

    whole: it is in the image and hardly hidden, not cut by the border.
    """

    image: ImageArray
    roof_quad_px: FloatArray
    height_m: float
    view: LocalView
    image_histogram: FloatArray
    whole: bool

    @property
    def centre_px(self) -> FloatArray:
        return np.asarray(self.roof_quad_px.mean(axis=0))

    @property
    def sides_m(self) -> tuple[float, float]:
        sides = np.roll(self.roof_quad_px, -1, axis=0) - self.roof_quad_px  # (4, 2)
        lengths = np.linalg.norm(sides, axis=1)
        lengths_m = lengths / self.view.px_per_m_along(sides / lengths[:, None])
        pairs = (lengths_m[0] + lengths_m[2]) / 2, (lengths_m[1] + lengths_m[3]) / 2
        return max(pairs), min(pairs)


def learn(samples: Iterable[LabelledFrame]) -> ColourModels:
    """One model per label, in alphabetical order.

    samples: frames with the vehicles that can be seen in them. Colour and size are learned from vehicles wholly inside
        the image, the error of anchors also from those that its border cuts.
    Raises InputError if no sample holds a whole vehicle, or if a label cannot be told from the background.
    """
    examples: dict[str, list[_Example]] = {}
    background, cameras = np.zeros(SHAPE), []
    views: dict[tuple[Camera, float], RoofView] = {}
    for sample in samples:
        hsv = hue_saturation_value(sample.frame.image)
        image_histogram = histogram(hsv)
        background += histogram(hsv, _outside(sample))
        cameras.append(sample.camera)
        for row in _taught(sample):
            key = sample.camera, round(float(sample.heights_m[row]), 6)
            if key not in views:
                views[key] = RoofView.of(*key)
            example = _cut_out(sample, row, views[key], image_histogram)
            examples.setdefault(sample.labels[row], []).append(example)
    if not any(example.whole for of_one_colour in examples.values() for example in of_one_colour):
        raise InputError(f"learn: none of the {len(cameras)} samples holds a vehicle wholly inside its image")
    colours = [label for label in sorted(examples) if any(example.whole for example in examples[label])]
    open_models = [_open_model(label, examples[label], background / len(cameras)) for label in colours]
    known = [_known_roofs(model, examples[model.label]) for model in open_models]
    moments = anchor_moments([roof for of_one_colour in known for roof in of_one_colour])
    models = tuple(_gated(*pair, moments) for pair in zip(open_models, known, strict=True))
    focal_px, height_m = np.median([_focal_and_height(camera) for camera in cameras], axis=0).tolist()
    return ColourModels(models, focal_px, height_m)


def _focal_and_height(camera: Camera) -> tuple[float, float]:
    return camera.intrinsics.fx_px, float(camera.pose.position_m[2])


def _taught(sample: LabelledFrame) -> list[int]:
    """Rows from which something can be learned."""
    return np.flatnonzero(sample.visible_fractions >= np.where(sample.inside, LEAST_VISIBLE, LEAST_CUT)).tolist()


def _outside(sample: LabelledFrame) -> ImageArray:
    """(H, W) 1 where no vehicle is, walls and shadow included."""
    mask = np.ones(sample.frame.image.shape[:2], np.uint8)
    for quad in sample.roof_quads_px:
        centre = quad.mean(axis=0)
        cv2.fillConvexPoly(mask, np.round(centre + (quad - centre) * 2).astype(np.int32), 0)
    return mask


def _cut_out(sample: LabelledFrame, row: int, view: RoofView, image_histogram: FloatArray) -> _Example:
    quad = sample.roof_quads_px[row]
    reach = 2 * np.ptp(quad, axis=0).max()
    low = np.maximum(np.floor(quad.mean(axis=0) - reach), 0).astype(int)
    high = np.maximum(np.ceil(quad.mean(axis=0) + reach).astype(int) + 1, 0)
    image = sample.frame.image[low[1] : high[1], low[0] : high[0]].copy()
    local, height_m = view.at(quad.mean(axis=0)), float(sample.heights_m[row])
    return _Example(image, quad - low, height_m, local, image_histogram, bool(sample.inside[row]))


def _open_model(label: str, examples: list[_Example], background: FloatArray) -> ColourModel:
    """Colour and size of one vehicle, with gates that let everything through."""
    whole = [example for example in examples if example.whole]
    long_m, short_m = np.median([example.sides_m for example in whole], axis=0).tolist()
    return ColourModel(
        label=label,
        histogram=_model_histogram(whole, background),
        roof_size_m=(long_m, short_m),
        roof_height_m=float(np.mean([example.height_m for example in whole])),
        fill_min=0.0,
        anchor_moments_px2=dict.fromkeys(REGIMES, (1.0, 1.0)),
    )


def _known_roofs(model: ColourModel, examples: list[_Example]) -> list[KnownRoof]:
    known = []
    for example in examples:
        area_px = float(np.prod(model.roof_size_m)) * example.view.px_per_m**2
        ratio = ratio_histogram(model.histogram * area_px, example.image_histogram)
        outline = silhouette_at(example.image, example.centre_px, ratio, model, example.view)
        if outline is not None:
            known.append(KnownRoof(model, example.image, outline, example.centre_px, example.view, example.whole))
    if not any(roof.whole for roof in known):
        raise InputError(f"learn: no vehicle labelled {model.label!r} stands out by hue and saturation")
    return known


def _gated(model: ColourModel, known: list[KnownRoof], moments: dict[str, Pair]) -> ColourModel:
    """The model with its gate set to what the outlines of whole vehicles showed, with a margin."""
    least = min(roof.silhouette.fill for roof in known if roof.whole)
    return replace(model, fill_min=least / MARGIN, anchor_moments_px2=moments)


def _model_histogram(examples: list[_Example], background: FloatArray) -> FloatArray:
    """Share of a roof in each bin under the light that puts most there, less where the background is too."""
    most, area_px = np.zeros(SHAPE), []
    for example in examples:
        hsv = hue_saturation_value(example.image)
        roof = np.zeros(hsv.shape[:2], np.uint8)
        cv2.fillConvexPoly(roof, np.round(example.roof_quad_px).astype(np.int32), 1)
        area_px.append(np.count_nonzero(roof))
        most = np.maximum(most, widened(histogram(hsv, roof)) / area_px[-1])
    return most * most / (most + background / np.mean(area_px) + 1e-9)

"""Colour models learned from frames whose vehicles are marked."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import cv2
import numpy as np

from contracts import BoolArray, FloatArray, Frame, ImageArray, InputError
from contracts.arrays import freeze
from perception.anchor import outward_px
from perception.anchor_errors import KnownRoof, anchor_moments
from perception.colour_models import REGIMES, ColourModel, ColourModels, Range
from perception.hue_saturation import SHAPE, histogram, hue_saturation_value, ratio_histogram, widened
from perception.silhouette import silhouette_at

LEAST_PART = 0.5  # a vehicle hidden by so much is still looked for
MARGIN = 1.25  # gates are so much wider than what training showed
_ANY_AREA_PX = 1e9


@dataclass(frozen=True, eq=False)
class LabelledFrame:
    """A frame and the vehicles in it; N rows.

    labels: N colour names.
    roof_quads_px: (N, 4, 2) corners of the roofs, in order round each; they may leave the image.
    heights_m: (N,) of the roofs above ground.
    """

    frame: Frame
    labels: tuple[str, ...]
    roof_quads_px: FloatArray
    heights_m: FloatArray

    def __post_init__(self) -> None:
        n = len(self.labels)
        object.__setattr__(self, "labels", tuple(self.labels))
        freeze(self, "roof_quads_px", shape=(n, 4, 2))
        freeze(self, "heights_m", shape=(n,))

    @property
    def inside(self) -> BoolArray:
        """(N,) the whole roof lies inside the image."""
        height, width = self.frame.image.shape[:2]
        corners = self.roof_quads_px  # (N, 4, 2)
        return np.asarray(((corners >= 0) & (corners <= (width - 1, height - 1))).all(axis=(1, 2)))


@dataclass(frozen=True, eq=False)
class _Example:
    """One wholly visible vehicle, cut out of its frame; pixels of the cut-out."""

    image: ImageArray
    roof_quad_px: FloatArray
    height_m: float
    outward: FloatArray
    image_histogram: FloatArray

    @property
    def centre_px(self) -> FloatArray:
        return np.asarray(self.roof_quad_px.mean(axis=0))

    @property
    def sides_px(self) -> tuple[float, float]:
        corners = self.roof_quad_px
        lengths = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)  # (4,)
        pairs = (lengths[0] + lengths[2]) / 2, (lengths[1] + lengths[3]) / 2
        return max(pairs), min(pairs)


def learn(samples: Iterable[LabelledFrame]) -> ColourModels:
    """One model per label, in alphabetical order.

    samples: frames with the vehicles that can be seen in them. Vehicles that leave the image are not learned from.
    Raises InputError if no sample holds a whole vehicle, or if a label cannot be told from the background.
    """
    examples: dict[str, list[_Example]] = {}
    background, frames = np.zeros(SHAPE), 0
    for sample in samples:
        hsv = hue_saturation_value(sample.frame.image)
        whole = histogram(hsv)
        background += histogram(hsv, _outside(sample))
        frames += 1
        for row in np.flatnonzero(sample.inside).tolist():
            examples.setdefault(sample.labels[row], []).append(_cut_out(sample, row, whole))
    if not examples:
        raise InputError(f"learn: none of the {frames} samples holds a vehicle wholly inside its image")
    open_models = [_open_model(label, examples[label], background / frames) for label in sorted(examples)]
    known = [_known_roofs(model, examples[model.label]) for model in open_models]
    moments = anchor_moments([roof for of_one_colour in known for roof in of_one_colour])
    return ColourModels(tuple(_gated(*pair, moments) for pair in zip(open_models, known, strict=True)))


def _outside(sample: LabelledFrame) -> ImageArray:
    """(H, W) 1 where no vehicle is, walls and shadow included."""
    mask = np.ones(sample.frame.image.shape[:2], np.uint8)
    for quad in sample.roof_quads_px:
        centre = quad.mean(axis=0)
        cv2.fillConvexPoly(mask, np.round(centre + (quad - centre) * 2).astype(np.int32), 0)
    return mask


def _cut_out(sample: LabelledFrame, row: int, image_histogram: FloatArray) -> _Example:
    quad = sample.roof_quads_px[row]
    reach = 2 * np.ptp(quad, axis=0).max()
    low = np.maximum(np.floor(quad.mean(axis=0) - reach), 0).astype(int)
    high = np.ceil(quad.mean(axis=0) + reach).astype(int) + 1
    image = sample.frame.image[low[1] : high[1], low[0] : high[0]].copy()
    outward = outward_px(sample.frame.image, quad.mean(axis=0))
    return _Example(image, quad - low, float(sample.heights_m[row]), outward, image_histogram)


def _open_model(label: str, examples: list[_Example], background: FloatArray) -> ColourModel:
    """Colour and size of one vehicle, with gates that let everything through."""
    sides = np.array([example.sides_px for example in examples])  # (E, 2)
    (long_min, short_min), (long_max, short_max) = sides.min(axis=0).tolist(), sides.max(axis=0).tolist()
    return ColourModel(
        label=label,
        histogram=_model_histogram(examples, background),
        area_px=(1.0, _ANY_AREA_PX),
        side_ratio=(1e-9, 1.0),
        rectangularity_min=0.0,
        roof_long_px=(long_min, long_max),
        roof_short_px=(short_min, short_max),
        roof_height_m=float(np.mean([example.height_m for example in examples])),
        anchor_moments_px2=dict.fromkeys(REGIMES, (1.0, 1.0)),
    )


def _known_roofs(model: ColourModel, examples: list[_Example]) -> list[KnownRoof]:
    known = []
    for example in examples:
        ratio = ratio_histogram(model.histogram, example.image_histogram)
        outline = silhouette_at(example.image, example.centre_px, ratio, model)
        if outline is not None:
            known.append(KnownRoof(model, example.image, outline, example.centre_px, example.outward))
    if not known:
        raise InputError(f"learn: no vehicle labelled {model.label!r} stands out by hue and saturation")
    return known


def _gated(model: ColourModel, known: list[KnownRoof], moments: dict[str, Range]) -> ColourModel:
    """The model with its gates set to what the outlines of whole vehicles showed, with a margin."""
    outlines = [roof.silhouette for roof in known]
    areas = [outline.area_px for outline in outlines]
    return replace(
        model,
        area_px=(LEAST_PART * min(areas), MARGIN * max(areas)),
        side_ratio=(LEAST_PART * min(outline.side_ratio for outline in outlines), 1.0),
        rectangularity_min=min(outline.fill for outline in outlines) / MARGIN,
        anchor_moments_px2=moments,
    )


def _model_histogram(examples: list[_Example], background: FloatArray) -> FloatArray:
    """What one vehicle puts into each bin under the light that puts most there, less where the background is too."""
    most = np.zeros(SHAPE)
    for example in examples:
        hsv = hue_saturation_value(example.image)
        roof = np.zeros(hsv.shape[:2], np.uint8)
        cv2.fillConvexPoly(roof, np.round(example.roof_quad_px).astype(np.int32), 1)
        most = np.maximum(most, widened(histogram(hsv, roof)))
    return most * most / (most + background + 1e-9)

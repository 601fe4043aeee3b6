"""How far anchors lie from the truth of training frames: the covariances that the detector will state."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from contracts import FloatArray, ImageArray
from perception.anchor import complete_roof, roof_in
from perception.colour_models import BOTH, REGIMES, ROUGH, SINGLE, ColourModel, Range
from perception.roof import Roof
from perception.silhouette import Silhouette

LEAST_ERROR_PX = 0.05  # what antialiasing leaves unresolved even in a rendered image


@dataclass(frozen=True, eq=False)
class KnownRoof:
    """A vehicle of a training frame: a window of it, the outline found there, and the roof's true middle (2,).

    model: of its colour. outward: (2,) from the point below the camera.
    """

    model: ColourModel
    window: ImageArray
    silhouette: Silhouette
    centre_px: FloatArray
    outward: FloatArray


def anchor_moments(known: Sequence[KnownRoof]) -> dict[str, Range]:
    """By regime, the mean squared error (bias included) along the long and the short side, in square pixels.

    A hidden end is rare in training, so the ``single`` regime is learned by leaving out each end of each axis in
    turn; among the half that lies farthest out, since it is mostly the image's border that hides an end.
    """
    far = np.median([np.linalg.norm(example.outward) for example in known])
    errors: dict[str, list[FloatArray]] = {regime: [] for regime in REGIMES}
    for example in known:
        roof = roof_in(example.window, example.silhouette, example.outward)
        if roof is None:
            continue
        errors[ROUGH].append(roof.axes @ (example.silhouette.quad_px.mean(axis=0) - example.centre_px))
        whole = complete_roof(roof, example.model, example.outward)
        if whole.regimes == (BOTH, BOTH):
            errors[BOTH].append(roof.axes @ (whole.point_px - example.centre_px))
            if np.linalg.norm(example.outward) >= far:
                errors[SINGLE].extend(_with_one_end(roof, example))
    return {regime: _moment(errors[regime]) for regime in REGIMES}


def _with_one_end(roof: Roof, example: KnownRoof) -> Iterator[FloatArray]:
    """Errors (2,) along both axes, had the forward, or the backward ends been hidden."""
    for end in range(2):
        error = np.empty(2)
        for axis, sides in enumerate(((1, 3), (0, 2))):
            seen = roof.sides_measured & (np.arange(4) != sides[end])
            anchor = complete_roof(replace(roof, sides_measured=seen), example.model, example.outward)
            error[axis] = roof.axes[axis] @ (anchor.point_px - example.centre_px)
        yield error


def _moment(errors: list[FloatArray]) -> Range:
    """Mean square, no less than what can be resolved; a whole pixel where nothing was learned."""
    moments = np.mean(np.square(errors), axis=0) if errors else np.ones(2)
    along, across = np.maximum(moments, LEAST_ERROR_PX**2).tolist()
    return along, across

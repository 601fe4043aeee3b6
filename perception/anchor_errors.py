"""How far anchors lie from the truth of training frames: the covariances that the detector will state."""

from dataclasses import dataclass, replace

import numpy as np

from contracts import FloatArray, ImageArray
from perception.anchor import complete_roof, roof_in
from perception.colour_models import BOTH, REGIMES, ROUGH, SINGLE, ColourModel, Range
from perception.silhouette import Silhouette

LEAST_ERROR_PX = 0.05  # what cannot be resolved with a rendered roof's own antialiasing


@dataclass(frozen=True, eq=False)
class KnownRoof:
    """A vehicle of a training frame: a window of it, the outline found there, and the roof's true middle (2,).

    outward: (2,) direction away from the point below the camera.
    """

    window: ImageArray
    silhouette: Silhouette
    centre_px: FloatArray
    outward: FloatArray


def anchor_moments(model: ColourModel, known: list[KnownRoof]) -> dict[str, Range]:
    """By regime, the mean squared error (bias included) along the long and the short side, in square pixels.

    A hidden end is rare in training, so the ``single`` regime is learned by leaving out each end of each axis in turn.
    """
    errors: dict[tuple[str, int], list[float]] = {(regime, axis): [] for regime in REGIMES for axis in range(2)}
    for example in known:
        middle = example.silhouette.quad_px.mean(axis=0)
        roof = roof_in(example.window, example.silhouette, example.outward)
        axes = np.eye(2) if roof is None else roof.axes
        rough = axes @ (middle - example.centre_px)
        for axis in range(2):
            errors[ROUGH, axis].append(rough[axis])
        if roof is None or not roof.ends_measured.all():
            continue
        for axis, ends in enumerate(((1, 3), (0, 2))):
            whole = complete_roof(roof, model, example.outward)
            if whole.regimes == (BOTH, BOTH):
                errors[BOTH, axis].append(float(axes[axis] @ (whole.point_px - example.centre_px)))
            for end in ends:
                half = replace(roof, sides_measured=roof.sides_measured & (np.arange(4) != end))
                single = complete_roof(half, model, example.outward)
                errors[SINGLE, axis].append(float(axes[axis] @ (single.point_px - example.centre_px)))
    return {regime: (_moment(errors[regime, 0]), _moment(errors[regime, 1])) for regime in REGIMES}


def _moment(errors: list[float]) -> float:
    """Mean square, no less than what can be resolved; a whole pixel where nothing was learned."""
    return max(LEAST_ERROR_PX**2, float(np.mean(np.square(errors)))) if errors else 1.0

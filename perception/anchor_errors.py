"""How far anchors lie from the truth of training frames: the covariances that the detector will state."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from contracts import FloatArray, ImageArray
from perception.anchor import complete_roof, roof_in
from perception.colour_models import REGIMES, ROUGH, SINGLE, ColourModel, Pair
from perception.roof import Roof
from perception.silhouette import Silhouette
from perception.view import LocalView

LEAST_CUT = 20  # axes cut by the border, that teach their own error
LEAST_ERROR_PX = 0.05  # what antialiasing leaves unresolved even in a rendered image


@dataclass(frozen=True, eq=False)
class KnownRoof:
    """A vehicle of a training frame: a window of it, the outline found there, and the roof's true middle (2,).

    model: of its colour. view: of the camera, there. whole: it is not cut by the image's border.
    """

    model: ColourModel
    window: ImageArray
    silhouette: Silhouette
    centre_px: FloatArray
    view: LocalView
    whole: bool


def anchor_moments(known: Sequence[KnownRoof]) -> dict[str, Pair]:
    """By regime, the mean squared error (bias included) along the long and the short side, in square pixels.

    An end is hidden mostly by the image's border, so the ``single`` regime is learned from the axes that it cuts; where
    training has fewer than ``LEAST_CUT`` of them, also by leaving out each end of each axis of whole roofs in turn.
    """
    errors: dict[str, tuple[list[float], list[float]]] = {regime: ([], []) for regime in REGIMES}
    left_out: tuple[list[float], list[float]] = ([], [])
    for example in known:
        roof = roof_in(example.window, example.silhouette, example.view)
        if roof is None:
            continue
        anchor = complete_roof(roof, example.model, example.view)
        for axis, regime in enumerate(anchor.regimes):
            if regime != ROUGH and (regime == SINGLE) != example.whole:
                errors[regime][axis].append(anchor.axes[axis] @ (anchor.point_px - example.centre_px))
        if example.whole:
            rough = roof.axes @ (example.silhouette.quad_px.mean(axis=0) - example.centre_px)
            for axis in range(2):
                errors[ROUGH][axis].append(rough[axis])
                left_out[axis].extend(_with_one_end(roof, example, axis))
    for axis in range(2):
        if len(errors[SINGLE][axis]) < LEAST_CUT:
            errors[SINGLE][axis].extend(left_out[axis])
    return {regime: (_moment(errors[regime][0]), _moment(errors[regime][1])) for regime in REGIMES}


def _with_one_end(roof: Roof, example: KnownRoof, axis: int) -> Iterator[float]:
    """Errors along one axis, had one of its ends been hidden, then the other."""
    for end in ((1, 3), (0, 2))[axis]:
        seen = roof.sides_measured & (np.arange(4) != end)
        anchor = complete_roof(replace(roof, sides_measured=seen), example.model, example.view)
        yield float(roof.axes[axis] @ (anchor.point_px - example.centre_px))


def _moment(errors: list[float]) -> float:
    """Mean square, no less than what can be resolved; a whole pixel where nothing was learned."""
    moment = float(np.mean(np.square(errors))) if errors else 1.0
    return max(moment, LEAST_ERROR_PX**2)

"""From the measured roof to the anchor: what to do about sides that were not seen, and how sure the answer is."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from contracts import BoolArray, FloatArray, ImageArray
from perception.colour_models import BOTH, ROUGH, SINGLE, ColourModel
from perception.roof import Roof, measure_roof, seed_quad
from perception.silhouette import Silhouette
from perception.view import LocalView, RoofView

FARTHEST_PX = 6.0  # the measured middle is not farther than this from the rough one
MARGIN_PX = 14  # of the image round the silhouette in which the roof is measured
ODD_SIZE = 0.12  # a size that departs from the usual one by more than this share is not the whole roof's
ODD_RATIO = 0.05  # nor are both, if their ratio departs by more than this; a lens changes it by 4 % near the border


@dataclass(frozen=True, eq=False)
class Anchor:
    """The roof's centre.

    point_px: (2,). cov_px2: (2, 2) second moment of its error.
    quad_px: (4, 2) the roof. visible: share of the roof that was seen.
    axes: (2, 2) unit vectors along the long and the short side. regimes: how each of these axes was measured.
    """

    point_px: FloatArray
    cov_px2: FloatArray
    quad_px: FloatArray
    visible: float
    axes: FloatArray
    regimes: tuple[str, str]


def find_anchor(image: ImageArray, silhouette: Silhouette, model: ColourModel, view: RoofView) -> Anchor:
    """The roof's centre within a silhouette."""
    local = view.at(silhouette.quad_px.mean(axis=0))
    roof = roof_in(image, silhouette, local)
    return _rough(silhouette, model) if roof is None else complete_roof(roof, model, view.at(roof.centre_px))


def roof_in(image: ImageArray, silhouette: Silhouette, view: LocalView) -> Roof | None:
    """The roof measured within a silhouette; None where no roof can be told from the walls."""
    left, top, width, height = cv2.boundingRect(silhouette.mask)
    low = np.maximum([left - MARGIN_PX, top - MARGIN_PX], 0)
    near = slice(low[1], top + height + MARGIN_PX), slice(low[0], left + width + MARGIN_PX)
    (u, v), mask = silhouette.origin_px, silhouette.mask[near]
    window = image[v:, u:][: silhouette.mask.shape[0], : silhouette.mask.shape[1]][near]
    seed = seed_quad(window, mask, -view.lean_px)
    if seed is None:
        return None
    roof = measure_roof(window, seed, view.lean_px)
    believed = np.abs(roof.centre_px - seed.mean(axis=0)).max() <= FARTHEST_PX
    return roof.shifted(silhouette.origin_px + low) if believed else None


def complete_roof(roof: Roof, model: ColourModel, view: LocalView) -> Anchor:
    """The anchor from the measured sides, with the learned size where an end of the roof was hidden."""
    roof = _long_side_first(roof, model, view)
    axes = roof.axes  # (2, 2) long, short
    size = np.array(roof.size_px)
    usual = np.array(model.roof_size_m) * view.px_per_m_along(axes)
    whole = _whole(roof, size / usual)
    scale = float(np.mean(size[whole] / usual[whole])) if whole.any() else 1.0  # the camera may hang lower than known
    expected, outward = scale * usual, -axes @ view.lean_px
    if _nameless(roof, usual):
        completed = [_Axis(ROUGH, size[k], doubt_px=(expected[0] - size[k]) / 2) for k in range(2)]
    else:
        completed = [
            _Axis(BOTH, size[k]) if whole[k] else _complete(size[k], expected[k], roof.ends_measured[k], outward[k])
            for k in range(2)
        ]
        if roof.ends_measured.all(axis=1).any() and not whole.any():  # neither size is a roof's
            completed = [replace(axis, regime=ROUGH) for axis in completed]
    moments = [model.anchor_moments_px2[axis.regime][k] + axis.doubt_px**2 for k, axis in enumerate(completed)]
    point = roof.centre_px + np.array([axis.shift_px for axis in completed]) @ axes
    half = np.array([axis.size_px for axis in completed]) / 2
    quad = point + (np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half) @ axes
    visible = float(np.clip(np.prod(size / expected), 0.0, 1.0))
    regimes = completed[0].regime, completed[1].regime
    return Anchor(point, axes.T @ np.diag(moments) @ axes, quad, visible, axes, regimes)


def _long_side_first(roof: Roof, model: ColourModel, view: LocalView) -> Roof:
    """The same roof with its axes named by what was measured: half a roof, cut by the border, is nearly a square.

    An axis of which both ends were seen is the one whose learned size it is nearer to.
    """
    whole: BoolArray = np.asarray(roof.ends_measured.all(axis=1))
    if whole.all() or not whole.any():
        return roof
    seen = int(np.argmax(whole))
    size_m = roof.size_px[seen] / view.px_per_m_along(roof.axes[seen : seen + 1])[0]
    nearest = int(np.argmin(np.abs(np.log(size_m / np.array(model.roof_size_m)))))
    return roof if whole[nearest] else roof.turned()


def _nameless(roof: Roof, usual_px: FloatArray) -> bool:
    """Whether no axis was seen from end to end, and what was seen of both might be the short one."""
    return not roof.ends_measured.all(axis=1).any() and max(roof.size_px) < usual_px.min() * (1 + ODD_SIZE)


def _whole(roof: Roof, relative_size: FloatArray) -> BoolArray:
    """(2,) whether each axis was measured from one end of the roof to the other; sizes relative to the usual ones.

    A camera that hangs lower scales both axes alike; a cover or a wall taken for the roof changes one of them.
    """
    departure = np.abs(np.log(relative_size))  # (2,)
    whole = roof.ends_measured.all(axis=1) & (departure < ODD_SIZE)
    if whole.all() and abs(np.log(relative_size[0] / relative_size[1])) > ODD_RATIO:
        whole[np.argmax(departure)] = False
    return np.asarray(whole)


@dataclass(frozen=True)
class _Axis:
    """One axis completed: regime, size, shift of the middle, and doubt beyond the regime's own."""

    regime: str
    size_px: float
    shift_px: float = 0.0
    doubt_px: float = 0.0


def _complete(size_px: float, expected_px: float, ends: BoolArray, outward: float) -> _Axis:
    """An axis whose ends, backward and forward, were not both measured as the roof's."""
    excess = size_px - expected_px
    if not ends.any():
        return _Axis(ROUGH, expected_px)
    if ends.all() and excess < 0:  # something covers one end, and nobody knows which
        return _Axis(SINGLE, size_px, doubt_px=excess / 2)
    forward = outward > 0 if ends.all() else bool(ends[1])  # a wall without contrast is on the inner end
    return _Axis(SINGLE, expected_px, shift_px=(excess if forward else -excess) / 2)


def _rough(silhouette: Silhouette, model: ColourModel) -> Anchor:
    """The silhouette's middle, where no roof can be told from the walls."""
    quad = silhouette.quad_px
    moment = max(model.anchor_moments_px2[ROUGH])
    return Anchor(quad.mean(axis=0), np.eye(2) * moment, quad, silhouette.fill, np.eye(2), (ROUGH, ROUGH))

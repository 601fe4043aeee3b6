"""What the baselines have in common: masks of the whole frame, then the same post-processing as back-projection."""

from abc import ABC, abstractmethod
from collections.abc import Iterator

import cv2
import numpy as np

from contracts import Camera, Detections, Frame, ImageArray, InputError
from perception.anchor import find_anchor
from perception.baselines.colours import PlainColours
from perception.colour_models import SHIPPED, ColourModel, ColourModels
from perception.hbp import detections_of
from perception.model_views import ModelViews
from perception.silhouette import CLOSING_PX, ShapeGates, Silhouette, silhouette_in
from perception.view import RoofView

LEAST_SHARE = 0.2  # of a roof's area; a smaller patch is no vehicle anywhere in the image
MARGIN_PX = 2 * CLOSING_PX  # round a patch, so that closing sees what lies beside it


class MaskDetector(ABC):
    """Detector: at most one vehicle per colour and frame; keeps no state.

    models: sizes, gates and heights of the vehicles; those shipped with the package if none are given.
    camera: whose frames they will be, as well as it is known; if none is given, one like that of the training.
    colours: the same vehicles' colours; those shipped if none are given.
    Raises InputError if a model has no colour.
    """

    def __init__(
        self, models: ColourModels | None = None, camera: Camera | None = None, *, colours: PlainColours | None = None
    ) -> None:
        sizes = models or ColourModels.load(SHIPPED)
        self._models, self._views = sizes.models, ModelViews(sizes, camera)
        known = {colour.label: colour for colour in (colours or PlainColours.load()).colours}
        unknown = [model.label for model in self._models if model.label not in known]
        if unknown:
            raise InputError(f"the baselines know no {' and no '.join(unknown)}; learn both from the same frames")
        self.colours = tuple(known[model.label] for model in self._models)

    @abstractmethod
    def masks(self, image: ImageArray) -> tuple[ImageArray, ...]:
        """(H, W) uint8 per colour, 1 where a pixel of ``image`` (H, W, 3) has it; nothing filled."""

    def reset(self) -> None:  # noqa: B027 - a detector without memory has nothing to do here
        """Nothing to forget."""

    def detect(self, frame: Frame) -> Detections:
        """At most one detection per model, in the models' order."""
        found = [
            (model, find_anchor(frame.image, outline, model, view))
            for model, view, outline in self._outlines(frame.image)
        ]
        return detections_of(frame, found)

    def silhouettes(self, image: ImageArray) -> dict[str, Silhouette]:
        """The outline of each vehicle that is found in an image (H, W, 3), by its label."""
        return {model.label: outline for model, _, outline in self._outlines(image)}

    def _outlines(self, image: ImageArray) -> Iterator[tuple[ColourModel, RoofView, Silhouette]]:
        for model, view, mask in zip(self._models, self._views.of(image), self.masks(image), strict=True):
            passed = list(patches(mask, model, view))
            if passed:
                yield model, view, max(passed, key=lambda silhouette: silhouette.area_px)


def patches(mask: ImageArray, model: ColourModel, view: RoofView) -> Iterator[Silhouette]:
    """The outlines in a mask (H, W) of the whole image that pass the gates: each patch is looked at by itself."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (CLOSING_PX, CLOSING_PX))
    least_px = LEAST_SHARE * float(np.prod(model.roof_size_m)) * view.at(np.array(mask.shape[::-1]) / 2).px_per_m ** 2
    _, _, stats, _ = cv2.connectedComponentsWithStats(cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel))
    for left, top, width, height, _ in stats[1:][stats[1:, cv2.CC_STAT_AREA] >= least_px].tolist():
        low = np.maximum([left - MARGIN_PX, top - MARGIN_PX], 0)
        window = mask[low[1] : top + height + MARGIN_PX, low[0] : left + width + MARGIN_PX]
        local = view.at(np.array([left + width / 2, top + height / 2]))
        outline = silhouette_in(np.ascontiguousarray(window), low, ShapeGates.at(local, model))
        if outline is not None:
            yield outline

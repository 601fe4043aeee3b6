"""The views of all models' roofs by the camera of a detector, or by one like that of the training."""

from contracts import Camera, ImageArray
from perception.colour_models import ColourModels
from perception.view import RoofView, straight_down


class ModelViews:
    """Made once for each size of image.

    camera: whose images they are, as well as it is known; if None, one that looks straight down as in training.
    """

    def __init__(self, models: ColourModels, camera: Camera | None) -> None:
        self._models = models
        self._camera = camera
        self._known: dict[tuple[int, int], tuple[RoofView, ...]] = {}

    def of(self, image: ImageArray) -> tuple[RoofView, ...]:
        """One view per model, for an image (H, W, 3)."""
        size = image.shape[1], image.shape[0]
        if size not in self._known:
            camera = self._camera or straight_down(self._models.focal_px, self._models.height_m, size)
            views = {model.roof_height_m: RoofView.of(camera, model.roof_height_m) for model in self._models.models}
            self._known[size] = tuple(views[model.roof_height_m] for model in self._models.models)
        return self._known[size]

"""Gaussian mixture model (GMM of paper R): the density of a vehicle's colours, evaluated at every pixel."""

import numpy as np

from contracts import ImageArray
from perception.baselines.mask_detector import MaskDetector
from perception.baselines.mixture import monomials

ROWS_AT_ONCE = 16  # that stay in the cache


class ColourMixture(MaskDetector):
    """Detector: a pixel has a vehicle's colour if the mixture of that colour is dense enough there."""

    def masks(self, image: ImageArray) -> tuple[ImageArray, ...]:
        """(H, W) uint8 per colour, 1 where a pixel has it; nothing filled."""
        sizes = [len(colour.mixture.weights) for colour in self.colours]
        starts = np.cumsum([0, *sizes[:-1]])
        least = np.exp(np.array([colour.density_min for colour in self.colours], np.float32))
        coefficients = np.concatenate([colour.mixture.coefficients for colour in self.colours], axis=1)
        masks = np.empty((len(sizes), *image.shape[:2]), np.uint8)
        for top in range(0, len(image), ROWS_AT_ONCE):
            rows = image[top : top + ROWS_AT_ONCE].astype(np.float32)
            densities = np.exp(monomials(rows) @ coefficients.astype(np.float32))  # (R, W, all components)
            dense = np.add.reduceat(densities, starts, axis=-1) >= least  # (R, W, C)
            masks[:, top : top + len(rows)] = np.moveaxis(dense, -1, 0)
        return tuple(masks)

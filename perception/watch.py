"""A cheap look at the whole frame, for colours that show up where they were not before.

One pixel in so many is looked up in a table that says, one bit for each model, which vehicles it may belong to. What
had the colour when the frame was last searched is known, and so are its surroundings; other places are news.
"""

from collections.abc import Collection

import cv2
import numpy as np
from numpy.typing import NDArray

from contracts import ImageArray
from perception.colour_models import ColourModels
from perception.colour_table import coarse_colours, distinctive_colours

STRIDE_PX = 8
NEWS_CELLS = 4  # fewer new cells are noise

Bits = NDArray[np.uint64]


class ColourWatch:
    """Watches one camera for vehicles that come into sight; at most 64 colours."""

    def __init__(self, models: ColourModels) -> None:
        self._bit = {model.label: 1 << k for k, model in enumerate(models.models)}
        bits = np.array(list(self._bit.values()), np.uint64)
        self._table: Bits = np.bitwise_or.reduce(distinctive_colours(models.models) * bits[:, None])
        self._known: Bits | None = None

    def reset(self) -> None:
        """Forget what was known."""
        self._known = None

    def settle(self, image: ImageArray) -> None:
        """The frame (H, W, 3) has been searched: what has a vehicle's colour in it is no news any more."""
        self._known = _spread(self._bits(image))

    def stirs(self, image: ImageArray, ignored: Collection[str]) -> bool:
        """Whether a colour other than the ``ignored`` ones shows where it was not known to be."""
        if self._known is None:
            return True
        wanted = np.uint64(sum(bit for label, bit in self._bit.items() if label not in ignored))
        news = self._bits(image) & ~self._known & wanted
        return int(np.count_nonzero(news)) >= NEWS_CELLS

    def _bits(self, image: ImageArray) -> Bits:
        """(H / s, W / s) which models' colours each looked-at pixel has."""
        height, width = image.shape[:2]
        size = max(1, width // STRIDE_PX), max(1, height // STRIDE_PX)
        cells = np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_NEAREST), np.uint8)
        return np.asarray(self._table.take(coarse_colours(cells)))


def _spread(bits: Bits) -> Bits:
    """Every cell with the bits of its eight neighbours as well."""
    rows = bits.copy()
    rows[1:] |= bits[:-1]
    rows[:-1] |= bits[1:]
    spread = rows.copy()
    spread[:, 1:] |= rows[:, :-1]
    spread[:, :-1] |= rows[:, 1:]
    return spread

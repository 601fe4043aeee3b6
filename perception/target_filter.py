"""What a filter of one target is: start it, find the target, let it learn."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from contracts import FloatArray, ImageArray


@dataclass(frozen=True, eq=False)
class Found:
    """Where a target was found.

    centre_px: (2,) u, v in the image.
    height: the filter's response, about 1 where the target looks as learned.
    confidence: peak to side lobe ratio of the response; low where the target is not there.
    """

    centre_px: FloatArray
    height: float
    confidence: float


@runtime_checkable
class TargetFilter(Protocol):
    """Follows one target; the caller predicts where it is, and may correct what was found before it is learned."""

    def start(self, image: ImageArray, centre_px: FloatArray, size_px: tuple[float, float], angle_rad: float) -> None:
        """Learn a target from one image and forget all before.

        image: (H, W, 3) uint8, BGR. centre_px: (2,) u, v. size_px: along and across.
        angle_rad: of the way along, from u towards v. Raises InputError if the size is not positive.
        """
        ...

    def find(self, image: ImageArray, predicted_centre_px: FloatArray, angle_rad: float) -> Found:
        """Where the target is, near the predicted place and heading as predicted; nothing is learned.

        Raises InputError before ``start``.
        """
        ...

    def learn(self, image: ImageArray, centre_px: FloatArray, angle_rad: float) -> None:
        """Blend what the target looks like at a place into what was learned; InputError before ``start``."""
        ...

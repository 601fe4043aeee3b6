"""One image of one camera: all that perception ever sees."""

from dataclasses import dataclass

import numpy as np

from contracts.arrays import ImageArray
from contracts.errors import InputError


@dataclass(frozen=True, eq=False)
class Frame:
    """An image and where and when it was taken; no pose, no truth.

    camera: name of the camera.
    index: 0 for the first frame of a run.
    time_ns: mid-exposure, nanoseconds since the start of the run.
    image: (H, W, 3) uint8, BGR; read-only.
    """

    camera: str
    index: int
    time_ns: int
    image: ImageArray

    def __post_init__(self) -> None:
        image = np.asarray(self.image)
        if image.dtype != np.uint8 or image.ndim != 3 or image.shape[2] != 3:
            raise InputError(f"Frame.image must be (H, W, 3) uint8 BGR, got {image.shape} {image.dtype}")
        view = np.ascontiguousarray(image).view()  # read-only view: a frame is too large to copy at every door
        view.setflags(write=False)
        object.__setattr__(self, "image", view)

"""Pictures handed from one process to another through shared memory: a pipe would copy each several times."""

import ctypes
from collections.abc import Sequence
from dataclasses import replace
from multiprocessing.context import SpawnContext

import numpy as np

from contracts import Camera, Frame, ImageArray
from contracts.truth import CameraTruth

Take = tuple[Frame, CameraTruth]

_CHANNELS = 4  # blue, green, red, instances
_STUB = np.zeros((1, 1, 3), np.uint8)


class SharedPictures:
    """Room for the frames and instance masks of some cameras at a few moments; made by one process, given to another.

    slots: moments that may be under way at once; moment k lies in slot k modulo ``slots``.
    """

    def __init__(self, context: SpawnContext, cameras: Sequence[Camera], slots: int, *, keep_instances: bool) -> None:
        self._shapes = {camera.name: (camera.intrinsics.height_px, camera.intrinsics.width_px) for camera in cameras}
        self._slots, self._keep_instances = slots, keep_instances
        self._slot_bytes = sum(height * width * _CHANNELS for height, width in self._shapes.values())
        self._memory = context.RawArray(ctypes.c_uint8, slots * self._slot_bytes)

    def put(self, moment: int, takes: Sequence[Take]) -> list[Take]:
        """Lay down the pictures; what remains of the takes is small enough for a pipe."""
        small = []
        for frame, truth in takes:
            image, instances = self._places(moment, frame.camera)
            image[:] = frame.image
            if truth.instances is not None:
                instances[:] = truth.instances
            small.append((replace(frame, image=_STUB), replace(truth, instances=None)))
        return small

    def get(self, moment: int, small: Sequence[Take]) -> list[Take]:
        """The takes with their pictures again, copied, so that the slot is free."""
        takes = []
        for frame, truth in small:
            image, instances = self._places(moment, frame.camera)
            kept = instances if self._keep_instances else None
            takes.append((replace(frame, image=image.copy()), replace(truth, instances=kept)))
        return takes

    def _places(self, moment: int, camera: str) -> tuple[ImageArray, ImageArray]:
        """Where the image (H, W, 3) and the mask (H, W) of one camera lie."""
        start = moment % self._slots * self._slot_bytes
        for name, (height, width) in self._shapes.items():
            size = height * width
            if name == camera:
                both = np.frombuffer(memoryview(self._memory).cast("B"), np.uint8, size * _CHANNELS, start)
                return both[: 3 * size].reshape(height, width, 3), both[3 * size :].reshape(height, width)
            start += size * _CHANNELS
        raise KeyError(camera)

"""Real footage as a source of steps: a video, a folder of images or one image. No truth comes with it."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from contracts import Camera, Frame, InputError
from contracts.truth import Step

os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")  # wrong footage is said once, in our own sentence

IMAGE_SUFFIXES = {".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp"}


class Footage:
    """Frames of one real camera.

    path: a video file, an image file, or a folder of images, which are taken in the order of their names.
    camera: whose image size the frames must have and whose name they bear.
    fps: frames per second; a video brings its own, a folder does not. Frame k is taken at k / fps.
    Raises InputError if there is nothing at ``path`` that can be read as images of that camera.
    """

    def __init__(self, path: Path | str, camera: Camera, *, fps: float | None = None) -> None:
        self._path = Path(path)
        self._camera = camera
        if not self._path.exists():
            raise InputError(f"{self._path} does not exist; footage is a video file or a folder of images")
        if fps is not None and not (np.isfinite(fps) and fps > 0):
            raise InputError(f"--fps {fps:g} is no number of frames per second: it must be positive")
        self.fps = self._own_fps() if fps is None else fps
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise InputError(f"{self._path} does not say how many frames it has per second: give --fps")
        next(self.steps())  # read the first frame, so that wrong footage is refused before anything is made from it

    def steps(self) -> Iterator[Step]:
        """One step per frame, from the start; the same each time."""
        for index, (name, image) in enumerate(self._images()):
            yield Step((self._frame(index, name, image),), None)

    def _own_fps(self) -> float:
        """What a video says of itself; 1 for a single image, 0 for a folder, which does not say."""
        if self._files():
            return 1.0 if self._path.is_file() else 0.0
        return _video_fps(self._path)

    def _images(self) -> Iterator[tuple[str, Any]]:
        files = self._files()
        if files:
            return ((str(file), cv2.imread(str(file), cv2.IMREAD_COLOR)) for file in files)
        return _video_images(self._path)

    def _files(self) -> list[Path]:
        if self._path.is_dir():
            files = sorted(file for file in self._path.iterdir() if file.suffix.lower() in IMAGE_SUFFIXES)
            if not files:
                raise InputError(f"{self._path} holds no image files ({', '.join(sorted(IMAGE_SUFFIXES))})")
            return files
        return [self._path] if self._path.suffix.lower() in IMAGE_SUFFIXES else []

    def _frame(self, index: int, name: str, image: Any) -> Frame:
        if image is None:
            raise InputError(f"{name} is no image that can be read")
        height, width = image.shape[:2]
        wanted = self._camera.intrinsics.width_px, self._camera.intrinsics.height_px
        if (width, height) != wanted:
            raise InputError(
                f"{name} is {width} x {height} pixels, but camera {self._camera.name} has {wanted[0]} x {wanted[1]}"
            )
        return Frame(self._camera.name, index, round(index / self.fps * 1e9), image)


def _open(path: Path) -> cv2.VideoCapture:
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise InputError(f"{path} is no video that can be read")
    return capture


def _video_fps(path: Path) -> float:
    capture = _open(path)
    try:
        return float(capture.get(cv2.CAP_PROP_FPS))
    finally:
        capture.release()


def _video_images(path: Path) -> Iterator[tuple[str, Any]]:
    capture = _open(path)
    index = 0
    try:
        while (read := capture.read())[0]:
            yield f"{path}, frame {index}", read[1]
            index += 1
    finally:
        capture.release()
    if index == 0:
        raise InputError(f"{path} holds no frame that can be read")

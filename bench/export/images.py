"""The recorded images as files, for formats that come with images."""

from collections.abc import Callable
from pathlib import Path

import cv2

from bench.recording_file import load_frames, recorded_cameras
from contracts import Frame


def write_images(directory: Path, path_of: Callable[[Frame], Path]) -> int:
    """Write every image recorded in ``directory`` to ``path_of(frame)``; returns how many there were."""
    count = 0
    for camera in recorded_cameras(directory):
        for frame in load_frames(directory, camera):
            path = path_of(frame)
            path.parent.mkdir(parents=True, exist_ok=True)
            if not cv2.imwrite(str(path), frame.image):
                raise OSError(None, "the image cannot be written", str(path))
            count += 1
    return count

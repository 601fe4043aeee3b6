"""The recorded images as files: ``CAMERA/INDEX.png``, as they are, or where another format wants them."""

from collections.abc import Callable
from pathlib import Path

import cv2

from bench.recording_file import load_frames, recorded_cameras
from contracts import Frame, InputError


def export_images(directory: Path, out: Path) -> Path:
    """Write every recorded image below ``out``, which is returned.

    Raises InputError if the run kept no images.
    """
    if not recorded_cameras(directory):
        raise InputError(f"{directory} holds no images: only `gantry run --frames` keeps them")
    write_images(directory, lambda frame: out / frame.camera / f"{frame.index:06d}.png")
    return out


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

"""COCO object annotations (Lin et al. 2014, cocodataset.org/#format-data): the truth of every image.

``bbox`` is the upright box of the visible pixels, ``segmentation`` the roof as a polygon. COCO measures from the
image's corner, so all coordinates are half a pixel larger than ours. Beside the standard members an annotation says
``object``, ``roof_height_m`` and ``visible_fraction``, an image ``camera``, ``index``, ``time_ns``, ``focal_px`` and
``camera_height_m``.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import msgspec
import numpy as np

from bench.export.images import write_images
from bench.recording import Recording
from bench.recording_file import load_recording
from bench.roofs import roof_quads_px
from contracts import Camera, FloatArray, InputError
from contracts.truth import CameraTruth, Truth

FILE_NAME = "annotations.json"
FROM_CORNER_PX = 0.5  # the first pixel's centre, which is our (0, 0), lies here


@dataclass(frozen=True)
class CocoImage:
    """One image; ``file_name`` is relative to the annotation file."""

    id: int
    file_name: str
    width: int
    height: int
    camera: str = "coco"
    index: int | None = None
    time_ns: int = 0
    focal_px: float | None = None
    camera_height_m: float | None = None


@dataclass(frozen=True)
class CocoAnnotation:
    """One object in one image; ``bbox`` is left, top, width, height."""

    id: int
    image_id: int
    category_id: int
    bbox: tuple[float, float, float, float]
    segmentation: list[list[float]] = field(default_factory=list)
    area: float = 0.0
    iscrowd: int = 0
    object: str = ""
    roof_height_m: float | None = None
    visible_fraction: float = 1.0


@dataclass(frozen=True)
class CocoCategory:
    """A label."""

    id: int
    name: str
    supercategory: str = ""


@dataclass(frozen=True)
class CocoFile:
    """A whole annotation file."""

    images: list[CocoImage]
    annotations: list[CocoAnnotation]
    categories: list[CocoCategory]
    info: dict[str, str] = field(default_factory=dict)


def export_coco(directory: Path, out: Path) -> Path:
    """Write the truth of the run in ``directory`` to ``out/annotations.json``, which is returned, and its images.

    Raises InputError if nothing was filmed or the footage is real and has no truth.
    """
    content = coco_file(load_recording(directory), directory)
    out.mkdir(parents=True, exist_ok=True)
    write_images(directory, lambda frame: out / _file_name(frame.camera, frame.index))
    path = out / FILE_NAME
    path.write_bytes(msgspec.json.format(msgspec.json.encode(content), indent=1))
    return path


def coco_file(recording: Recording, directory: Path) -> CocoFile:
    """The annotations of all images of ``recording``; ``directory`` names it in the error."""
    views = [(step.truth, view) for step in recording.steps if step.truth for view in step.truth.cameras]
    cameras = {camera.name: camera for camera in recording.manifest.true_cameras}
    if not views or not cameras:
        raise InputError(f"{directory} holds no truth of images, so there is nothing to export to COCO")
    labels = sorted({label for truth, _ in views for label in truth.labels})
    categories = [CocoCategory(number, label) for number, label in enumerate(labels, start=1)]
    category_ids = {category.name: category.id for category in categories}
    images = [_image(number, view, cameras[view.camera]) for number, (_, view) in enumerate(views, start=1)]
    annotations = [
        replace(annotation, image_id=image.id, category_id=category_ids[label])
        for image, (truth, view) in zip(images, views, strict=True)
        for label, annotation in _annotations(truth, view, cameras[view.camera])
    ]
    annotations = [replace(annotation, id=number) for number, annotation in enumerate(annotations, start=1)]
    info = {"description": f"{recording.manifest.title} (seed {recording.manifest.seed})"}
    return CocoFile(images, annotations, categories, info)


def _image(number: int, view: CameraTruth, camera: Camera) -> CocoImage:
    name = _file_name(view.camera, view.index)
    size = camera.intrinsics.width_px, camera.intrinsics.height_px
    return CocoImage(
        number,
        name,
        *size,
        camera=view.camera,
        index=view.index,
        time_ns=view.time_ns,
        focal_px=camera.intrinsics.fx_px,
        camera_height_m=float(camera.pose.position_m[2]),
    )


def _annotations(truth: Truth, view: CameraTruth, camera: Camera) -> Iterator[tuple[str, CocoAnnotation]]:
    """Label and annotation of each object that shows, still without its numbers."""
    quads_px = roof_quads_px(truth, camera)  # (N, 4, 2)
    shown = np.isfinite(view.visible_boxes_px).all(axis=1) & np.isfinite(quads_px).all(axis=(1, 2))  # (N,)
    for row in np.flatnonzero(shown).tolist():
        x1, y1, x2, y2 = view.visible_boxes_px[row].tolist()
        yield (
            truth.labels[row],
            CocoAnnotation(
                id=0,
                image_id=0,
                category_id=0,
                bbox=(x1 + FROM_CORNER_PX, y1 + FROM_CORNER_PX, x2 - x1, y2 - y1),
                segmentation=[(quads_px[row] + FROM_CORNER_PX).ravel().tolist()],
                area=_area(quads_px[row]),
                object=truth.ids[row],
                roof_height_m=float(truth.positions_m[row, 2] + truth.sizes_m[row, 2]),
                visible_fraction=float(view.visible_fractions[row]),
            ),
        )


def _area(polygon: FloatArray) -> float:
    x, y = polygon.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)  # the shoelace formula


def _file_name(camera: str, index: int) -> str:
    return f"images/{camera}_{index:06d}.png"

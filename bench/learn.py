"""Training frames for ``perception``: recorded runs with their truth, or real images with COCO marks.

This is the one door through which marks reach perception, and only as training data: nothing here is called by a run.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import cv2
import msgspec
import numpy as np

from bench.export.coco import FROM_CORNER_PX, CocoAnnotation, CocoFile, CocoImage
from bench.recording_file import load_frames, load_recording
from bench.roofs import roof_quads_px
from contracts import Camera, FloatArray, Frame, InputError
from contracts.truth import CameraTruth, Truth
from perception.baselines.colours import PlainColours
from perception.baselines.learning import learn_colours
from perception.colour_models import ColourModels
from perception.learning import LabelledFrame, learn
from perception.view import straight_down


def learn_models(sources: Sequence[Path], out: Path, *, baselines: Path | None = None) -> None:
    """Learn colour models from all ``sources`` (see ``labelled_frames``) and save them as ``out``.

    baselines: where to save what the baselines learn from the same frames.
    Raises InputError if a source cannot be used, if nothing can be learned, or if a file cannot be written.
    """
    models = learn(sample for source in sources for sample in labelled_frames(source))
    _save(models, out)
    if baselines:
        _save(learn_colours(sample for source in sources for sample in labelled_frames(source)), baselines)


def _save(models: ColourModels | PlainColours, path: Path) -> None:
    try:
        models.save(path)
    except OSError as error:
        raise InputError(f"{path} cannot be written: {error.strerror}") from error


def labelled_frames(source: Path | str) -> Iterator[LabelledFrame]:
    """Frames with the roofs of the objects that can be seen in them.

    source: a run recorded with its frames, or a COCO annotation file (``.json``) whose images lie where it says and
        whose annotations say ``roof_height_m`` and whose images say ``focal_px`` and ``camera_height_m``.
    Raises InputError naming what is missing.
    """
    source = Path(source)
    return _from_coco(source) if source.suffix == ".json" else _from_run(source)


def _from_run(directory: Path) -> Iterator[LabelledFrame]:
    recording = load_recording(directory)
    truths = {step.index: step.truth for step in recording.steps if step.truth}
    if not recording.manifest.true_cameras:
        raise InputError(f"{directory} holds no truth to learn from; real images need a COCO file with marks")
    for camera in recording.manifest.true_cameras:
        for frame in load_frames(directory, camera.name):
            truth = truths[frame.index]
            (view,) = (view for view in truth.cameras if view.camera == camera.name)
            yield _with_truth(frame, truth, view, camera)


def _with_truth(frame: Frame, truth: Truth, view: CameraTruth, camera: Camera) -> LabelledFrame:
    quads_px = roof_quads_px(truth, camera)
    rows = (view.visible_fractions > 0) & np.isfinite(quads_px).all(axis=(1, 2))
    heights_m = truth.positions_m[:, 2] + truth.sizes_m[:, 2]
    labels = tuple(label for label, wanted in zip(truth.labels, rows, strict=True) if wanted)
    return LabelledFrame(frame, camera, labels, quads_px[rows], heights_m[rows], view.visible_fractions[rows])


def _from_coco(path: Path) -> Iterator[LabelledFrame]:
    content = _read_coco(path)
    labels = {category.id: category.name for category in content.categories}
    for number, image in enumerate(content.images):
        marks = [mark for mark in content.annotations if mark.image_id == image.id and not mark.iscrowd]
        yield LabelledFrame(
            _coco_frame(path, number, image),
            _coco_camera(path, image),
            tuple(_label(path, labels, mark) for mark in marks),
            np.array([_quad_px(path, mark) for mark in marks]).reshape(-1, 4, 2),
            np.array([_height_m(path, mark) for mark in marks]),
            np.array([mark.visible_fraction for mark in marks]),
        )


def _read_coco(path: Path) -> CocoFile:
    try:
        return msgspec.json.decode(path.read_bytes(), type=CocoFile)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except msgspec.MsgspecError as error:
        raise InputError(f"{path}: is no COCO annotation file: {error}") from error


def _coco_frame(path: Path, number: int, image: CocoImage) -> Frame:
    file = path.parent / image.file_name
    pixels: Any = cv2.imread(str(file), cv2.IMREAD_COLOR) if file.is_file() else None
    if pixels is None:
        raise InputError(f"{path}: image {image.id}: {file} is no image that can be read")
    if pixels.shape[:2] != (image.height, image.width):
        raise InputError(
            f"{path}: image {image.id}: {file} is {pixels.shape[1]} x {pixels.shape[0]} pixels,"
            f" marked as {image.width} x {image.height}"
        )
    return Frame(image.camera, number if image.index is None else image.index, image.time_ns, pixels)


def _coco_camera(path: Path, image: CocoImage) -> Camera:
    if image.focal_px is None or image.camera_height_m is None:
        raise InputError(
            f"{path}: image {image.id} lacks focal_px and camera_height_m, the camera's focal length and height above"
            " ground, without which no size in metres can be learned"
        )
    return straight_down(image.focal_px, image.camera_height_m, (image.width, image.height), name=image.camera)


def _label(path: Path, labels: dict[int, str], mark: CocoAnnotation) -> str:
    if mark.category_id not in labels:
        raise InputError(f"{path}: annotation {mark.id}: there is no category {mark.category_id}")
    return labels[mark.category_id]


def _quad_px(path: Path, mark: CocoAnnotation) -> FloatArray:
    """(4, 2) the marked polygon if it has four corners, the smallest rotated box round it, or the upright box."""
    left, top, width, height = mark.bbox
    upright = [[left, top], [left + width, top], [left + width, top + height], [left, top + height]]
    numbers = np.ravel(mark.segmentation[0] if mark.segmentation else upright).astype(np.float64)
    if len(numbers) < 6 or len(numbers) % 2:
        raise InputError(f"{path}: annotation {mark.id}: its outline is no polygon, but {len(numbers)} numbers")
    outline = numbers.reshape(-1, 2)
    if len(outline) != 4:
        outline = np.asarray(cv2.boxPoints(cv2.minAreaRect(outline.astype(np.float32))), dtype=np.float64)
    return outline - FROM_CORNER_PX


def _height_m(path: Path, mark: CocoAnnotation) -> float:
    if mark.roof_height_m is None:
        raise InputError(f"{path}: annotation {mark.id} lacks roof_height_m, the height of its upper face above ground")
    return mark.roof_height_m

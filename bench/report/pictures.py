"""Sample frames with what was there and what was found drawn over them, and each vehicle enlarged beside."""

import base64
import re
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from bench.recording import RecordedStep
from bench.recording_file import load_frames, recorded_cameras
from bench.report.material import ReportedRun
from bench.roofs import roof_quads_px
from bench.scoring.population import MatchedFrame
from contracts import FloatArray, ImageArray, Tracks

MAX_PICTURES = 8
JPEG_QUALITY = 88
CROP_PX = (150, 100)  # least width and height of an enlarged part
Window = tuple[float, float, float, float]  # x, y, width, height in pixels of the frame
_SAMPLE = re.compile(r"(?P<camera>.+)_(?P<index>\d{6})\.(png|jpg)")


@dataclass(frozen=True, eq=False)
class Picture:
    """One frame of one camera; ``image`` is (H, W, 3) BGR."""

    camera: str
    index: int
    image: ImageArray


def sample_pictures(run: ReportedRun) -> list[Picture]:
    """A few frames spread over the run: those kept as samples, else from the recorded ones, else none."""
    files = {
        (int(found["index"]), found["camera"]): file
        for file in sorted((run.directory / "samples").glob("*"))
        if (found := _SAMPLE.fullmatch(file.name))
    }
    cameras = {camera for _, camera in files}
    moments = _spread(sorted({index for index, _ in files}), MAX_PICTURES // max(1, len(cameras)))
    chosen = [(camera, index, file) for (index, camera), file in sorted(files.items()) if index in moments]
    return [Picture(camera, index, _read(file)) for camera, index, file in chosen] or list(_recorded(run))


def picture_html(run: ReportedRun, picture: Picture) -> str:
    """A figure: the frame with its overlay, then every vehicle in it enlarged."""
    step = next(step for step in run.recording.steps if step.index == picture.index)
    tracks = next((one for one in step.tracks if one.objects.camera == picture.camera), None)
    name = f"frame-{re.sub(r'[^a-zA-Z0-9]', '-', f'{run.name}-{picture.camera}')}-{picture.index}"
    height, width = picture.image.shape[:2]
    marks = [*(_track_marks(tracks) if tracks else ()), *_true_marks(run, step, picture.camera)]
    image = f'<image id="{name}" x="-0.5" y="-0.5" width="{width}" height="{height}" href="{data_url(picture.image)}"/>'
    whole = _svg(image + "".join(marks), (-0.5, -0.5, width, height), "frame")
    used = f'<use href="#{name}"/>'
    crops = [
        f"<figure>{_svg(used + ''.join(marks), window, 'crop')}<figcaption>{caption}</figcaption></figure>"
        for window, caption in _enlarged(run, step, picture.camera, tracks)
    ]
    title = f"camera {picture.camera}, frame {picture.index}, {step.time_ns / 1e9:.2f} s"
    return (
        f'<figure class="picture">{whole}<figcaption>{escape(title)}</figcaption>'
        f'<div class="crops">{"".join(crops)}</div></figure>'
    )


def _recorded(run: ReportedRun) -> Iterator[Picture]:
    cameras = recorded_cameras(run.directory)
    indices = _spread([step.index for step in run.recording.steps], MAX_PICTURES // max(1, len(cameras)))
    for camera in cameras:
        for frame in islice(load_frames(run.directory, camera), indices[-1] + 1 if indices else 0):
            if frame.index in indices:
                yield Picture(camera, frame.index, frame.image)


def _spread(values: list[int], count: int) -> list[int]:
    """At most ``count`` of ``values``, evenly spread."""
    if len(values) <= count:
        return values
    return [values[k] for k in np.linspace(0, len(values) - 1, max(count, 1)).round().astype(int)]


def _read(file: Path) -> ImageArray:
    image = cv2.imread(str(file), cv2.IMREAD_COLOR)
    return np.zeros((1, 1, 3), dtype=np.uint8) if image is None else np.asarray(image, dtype=np.uint8)


def data_url(image: ImageArray) -> str:
    """A picture as it stands in a page: JPEG in base 64."""
    _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
    return f"data:image/jpeg;base64,{base64.b64encode(jpeg.tobytes()).decode()}"


def _true_marks(run: ReportedRun, step: RecordedStep, camera: str) -> Iterator[str]:
    """The true roofs and their centres."""
    cameras = {one.name: one for one in run.recording.manifest.true_cameras}
    if step.truth is None or camera not in cameras:
        return
    view = next((view for view in step.truth.cameras if view.camera == camera), None)
    if view is None:
        return
    quads_px = roof_quads_px(step.truth, cameras[camera])
    for quad, roof, fraction in zip(quads_px, view.roofs_px, view.visible_fractions, strict=True):
        if fraction > 0 and np.isfinite(quad).all():
            yield _polygon("true", quad) + _dot("true", roof)


def _track_marks(tracks: Tracks) -> Iterator[str]:
    for quad, anchor in zip(tracks.objects.quads_px, tracks.objects.anchors_px, strict=True):
        yield _polygon("found", quad) + _dot("found", anchor)


def _enlarged(run: ReportedRun, step: RecordedStep, camera: str, tracks: Tracks | None) -> Iterator[tuple[Window, str]]:
    """Window and caption of every vehicle found, then of every one that was missed."""
    said = _verdicts(run, step, camera)
    if tracks:
        for box, label, track in zip(tracks.objects.boxes_px, tracks.objects.labels, tracks.ids.tolist(), strict=True):
            yield _window(box), f"<b>{escape(label)}</b> {said.get(track, '')}"
    frame = _matched_frame(run, step, camera)
    if frame is None:
        return
    for row in frame.matching.misses.tolist():
        view = next(view for view in frame.truth.cameras if view.camera == camera)
        yield _window(view.visible_boxes_px[row]), f"<b>{escape(frame.truth.ids[row])}</b> missed"


def _verdicts(run: ReportedRun, step: RecordedStep, camera: str) -> dict[int, str]:
    """What is said of every track of a frame, by track: its errors, or why it has none."""
    frame = _matched_frame(run, step, camera)
    if frame is None:
        return {}
    tracks = frame.ground.ids
    said = {int(tracks[row]): "partly hidden: not scored" for row in frame.matching.ignored[:, 1]}
    said |= {int(tracks[row]): "false alarm" for row in frame.matching.false_alarms}
    seen = run.seen[camera]
    for k in np.flatnonzero(seen.hits.index == step.index).tolist():
        (du, dv), (dx, dy) = seen.errors_px[k], 1000 * seen.hits.errors_m[k]
        said[int(seen.hits.track_ids[k])] = f"anchor {du:+.2f}, {dv:+.2f} px; position {dx:+.2f}, {dy:+.2f} mm"
    return said


def _matched_frame(run: ReportedRun, step: RecordedStep, camera: str) -> MatchedFrame | None:
    frames = run.cameras[camera].frames if camera in run.cameras else ()
    return next((frame for frame in frames if frame.truth.index == step.index), None)


def _window(box_px: FloatArray) -> Window:
    """x, y, width, height of the part of the image to enlarge, with a margin, in one shape for all."""
    centre = (box_px[:2] + box_px[2:]) / 2
    width = max(1.5 * (box_px[2] - box_px[0]), 1.5 * (box_px[3] - box_px[1]) * CROP_PX[0] / CROP_PX[1], CROP_PX[0])
    height = width * CROP_PX[1] / CROP_PX[0]
    return float(centre[0] - width / 2), float(centre[1] - height / 2), float(width), float(height)


def _svg(content: str, window: Window, css: str) -> str:
    return f'<svg class="{css}" viewBox="{" ".join(f"{value:.2f}" for value in window)}">{content}</svg>'


def _polygon(css: str, quad_px: FloatArray) -> str:
    return f'<polygon class="{css}" points="{" ".join(f"{u:.2f},{v:.2f}" for u, v in quad_px)}"/>'


def _dot(css: str, point_px: FloatArray) -> str:
    """A dot of the same size at any magnification: the round end of a line without length."""
    u, v = point_px
    return f'<path class="{css} dot" d="M{u:.2f} {v:.2f}h0"/>' if np.isfinite(point_px).all() else ""

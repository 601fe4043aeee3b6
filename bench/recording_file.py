"""A run on disk: ``run.mcap``, JSON messages that MCAP viewers such as Foxglove read as they are.

Topics: ``/manifest`` once; per step ``/truth``, ``/frames/CAMERA`` (PNG, on request), ``/tracks/CAMERA``,
``/ground/CAMERA``, ``/ledger/CAMERA``, ``/motion`` and last ``/ground/fused``, which ends the step.
Instance masks are not kept.
"""

import base64
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeVar

import cv2
import numpy as np

from bench.codec import decode, encode, json_schema
from bench.messages import Message, MessageReader, MessageWriter
from bench.recording import LedgerEntry, Manifest, RecordedStep, Recording
from contracts import Frame, GroundTracks, InputError, Motions, Tracks
from contracts.ground import FUSED
from contracts.truth import Truth

T = TypeVar("T")
RECORDING_NAME = "run.mcap"
_PNG_FAST = (cv2.IMWRITE_PNG_COMPRESSION, 1)  # more effort costs time and hardly saves space


@dataclass(frozen=True)
class CompressedImage:
    """An image in the form that viewers know as ``foxglove.CompressedImage``; ``data`` is base64."""

    timestamp: dict[str, int]
    frame_id: str
    data: str
    format: str


_TOPICS: dict[type, str] = {
    Manifest: "/manifest",
    Truth: "/truth",
    CompressedImage: "/frames",
    Tracks: "/tracks",
    GroundTracks: "/ground",
    LedgerEntry: "/ledger",
    Motions: "/motion",
}
_SCHEMAS = {kind: json_schema(kind) | {"title": f"gantry.{kind.__name__}"} for kind in _TOPICS}
_SCHEMAS[CompressedImage]["title"] = "foxglove.CompressedImage"


class Recorder:
    """Writes a run, step by step, into ``directory/run.mcap``; to be used in a ``with`` statement.

    The file gets its name when everything has been written: if the block fails, an earlier recording stays as it was
    and nothing else is left.

    keep_frames: store the images too, as PNG, without loss.
    Raises InputError if the directory cannot be made or written to.
    """

    def __init__(self, directory: Path | str, manifest: Manifest, *, keep_frames: bool = False) -> None:
        self._path = Path(directory) / RECORDING_NAME
        self._partial = self._path.with_suffix(".mcap.part")
        self._manifest = manifest
        self._keep_frames = keep_frames

    def __enter__(self) -> Self:
        payload = encode(self._manifest)  # first, so that a manifest that cannot be written leaves no file
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._stream = self._partial.open("wb")
        except OSError as error:
            raise InputError(f"{self._path.parent} cannot hold a recording: {error.strerror}") from error
        self._writer = MessageWriter(self._stream)
        self._writer.write(Message(_TOPICS[Manifest], 0, 0, payload), _SCHEMAS[Manifest])
        return self

    def write(self, step: RecordedStep, frames: Sequence[Frame] = ()) -> None:
        """Append a step; ``frames`` are stored only if the recorder was told to keep them."""
        if step.truth is not None:
            self._write(step, _without_masks(step.truth))
        for frame in frames if self._keep_frames else ():
            self._write(step, _compressed(frame), frame.camera)
        for tracks in step.tracks:
            self._write(step, tracks, tracks.objects.camera)
        for view in step.views:
            if view.source == FUSED:
                raise InputError(f"a camera cannot be named {FUSED!r}: that is the name of all cameras together")
            self._write(step, view, view.source)
        for entry in step.ledger:
            self._write(step, entry, entry.camera)
        self._write(step, step.motions)
        self._write(step, step.fused, FUSED)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            with self._stream:
                if kind is None:
                    self._writer.finish()
            if kind is None:
                self._partial.replace(self._path)
        finally:
            self._partial.unlink(missing_ok=True)

    def _write(self, step: RecordedStep, value: object, camera: str = "") -> None:
        topic = _TOPICS[type(value)] + (f"/{camera}" if camera else "")
        self._writer.write(Message(topic, step.index, step.time_ns, encode(value)), _SCHEMAS[type(value)])


def load_recording(directory: Path | str, *, salvage: bool = False) -> Recording:
    """Read the run in ``directory`` (or the ``.mcap`` file itself).

    salvage: take the whole steps that can still be read of a damaged or cut file.
    Raises InputError naming the file if it is missing, empty, foreign, or damaged.
    """
    path = recording_path(directory)
    messages = MessageReader(path)
    manifest: Manifest | None = None
    steps: list[RecordedStep] = []
    parts = _Parts()
    for message in messages:
        if message.topic == _TOPICS[Manifest]:
            manifest = _decode(path, message, Manifest)
        elif message.topic == f"{_TOPICS[GroundTracks]}/{FUSED}":
            steps.append(parts.whole(message, _decode(path, message, GroundTracks)))
            parts = _Parts()
        else:
            parts.add(path, message)
    if messages.damage and not (salvage and manifest):
        left = f"{len(steps)} whole steps of it can be read with salvage=True" if steps else "no whole step is left"
        raise InputError(f"{path} {messages.damage}; {left}")
    if manifest is None:
        raise InputError(f"{path} is no recording of Gantry: nothing in it says what was run")
    return Recording(manifest, tuple(steps))


def load_frames(directory: Path | str, camera: str) -> Iterator[Frame]:
    """The recorded images of ``camera`` in order.

    Raises InputError if the file cannot be read or holds no images of that camera.
    """
    path = recording_path(directory)
    kept = recorded_cameras(directory)
    if camera not in kept:
        raise InputError(
            f"{path} holds no images of camera {camera!r}, only those of: {', '.join(kept) or 'none'}"
            " (`gantry run --frames` keeps images)"
        )
    messages = MessageReader(path)
    for message in messages:
        if message.topic == f"{_TOPICS[CompressedImage]}/{camera}":
            yield _frame(path, camera, message)
    if messages.damage:
        raise InputError(f"{path} {messages.damage}; its images end early")


def recorded_cameras(directory: Path | str) -> tuple[str, ...]:
    """The cameras whose images were recorded, in order; none unless the run was told to keep frames.

    Raises InputError if the file cannot be read.
    """
    path = recording_path(directory)
    topics = MessageReader(path).topics()
    prefix = f"{_TOPICS[CompressedImage]}/"
    return tuple(topic.removeprefix(prefix) for topic in topics if topic.startswith(prefix))


def recording_path(directory: Path | str) -> Path:
    """The recording's file in ``directory``. Raises InputError if there is none or it is empty."""
    path = Path(directory)
    path = path if path.suffix == ".mcap" else path / RECORDING_NAME
    if not path.is_file():
        raise InputError(f"{path} does not exist; `gantry run SCENARIO --out {path.parent}` makes a recording")
    if path.stat().st_size == 0:
        raise InputError(f"{path} is empty: that is no recording")
    return path


@dataclass
class _Parts:
    """What has been read of a step so far."""

    truth: Truth | None = None
    tracks: list[Tracks] = field(default_factory=list)
    views: list[GroundTracks] = field(default_factory=list)
    motions: Motions | None = None
    ledger: list[LedgerEntry] = field(default_factory=list)

    def add(self, path: Path, message: Message) -> None:
        match message.topic.split("/")[1]:
            case "truth":
                self.truth = _decode(path, message, Truth)
            case "tracks":
                self.tracks.append(_decode(path, message, Tracks))
            case "ground":
                self.views.append(_decode(path, message, GroundTracks))
            case "motion":
                self.motions = _decode(path, message, Motions)
            case "ledger":
                self.ledger.append(_decode(path, message, LedgerEntry))

    def whole(self, message: Message, fused: GroundTracks) -> RecordedStep:
        return RecordedStep(
            index=message.index,
            time_ns=message.time_ns,
            truth=self.truth,
            tracks=tuple(self.tracks),
            views=tuple(self.views),
            fused=fused,
            motions=self.motions or Motions.unknown(fused),  # recordings from before there was an analyst
            ledger=tuple(self.ledger),
        )


def _decode(path: Path, message: Message, kind: type[T]) -> T:
    try:
        return decode(message.data, kind)
    except InputError as error:
        raise InputError(f"{path}: {message.topic} of step {message.index}: {error}") from error


def _without_masks(truth: Truth) -> Truth:
    return replace(truth, cameras=tuple(replace(view, instances=None) for view in truth.cameras))


def _compressed(frame: Frame) -> CompressedImage:
    _, png = cv2.imencode(".png", frame.image, _PNG_FAST)
    sec, nsec = divmod(frame.time_ns, 1_000_000_000)
    data = base64.b64encode(png.tobytes()).decode()
    return CompressedImage({"sec": sec, "nsec": nsec}, frame.camera, data, "png")


def _frame(path: Path, camera: str, message: Message) -> Frame:
    png = base64.b64decode(_decode(path, message, CompressedImage).data)
    image: Any = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    if image is None:
        raise InputError(f"{path}: {message.topic} of step {message.index} is no image")
    return Frame(camera, message.index, message.time_ns, image)

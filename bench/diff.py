"""Where two runs part: the first frame, and in it the earliest stage."""

from collections.abc import Iterator
from dataclasses import dataclass, fields

from bench.codec import encode
from bench.ledger import state_hash, value_hash
from bench.recording import Manifest, RecordedStep, Recording
from contracts.ground import FUSED

STAGES = ("state", "view", "image", "tracks", "ground", "motion")
"""In the order of the flow: world, what a camera sees of it by the truth, image, tracks, ground tracks, motion."""


@dataclass(frozen=True)
class Difference:
    """How two runs differ.

    index: of the first frame that differs; None if only the manifests differ.
    stage: the earliest stage that differs in that frame, one of ``STAGES``; ``"length"`` if one run ends there;
        ``"manifest"`` if all frames are equal.
    camera: where that is the camera's matter, else ``""``.
    manifest: names of the manifest's fields that differ.
    """

    index: int | None
    stage: str
    camera: str
    manifest: tuple[str, ...]

    def __str__(self) -> str:
        told = f"; their manifests differ in {', '.join(self.manifest)}" if self.manifest else ""
        if self.index is None:
            return f"All frames are equal{told}."
        if self.stage == "length":
            return f"The runs are equal until one of them ends at frame {self.index}{told}."
        where = f" of camera {self.camera}" if self.camera else ""
        return f"The runs first differ in frame {self.index}, stage {self.stage}{where}{told}."


def first_difference(a: Recording, b: Recording) -> Difference | None:
    """The first frame in which two runs differ and in it the earliest stage; None if they are equal to the bit.

    Manifests are compared too, but frames come first: two seeds may well film the same traffic.
    """
    manifest = _manifest_fields(a.manifest, b.manifest)
    for one, other in zip(a.steps, b.steps, strict=False):
        found = _first_stage(one, other)
        if found:
            return Difference(one.index, *found, manifest)
    shared = min(len(a.steps), len(b.steps))
    if len(a.steps) != len(b.steps):
        longer = max(a.steps, b.steps, key=len)
        return Difference(longer[shared].index, "length", "", manifest)
    return Difference(None, "manifest", "", manifest) if manifest else None


def _manifest_fields(a: Manifest, b: Manifest) -> tuple[str, ...]:
    names = [field.name for field in fields(Manifest)]
    return tuple(name for name in names if encode(getattr(a, name)) != encode(getattr(b, name)))


def _first_stage(a: RecordedStep, b: RecordedStep) -> tuple[str, str] | None:
    ours, theirs = dict(_hashes(a)), dict(_hashes(b))
    different = [key for key in ours | theirs if ours.get(key) != theirs.get(key)]
    return min(different, key=lambda key: STAGES.index(key[0]), default=None)


def _hashes(step: RecordedStep) -> Iterator[tuple[tuple[str, str], str]]:
    """((stage, camera), hash) of all that a step holds."""
    yield ("state", ""), f"{step.index} {step.time_ns} {state_hash(step.truth) if step.truth else ''}"
    for view in step.truth.cameras if step.truth else ():
        yield ("view", view.camera), value_hash(view)
    for entry in step.ledger:
        yield ("image", entry.camera), entry.image
    for tracks in step.tracks:
        yield ("tracks", tracks.objects.camera), value_hash(tracks)
    for ground in (*step.views, step.fused):
        yield ("ground", "" if ground.source == FUSED else ground.source), value_hash(ground)
    yield ("motion", ""), value_hash(step.motions)

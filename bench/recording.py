"""A run as it is scored, replayed and exported: everything that crossed from room to room."""

from dataclasses import dataclass

from contracts import Camera, GroundTracks, Motions, Survey, Tracks
from contracts.truth import Truth
from georef.calibrated import CalibratedCamera


@dataclass(frozen=True, eq=False)
class Manifest:
    """What was run, with what.

    title, world: of the scenario.
    stages: the implementation that served each stage, by stage name (``"detector"``, ``"renderer"``, ...).
    oracles: stages that were given the truth, by name; empty in an honest run.
    versions: of the packages that decide the result.
    survey: nominal cameras and marks; None for real footage.
    true_cameras: for the score only; empty for real footage.
    calibrated_cameras: the cameras that the location used.
    geo: PROJ string of the world's metres where it lies somewhere on the globe; None for a plant in a room.
    """

    scenario: str
    title: str
    world: str
    seed: int
    fps: float
    stages: dict[str, str]
    oracles: tuple[str, ...]
    versions: dict[str, str]
    survey: Survey | None
    true_cameras: tuple[Camera, ...]
    calibrated_cameras: tuple[CalibratedCamera, ...]
    geo: str | None = None

    @property
    def cameras(self) -> dict[str, Camera]:
        """The cameras by name: the true ones where they are known, else as calibrated."""
        known = self.true_cameras or tuple(calibrated.camera for calibrated in self.calibrated_cameras)
        return {camera.name: camera for camera in known}


@dataclass(frozen=True)
class LedgerEntry:
    """Hashes of one camera's frame by stage; an empty string where a stage left nothing.

    The stages in the order of the flow: the world's state, the image, the tracks, the ground tracks.
    """

    index: int
    camera: str
    state: str
    image: str
    tracks: str
    ground: str


@dataclass(frozen=True, eq=False)
class RecordedStep:
    """All that is known of one moment. ``truth`` is None for real footage; the tuples have one entry per camera.

    motions: of the fused objects, row for row.
    """

    index: int
    time_ns: int
    truth: Truth | None
    tracks: tuple[Tracks, ...]
    views: tuple[GroundTracks, ...]
    fused: GroundTracks
    motions: Motions
    ledger: tuple[LedgerEntry, ...]


@dataclass(frozen=True, eq=False)
class Recording:
    """A whole run."""

    manifest: Manifest
    steps: tuple[RecordedStep, ...]

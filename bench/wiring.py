"""Chooses the stages of a run: the only place that knows which implementation serves by default."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from bench import oracles
from bench.plugins import load_object
from bench.run import Chain, Perception
from contracts import (
    Analyst,
    Camera,
    Detector,
    FloatArray,
    Frame,
    GroundTracks,
    InputError,
    Locator,
    Perceiver,
    Tracker,
    Tracks,
)
from contracts.truth import Step, World
from georef.calibrate import calibrate_with_lens, lens_of
from georef.calibrated import CalibratedCamera
from georef.fusion import CovarianceFuser
from georef.intrinsics import IntrinsicCalibration
from georef.location import GroundPlaneLocator, RayPlaneLocator
from georef.map_ground import MapGround, MapGroundLocator
from georef.motion import WindowAnalyst
from perception.baselines.colour_mixture import ColourMixture
from perception.baselines.colour_range import ColourRange
from perception.baselines.colour_ratio import ColourRatio
from perception.colour_models import SHIPPED, ColourModels
from perception.filter_tracker import FilterTracker
from perception.hbp import HistogramBackProjection
from perception.hybrid import HybridTracker
from perception.identity import ColourIdentity
from perception.kcf import CorrelationTracker, KcfSettings
from perception.mosse import MosseFilter
from perception.perceiver import DetectThenTrack
from sim.renderer import RendererName

DETECTORS: dict[str, Callable[[ColourModels, Camera], Detector]] = {
    "hbp": HistogramBackProjection,
    "crd": ColourRange,
    "ccr": ColourRatio,
    "gmm": ColourMixture,
}
Lines = Sequence[FloatArray]  # the plan of the track, as in ``contracts.Survey``
PERCEIVERS: dict[str, Callable[[ColourModels, Camera, Lines], Perceiver]] = {
    "hybrid": lambda models, camera, lines: HybridTracker(models, camera, centrelines_m=lines),
    "kcf": lambda models, camera, _: FilterTracker(HistogramBackProjection(models, camera), CorrelationTracker),
    "mosse": lambda models, camera, _: FilterTracker(HistogramBackProjection(models, camera), MosseFilter),
}
LOCATORS = {"ray": RayPlaneLocator, "plane0": GroundPlaneLocator}
USUAL, ON_MAP = "ray", "map"  # the locator where none is named, and the one that needs a map


@dataclass(frozen=True)
class Stages:
    """Which implementation serves each stage: None for the bench's own, or a path such as ``my_pkg.mod:Mine``.

    detector: also one of ``DETECTORS``; it searches every frame.
    perceiver: detector and tracker in one, so that neither may stand beside it; also one of ``PERCEIVERS``, whose first
        one serves where nothing is given.
    model: file of colour models for the bench's own detector.
    locator: ``ray`` meets the plane at the anchor's height; ``map``, the road's own, the ground of its map;
        ``plane0`` is the naive projection to z = 0.
    analyst: tells direction and speed.
    calibrator: of the road's cameras: ``picks`` made by hand, or ``frames`` alone (``bench.road_calibration``).
    oracles: stages that are given the truth.
    renderer: how a simulated world draws its frames: ``layered``, or ``full``, its slow oracle.
    """

    detector: str | None = None
    tracker: str | None = None
    perceiver: str | None = None
    model: Path = SHIPPED
    locator: str | None = None
    analyst: str | None = None
    calibrator: str | None = None
    oracles: tuple[str, ...] = ()
    renderer: str = RendererName.LAYERED

    def __post_init__(self) -> None:
        for oracle in self.oracles:
            if oracle not in oracles.ORACLES:
                raise InputError(f"--oracle {oracle}: no such oracle, choose from {', '.join(oracles.ORACLES)}")
        known = (*LOCATORS, ON_MAP)
        if self.locator not in (None, *known):
            raise InputError(f"--locator {self.locator}: no such locator, choose from {', '.join(known)}")
        if self.renderer not in list(RendererName):
            raise InputError(f"--renderer {self.renderer}: no such renderer, choose from {', '.join(RendererName)}")
        self._check_eyes()

    def _check_eyes(self) -> None:
        """What would never be asked is refused: what an oracle or a perceiver stands in for."""
        given = {"--perceiver": self.perceiver, "--detector": self.detector, "--tracker": self.tracker}
        named = [f"{option} {name}" for option, name in given.items() if name]
        if named and "detect" in self.oracles:
            raise InputError(f"--oracle detect stands for {named[0]}: give one of them")
        if self.perceiver and len(named) > 1:
            raise InputError(f"{named[0]} is detector and tracker in one: leave {' and '.join(named[1:])} away")

    @property
    def needs_film(self) -> bool:
        """False where the truth of the ground itself is given, so that no frame is looked at."""
        return "locate" not in self.oracles

    def names(self) -> dict[str, str]:
        """The implementation of every stage, for the manifest."""
        if not self.needs_film:
            return {"locator": "oracle", "analyst": self.analyst or "window"}
        own = f"map, {self.calibrator}" if self.calibrator else "checkerboard and control points"
        calibrator = "oracle" if "calibrate" in self.oracles else own
        places = {"calibrator": calibrator, "locator": self.locator or USUAL, "fuser": "covariance"}
        return {**self._eyes(), **places, "analyst": self.analyst or "window"}

    def _eyes(self) -> dict[str, str]:
        if "detect" in self.oracles:
            return {"perceiver": "oracle"}
        if self._whole is not None:
            return {"perceiver": self._with_model(self._whole, PERCEIVERS)}
        return {
            "detector": self._with_model(self.detector or "hbp", DETECTORS),
            "tracker": self.tracker or "colour identity",
        }

    def _with_model(self, name: str, own: Collection[str]) -> str:
        return f"{name} ({self.model.name})" if name in own else name

    @property
    def _whole(self) -> str | None:
        """The perceiver that serves, if it is not put together from a detector and a tracker."""
        default = None if self.detector or self.tracker else next(iter(PERCEIVERS))
        return self.perceiver or default

    def make_perceiver(self, camera: Camera, centrelines_m: Lines = ()) -> Perceiver:
        """A fresh perceiver for one camera, which is told what the owner knows of the camera and of the track."""
        if self._whole in PERCEIVERS:
            return PERCEIVERS[self._whole](ColourModels.load(self.model), camera, centrelines_m)
        if self._whole is not None:
            whole: Perceiver = load_object(self._whole, Perceiver)
            return whole
        tracker: Tracker = load_object(self.tracker, Tracker) if self.tracker else ColourIdentity()
        return DetectThenTrack(self.make_detector(camera), tracker)

    def make_detector(self, camera: Camera) -> Detector:
        """A fresh detector for one camera, which is told what the camera's owner knows of it."""
        name = self.detector or "hbp"
        if name in DETECTORS:
            return DETECTORS[name](ColourModels.load(self.model), camera)
        detector: Detector = load_object(name, Detector)
        return detector

    def make_analyst(self) -> Analyst:
        """A fresh analyst of the fused tracks."""
        analyst: Analyst = load_object(self.analyst, Analyst) if self.analyst else WindowAnalyst()
        return analyst


TABLE_DETECTORS = {"CRD": "crd", "CCR": "ccr", "GMM": "gmm", "HBP": "hbp"}
"""Detectors that the remade tables compare, by the paper's name."""

TABLE_TRACKERS: dict[str, Stages] = {
    "detection in every frame": Stages(detector="hbp"),
    "MOSSE": Stages(perceiver="mosse"),
    "KCF": Stages(perceiver="kcf"),
    "hybrid": Stages(perceiver="hybrid"),
}
"""Perceivers that the remade tables compare; the last one is the chain's own."""


TABLE_REGION_SIZES = (1.25, 1.5, 2.0, 2.5, 3.0, 4.0)


def region_perceiver(size: float) -> Callable[[Camera], Perceiver]:
    """Makes correlation filters by themselves whose region is ``size`` times as long and wide as the vehicle."""
    usual = KcfSettings()
    settings = replace(usual, padding=size, samples=max(64, round(usual.samples * (size / usual.padding) ** 2)))

    def make(camera: Camera) -> Perceiver:
        detector = HistogramBackProjection(ColourModels.load(SHIPPED), camera)
        return FilterTracker(detector, partial(CorrelationTracker, settings))

    return make


TABLE_REGIONS = {size: region_perceiver(size) for size in TABLE_REGION_SIZES}
"""Perceivers by the size of the region that they track, for the remade tables."""


def make_perception(stages: Stages, cameras: Iterable[Camera], centrelines_m: Lines = ()) -> Perception:
    """What turns a step into the tracks of every camera."""
    if not stages.needs_film:
        return lambda _: ()
    if "detect" in stages.oracles:
        return oracles.TrueDetection().perceive
    perceivers = {camera.name: stages.make_perceiver(camera, centrelines_m) for camera in cameras}

    def perceive(step: Step) -> tuple[Tracks, ...]:
        return tuple(perceivers[frame.camera].perceive(frame) for frame in step.frames)

    return perceive


def board_lenses(world: World, stages: Stages) -> dict[str, IntrinsicCalibration]:
    """The lens of every camera from its checkerboard views; empty where the calibration is given as an oracle."""
    if "calibrate" in stages.oracles:
        return {}
    return {
        nominal.name: lens_of(nominal, tuple(world.board_views(nominal.name)), world.survey.board)
        for nominal in world.survey.cameras
    }


def calibrated_cameras(
    world: World, lenses: Mapping[str, IntrinsicCalibration], frames: Sequence[Frame]
) -> tuple[CalibratedCamera, ...]:
    """Calibrate every camera from its lens, as ``board_lenses`` found it, and the control points in its first frame.

    The calibrator is given the survey (nominal cameras, surveyed points), and the true camera only as an oracle: where
    there are no lenses.
    """
    if not lenses:
        return tuple(oracles.true_camera(camera) for camera in world.cameras)
    first_frames = {frame.camera: frame for frame in frames}
    return tuple(
        calibrate_with_lens(nominal, lenses[nominal.name], first_frames[nominal.name], world.survey.control_points_m)
        for nominal in world.survey.cameras
    )


def make_chain(
    stages: Stages,
    perceive: Perception,
    cameras: Sequence[CalibratedCamera],
    *,
    one_per_label: bool = True,
    ground: MapGround | None = None,
) -> Chain:
    """The chain of a run over ``cameras``.

    ground: of the map, for the locator that needs it; InputError where it is missing.
    one_per_label: whether no two objects bear the same label, as on the rail, where a colour is an identity.
    """
    analyse = stages.make_analyst().analyse
    if not stages.needs_film:
        fuse = CovarianceFuser().fuse
        return Chain(perceive=perceive, locate=oracles.TrueLocation().locate, fuse=fuse, analyse=analyse)
    locator = _locator(stages.locator or USUAL, {calibrated.camera.name: calibrated for calibrated in cameras}, ground)

    def locate(_: Step, tracks: tuple[Tracks, ...]) -> tuple[GroundTracks, ...]:
        return tuple(locator.locate(each) for each in tracks)

    fuse = CovarianceFuser(one_per_label=one_per_label).fuse
    return Chain(perceive=perceive, locate=locate, fuse=fuse, analyse=analyse)


def _locator(name: str, cameras: Mapping[str, CalibratedCamera], ground: MapGround | None) -> Locator:
    if name != ON_MAP:
        return LOCATORS[name](cameras)
    if ground is None:
        raise InputError(f"--locator {ON_MAP} is for the road: nothing else here has a map")
    return MapGroundLocator(cameras, ground)

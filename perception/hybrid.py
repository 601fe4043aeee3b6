"""The hybrid tracker of paper R: the whole frame searched at the start, now and then, and on loss; in between a window.

In every frame a vehicle is predicted by its last motion, sought there by its correlation filter, and its roof measured
where the filter found it; that measurement is the anchor and proposes the next window, so that nothing drifts, on
curves neither. A colour that shows up where it was not before calls the search at once, and so does a lost roof.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from contracts import Camera, Detections, FloatArray, Frame, InputError, Tracks
from perception.anchor import complete_roof
from perception.colour_models import SHIPPED, SINGLE, ColourModel, ColourModels
from perception.hbp import HistogramBackProjection
from perception.identity import ColourIdentity
from perception.kcf import CorrelationTracker
from perception.model_views import ModelViews
from perception.roof_cover import COVERED_PX, within_border
from perception.roof_following import (
    REFIT_EVERY,
    FollowedRoof,
    follow_part,
    follow_roof,
    resume_following,
    start_following,
)
from perception.roof_window import RoofPose
from perception.track_bed import TrackBeds
from perception.view import RoofView
from perception.watch import ColourWatch

CONFIDENT = 6.0  # peak to side lobe ratio from which the filter's peak is believed
PREDICTABLE_PX = 1.5  # a filter's peak so near to the prediction does not better it; something may cover the vehicle
WHOLE = 0.93  # share of a roof from which it counts as seen from end to end
HALF = 0.5  # share of a roof below which nobody knows which part of it is seen, unless it is followed
REMEMBERED_S = 3.0  # the motion of a vehicle that was lost
UNSURE_PX = 1.5  # deviation from which an anchor has two explanations
SAME_PX = 3.0  # a detection so near to a followed roof is the same vehicle


@dataclass(frozen=True)
class HybridSettings:
    """How often what is done.

    search_every: frames between searches of the whole frame, paper R's n.
    watch_every: frames between looks for colours that show up.
    doubts: searches in a row that may miss a vehicle that is followed, before it is given up.
    """

    search_every: int = 30
    watch_every: int = 2
    doubts: int = 2

    def __post_init__(self) -> None:
        for name in ("search_every", "watch_every", "doubts"):
            if getattr(self, name) < 1:
                raise InputError(f"HybridSettings.{name} = {getattr(self, name)} must be 1 or more")


class HybridTracker:
    """Perceiver: at most one vehicle of each colour.

    models: what to look for; those shipped with the package if none are given.
    camera: whose frames they will be, as well as it is known; if none is given, one like that of the training.
    centrelines_m: (N, 2) points along the middle of each piece of track. A vehicle stands on one: what looks like it
        beside them is something else. Not told, it looks everywhere. Nothing is measured by them.
    """

    def __init__(
        self,
        models: ColourModels | None = None,
        camera: Camera | None = None,
        settings: HybridSettings | None = None,
        *,
        centrelines_m: Sequence[FloatArray] = (),
    ) -> None:
        models = models or ColourModels.load(SHIPPED)
        self._models = {model.label: model for model in models.models}
        self._detector = HistogramBackProjection(models, camera, _beds(models, camera, centrelines_m))
        self._model_views = ModelViews(models, camera)
        self._watch = ColourWatch(models)
        self._settings = settings or HybridSettings()
        self._identity = ColourIdentity()
        self.reset()

    def reset(self) -> None:
        """Forget all frames."""
        self._detector.reset()
        self._watch.reset()
        self._identity.reset()
        self._targets: dict[str, _Target] = {}
        self._lost: dict[str, _Target] = {}
        self._entering: set[str] = set()  # what the border cut in the frame before, not yet followed
        self._since_search = 0
        self._unfollowed = True  # something may be there that only a search can find

    def perceive(self, frame: Frame) -> Tracks:
        """Tracks in ``frame``."""
        followed = {label: target.followed(frame) for label, target in self._targets.items()}
        self._lost |= {label: self._targets[label] for label, target in followed.items() if target is None}
        self._targets = {label: target for label, target in followed.items() if target is not None}
        self._since_search += 1
        lost = len(self._targets) < len(followed)
        old = set(self._targets)
        found = self._searched(frame) if lost or self._search_due(frame) else None
        return self._identity.update(frame, self._believed(frame, _detections(frame, self._targets, found), old))

    def _believed(self, frame: Frame, objects: Detections, old: set[str]) -> Detections:
        """The objects but those at the border that are neither ``old`` nor were there a frame ago.

        Of a vehicle that enters a wall may be the first to show; it leans into the image and looks like a roof.
        """
        cut = {
            label
            for label, quad_px in zip(objects.labels, objects.quads_px, strict=True)
            if label not in old and within_border(frame.image, RoofPose.of(quad_px))[1].any()
        }
        new, self._entering = cut - self._entering, cut
        return objects.take([row for row, label in enumerate(objects.labels) if label not in new])

    def _search_due(self, frame: Frame) -> bool:
        settings = self._settings
        if self._unfollowed or self._since_search >= settings.search_every:
            return True
        return self._since_search % settings.watch_every == 0 and self._watch.stirs(frame.image, self._targets)

    def _searched(self, frame: Frame) -> Detections:
        """What the detector finds; the targets are started, confirmed or doubted by it."""
        found = self._explained(self._detector.detect(frame))
        self._watch.settle(frame.image)
        self._since_search = 0
        confirmed = {label: self._confirmed(label, frame, found, row) for row, label in enumerate(found.labels)}
        doubted = {label: self._targets[label].doubted() for label in self._targets if label not in confirmed}
        self._unfollowed = None in confirmed.values()
        self._targets = {label: target for label, target in confirmed.items() if target is not None} | {
            label: target for label, target in doubted.items() if target.doubts < self._settings.doubts
        }
        self._lost = {label: target for label, target in self._lost.items() if label not in self._targets}
        return found

    def _explained(self, found: Detections) -> Detections:
        """Anchors for which a hidden end leaves two places, at the one that the vehicle's last motion speaks for."""
        anchors_px, covs_px2 = found.anchors_px.copy(), found.anchor_covs_px2.copy()
        for row, label in enumerate(found.labels):
            known = self._lost.get(label)
            variances, directions = np.linalg.eigh(covs_px2[row])
            way_px = np.sqrt(variances[1]) * directions[:, 1]  # from the seen part's middle to the roof's, or back
            one_end = variances[0] < UNSURE_PX**2 <= variances[1]
            if known is None or not one_end or found.time_ns - known.time_ns > REMEMBERED_S * 1e9:
                continue
            ahead = float((known.expected(found.time_ns).centre_px - anchors_px[row]) @ way_px)
            anchors_px[row] += np.sign(ahead) * way_px
            single = known.model.anchor_moments_px2[SINGLE][0]
            covs_px2[row] -= (variances[1] - single) * np.outer(directions[:, 1], directions[:, 1])
        return replace(found, anchors_px=anchors_px, anchor_covs_px2=covs_px2)

    def _confirmed(self, label: str, frame: Frame, found: Detections, row: int) -> "_Target | None":
        """The target that a detection confirms or starts; None where its roof cannot be followed."""
        known, quad_px = self._targets.get(label), found.quads_px[row]
        if known is not None and found.scores[row] < WHOLE:  # what is followed is better known
            return replace(known, doubts=0)
        roof = self._roof_found(label, frame, found, row)
        if roof is None:
            return None
        if known is not None and np.abs(known.point_px - quad_px.mean(axis=0)).max() <= SAME_PX:
            shorter = (known.roof.pose.size_px - roof.pose.size_px).max() > COVERED_PX
            return replace(known, doubts=0) if shorter else known.measured(roof)
        views = dict(zip(self._models, self._model_views.of(frame.image), strict=True))
        return _Target.started(self._models[label], views[label], roof, frame)

    def _roof_found(self, label: str, frame: Frame, found: Detections, row: int) -> FollowedRoof | None:
        """The roof that was detected, if it can be followed: what hides a part of it must be known."""
        quad_px, lost = found.quads_px[row], self._lost.get(label)
        resumed = None if lost is None else lost.resumed(quad_px, frame)
        if resumed is not None:
            return resumed
        at_border = within_border(frame.image, RoofPose.of(quad_px))[1].any()
        sure = np.linalg.eigvalsh(found.anchor_covs_px2[row])[-1] < UNSURE_PX**2
        if found.scores[row] >= WHOLE or (at_border and sure):
            return start_following(frame.image, quad_px)
        return None


@dataclass(frozen=True, eq=False)
class _Target:
    """A vehicle that is followed.

    seeker: knows what the vehicle looks like. velocity_px: (2,) and turn_rad per second.
    shift_px: (2,) from the roof's middle to the anchor along the roof's axes, moments_px2: (2,) of the anchor's error
        along them. visible: share of the roof that is seen. All three hold until the roof is fitted anew.
    doubts: searches in a row that did not find it.
    """

    model: ColourModel
    view: RoofView
    roof: FollowedRoof
    seeker: CorrelationTracker
    time_ns: int
    velocity_px: FloatArray
    turn_rad: float
    shift_px: FloatArray
    moments_px2: FloatArray
    visible: float
    doubts: int = 0

    @classmethod
    def started(cls, model: ColourModel, view: RoofView, roof: FollowedRoof, frame: Frame) -> "_Target":
        pose, seeker = roof.pose, CorrelationTracker()
        seeker.start(frame.image, pose.centre_px, (float(pose.size_px[0]), float(pose.size_px[1])), pose.angle_rad)
        return cls(model, view, roof, seeker, frame.time_ns, np.zeros(2), 0.0, *_completed(roof, model, view))

    @property
    def point_px(self) -> FloatArray:
        pose = self.roof.pose
        return np.asarray(pose.centre_px + self.shift_px @ pose.axes)

    @property
    def cov_px2(self) -> FloatArray:
        axes = self.roof.pose.axes
        return np.asarray((axes.T * self.moments_px2) @ axes)

    def expected(self, time_ns: int) -> RoofPose:
        """Where the roof would be at a later time, did the vehicle keep its motion."""
        past_s = (time_ns - self.time_ns) * 1e-9
        return self.roof.pose.displaced(self.velocity_px * past_s, self.turn_rad * past_s)

    def measured(self, roof: FollowedRoof) -> "_Target":
        """The same vehicle in the same frame, measured anew."""
        shift, moments, visible = _completed(roof, self.model, self.view)
        return replace(self, roof=roof, shift_px=shift, moments_px2=moments, visible=visible, doubts=0)

    def resumed(self, quad_px: FloatArray, frame: Frame) -> FollowedRoof | None:
        """The roof found again about at a quadrangle (4, 2)."""
        found = RoofPose.of(quad_px).facing(self.roof.pose)
        pose = found.resized(self._size_px_at(found) - found.size_px)
        return resume_following(frame.image, self.roof, pose, self.expected(frame.time_ns))

    def _size_px_at(self, pose: RoofPose) -> FloatArray:
        """(2,) of the roof, which looks larger or smaller at another place of the image."""
        here, there = (self.view.at(at.centre_px).px_per_m_along(at.axes) for at in (self.roof.pose, pose))
        return np.asarray(self.roof.pose.size_px * there / here)

    def _sought(self, frame: Frame, expected: RoofPose) -> RoofPose:
        """Where the correlation filter finds the vehicle, if that is not about where it is expected."""
        found = self.seeker.find(frame.image, expected.centre_px, expected.angle_rad)
        surprise_px = found.centre_px - expected.centre_px
        surprising = found.confidence >= CONFIDENT and np.abs(surprise_px).max() > PREDICTABLE_PX
        return expected.displaced(surprise_px, 0.0) if surprising else expected

    def doubted(self) -> "_Target":
        return replace(self, doubts=self.doubts + 1)

    def followed(self, frame: Frame) -> "_Target | None":
        """The same vehicle in the next frame; None where it is lost."""
        past_s = (frame.time_ns - self.time_ns) * 1e-9
        if past_s <= 0:
            return None
        before, expected = self.roof.pose, self.expected(frame.time_ns)
        if not self.roof.whole or self.roof.age + 1 >= REFIT_EVERY:
            expected = expected.resized(self._size_px_at(expected) - expected.size_px)
        sought = self._sought(frame, expected) if self.roof.whole else expected
        roof = follow_roof(frame.image, self.roof, sought) or follow_part(frame.image, self.roof, expected)
        if roof is None:
            return None
        turn_rad = (roof.pose.angle_rad - before.angle_rad + np.pi) % (2 * np.pi) - np.pi
        velocity_px = (roof.pose.centre_px - before.centre_px) / past_s
        completed = self.shift_px, self.moments_px2, self.visible
        if roof.age == 0:
            completed = _completed(roof, self.model, self.view)
        if roof.age == 0 and roof.whole:
            self.seeker.learn(frame.image, roof.pose.centre_px, roof.pose.angle_rad)
        return _Target(
            self.model,
            self.view,
            roof,
            self.seeker,
            frame.time_ns,
            velocity_px,
            turn_rad / past_s,
            *completed,
            self.doubts,
        )


def _beds(models: ColourModels, camera: Camera | None, centrelines_m: Sequence[FloatArray]) -> TrackBeds | None:
    if not centrelines_m:
        return None
    if camera is None:
        raise InputError("HybridTracker is told where the track lies, but not by which camera it is seen")
    return TrackBeds(models, camera, centrelines_m)


def _completed(roof: FollowedRoof, model: ColourModel, view: RoofView) -> tuple[FloatArray, FloatArray, float]:
    """Shift, moments and visible share of a target's anchor."""
    axes, middle = roof.pose.axes, roof.pose.centre_px
    anchor = complete_roof(roof.roof, model, view.at(middle))
    moments = ((axes @ anchor.cov_px2) * axes).sum(axis=1)
    return axes @ (anchor.point_px - middle), moments, anchor.visible * roof.shown


def _detections(frame: Frame, targets: dict[str, _Target], found: Detections | None) -> Detections:
    """The targets, and what was found beside them."""
    seen = tuple(targets.values())
    quads = np.array([target.roof.roof.quad_px for target in seen]).reshape(-1, 4, 2)
    followed = Detections(
        frame.camera,
        frame.index,
        frame.time_ns,
        tuple(targets),
        np.array([target.visible for target in seen]),
        np.concatenate([quads.min(axis=1), quads.max(axis=1)], axis=1),
        quads,
        np.array([target.point_px for target in seen]).reshape(-1, 2),
        np.array([target.model.roof_height_m for target in seen]),
        np.array([target.cov_px2 for target in seen]).reshape(-1, 2, 2),
    )
    if found is None:
        return followed
    beside = [row for row, label in enumerate(found.labels) if label not in targets and found.scores[row] >= HALF]
    return followed.joined(found.take(beside))

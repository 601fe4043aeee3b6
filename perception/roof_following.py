"""A roof that was measured a frame ago, measured again: one resampling and one product with a prepared matrix.

The model of the profiles, its priors and the test that decides on walls are those of ``edge_profile``. Every few
frames the model is fitted anew; there its Jacobian tells, for all frames until the next fit, how a small departure of
the profiles from the model splits into moved edges, a turn, and everything that is no motion (a wall that grows,
another background): Gauss-Newton with a frozen Jacobian, the chord method. A departure beyond the linear range is
looked at again from where the first look said that the roof is.

Where something hides an end, what shows is measured by itself and the roof completed to the size that it had.
"""

from dataclasses import dataclass, replace

import numpy as np

from contracts import BoolArray, FloatArray, ImageArray
from perception.profile_fit import LinearModel, ProfileFit, fit_profiles
from perception.roof import Roof
from perception.roof_cover import COVERED_PX, SHOWN_SLACK_PX, covered_sides, same_colour, shown_part, within_border
from perception.roof_window import BACK, FORTH, OPPOSITE, RoofPose, WindowPlan

REFIT_EVERY = 8  # frames
LINEAR_PX, LINEAR_RAD = 0.3, 0.015  # of departure, that one look bears
LOOKS = 3
FARTHEST_PX = 6.0  # from where it was looked for, it is another edge that was found
ODD_COST = 120.0  # of a side's profile: something stands before it
DOUBTFUL_COST = 8.0  # beyond this the linear model is not trusted with a side
SHRINKING_PX = 0.02  # by which a roof may seem shorter from fit to fit, lest a cover that comes slowly be overlooked
GROWING_PX = 2.0  # by which a roof does not become longer
CLEAR_PX = 0.4  # a roof that seems shorter by no more shows from end to end
BEYOND_PX = 1.0, 12.0  # where a roof is expected it may show; if its end does not show there, its motion was another
LEAST_CONTRAST = 0.12  # share of a roof's brightness, by which what lies beyond its end differs from it
LEAST_SHOWN = 0.35  # share of each side of a roof that must show
_NONE = np.zeros(4, np.bool_)


@dataclass(frozen=True, eq=False)
class FollowedRoof:
    """A measured roof and what the next frames are compared with.

    roof: as ``measure_roof`` gives it, a hidden end where it must be. pose: the same as a rectangle.
    part: what shows of it. hidden: (4,) the sides where that ends for something covers the roof, or the border cuts it.
    clear: where it was when it last showed from end to end for sure. age: frames since the model was fitted.
    """

    roof: Roof
    pose: RoofPose
    part: RoofPose
    hidden: BoolArray
    clear: RoofPose
    age: int
    _reference: "_Reference"

    @property
    def whole(self) -> bool:
        """Whether all of it shows."""
        return not self.hidden.any()

    @property
    def before(self) -> RoofPose:
        """What surely showed of it last."""
        return self.clear if self.whole else self.part

    @property
    def shown(self) -> float:
        """Share of its area that shows."""
        return float(np.prod(self.part.size_px / self.pose.size_px))

    @property
    def colours(self) -> FloatArray:
        """(4, 3) BGR at its sides; at those that are hidden, what the others have."""
        colours = self._reference.fit.roof
        return np.where(self.hidden[:, None], colours[~self.hidden].mean(axis=0), colours)


@dataclass(frozen=True, eq=False)
class _Reference:
    """The fitted model, and how it is looked at."""

    plan: WindowPlan
    fit: ProfileFit
    linear: LinearModel


def start_following(image: ImageArray, quad_px: FloatArray) -> FollowedRoof | None:
    """From a roof (4, 2) that a detector measured, first side long; None where it cannot be followed.

    One that the image's border cuts keeps the size of the quadrangle, which reaches beyond the border then.
    """
    pose = RoofPose.of(np.asarray(quad_px, np.float64))
    inner, hidden = within_border(image, pose)
    fitted = _fitted_part(image, inner, pose.size_px, hidden, None)
    return None if fitted is None else fitted.followed(fitted.pose.completed(pose.size_px, hidden), hidden)


def resume_following(image: ImageArray, last: FollowedRoof, pose: RoofPose, expected: RoofPose) -> FollowedRoof | None:
    """A roof that had been lost and is found again; something may still cover it.

    pose: about where it was found, of the size that it has there. expected: where its last motion would have taken it.
    """
    return _part_of(image, _Sought(pose, last, expected if last.whole else last.part))


def follow_roof(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> FollowedRoof | None:
    """The roof in a later frame, given about where it is; None where all of it cannot be told.

    image: (H, W, 3) BGR. last: what is known. pose: where the roof is expected, to a few pixels; of ``last``'s size.
    """
    easy = last.roof.sides_measured.all() and last.age + 1 < REFIT_EVERY
    looked = _looked(image, last, pose) if easy else None
    if looked is not None and looked.trusted:
        return FollowedRoof(
            Roof(looked.pose.corners_px, last.roof.sides_measured, last.roof.walls_px),
            looked.pose,
            looked.pose,
            last.hidden,
            looked.pose if looked.clear else last.clear,
            last.age + 1,
            last._reference,
        )
    fitted = _fitted(image, pose if looked is None else looked.pose, last._reference.fit.walls_px)
    if fitted is None or not fitted.is_part_of(pose, last.colours):
        return None
    missing_px = pose.size_px - fitted.pose.size_px
    hidden = covered_sides(fitted.pose, missing_px, last.before, last.hidden, _NONE)
    if hidden is None:
        return None
    hidden = hidden | (last.hidden & ~fitted.seen)
    size_px = np.maximum(fitted.pose.size_px, pose.size_px - SHRINKING_PX) if last.whole else fitted.pose.size_px
    completed = fitted.pose.completed(pose.size_px, hidden)
    roof = fitted.followed(completed.resized(np.maximum(size_px - completed.size_px, 0.0)), hidden)
    return replace(roof, clear=last.clear) if missing_px.max() > CLEAR_PX or not fitted.seen.all() else roof


def follow_part(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> FollowedRoof | None:
    """What shows of the roof in a later frame, where an end of it is hidden; None where too little of it shows.

    pose: where the roof is expected by its motion; of ``last``'s size.
    """
    return _part_of(image, _Sought(pose, last, last.before))


@dataclass(frozen=True, eq=False)
class _Sought:
    """A roof that is looked for; before: what showed of it when it was seen last, or would show had it moved on."""

    pose: RoofPose
    last: FollowedRoof
    before: RoofPose

    def covered(self, part: RoofPose, missing_px: FloatArray, known: BoolArray) -> BoolArray | None:
        """(4,) the sides that are hidden if ``part`` shows, beside those of which it is ``known``."""
        return covered_sides(part, missing_px, self.before, self.last.hidden, known)


def _part_of(image: ImageArray, sought: _Sought) -> FollowedRoof | None:
    """What shows of the roof: all within the border; if that is not it, what has its colour where it is expected."""
    pose, last = sought.pose, sought.last
    inner, at_border = within_border(image, pose)
    found = _completed(image, sought, inner, at_border) if at_border.any() else None
    for beyond_px in BEYOND_PX:
        if found is not None or (inner.size_px <= 0).any():
            break
        part = shown_part(image, inner, last.colours, np.where(at_border, 0.0, beyond_px))
        if part is not None:
            missing_px = pose.size_px - part.size_px
            hidden = sought.covered(part, np.where(missing_px > SHOWN_SLACK_PX, missing_px, 0.0), at_border)
            found = None if hidden is None else _completed(image, sought, part, hidden)
    return found


def _completed(image: ImageArray, sought: _Sought, part: RoofPose, hidden: BoolArray) -> FollowedRoof | None:
    """The roof, of which ``part`` shows up to its ``hidden`` sides (4,), or even less."""
    size_px, last = sought.pose.size_px, sought.last
    fitted = _fitted_part(image, part, size_px, hidden, last._reference.fit.walls_px)
    if fitted is None or not fitted.is_part_of(sought.pose, last.colours):
        return None
    covered = sought.covered(fitted.pose, size_px - fitted.pose.size_px, hidden)
    if covered is None:
        return None
    covered = covered | (last.hidden & ~fitted.seen & ~covered[OPPOSITE])
    return fitted.followed(fitted.pose.completed(size_px, covered), covered)


def _fitted_part(
    image: ImageArray, part: RoofPose, size_px: FloatArray, hidden: BoolArray, walls_px: FloatArray | None
) -> "_Fitted | None":
    """What shows of a roof of ``size_px`` (2,); None where that is too little."""
    if (part.size_px < LEAST_SHOWN * size_px).any() or (hidden & hidden[OPPOSITE]).any():
        return None
    return _fitted(image, part, walls_px, hidden)


@dataclass(frozen=True, eq=False)
class _Look:
    """What the linear model says; not to be trusted where the profiles are too far from it."""

    pose: RoofPose
    trusted: bool
    clear: bool


def _looked(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> _Look | None:
    """The roof by the linear model, looked at again until it lies where it was looked for."""
    reference, start = last._reference, pose
    for _ in range(LOOKS):
        if not pose.inside(image):
            return None
        edges_px, turn_rad, costs = reference.linear.read(reference.plan.profiles(image, pose))
        offset, growth = _motion(edges_px, ~_NONE)
        longer_px = growth + reference.plan.size_px - pose.size_px
        if longer_px.min() < -COVERED_PX:  # only from where the roof was expected can be told which end it is
            return None
        pose = pose.moved(offset, turn_rad)
        if np.abs(pose.centre_px - start.centre_px).max() > FARTHEST_PX:
            return None
        if np.abs(offset).max() <= LINEAR_PX and abs(turn_rad) <= LINEAR_RAD:
            return _Look(pose, trusted=bool(costs.max() <= DOUBTFUL_COST), clear=bool(longer_px.min() >= -CLEAR_PX))
    return None


@dataclass(frozen=True, eq=False)
class _Fitted:
    """The whole model fitted to the sides of a rectangle; (4,) which of them are ``seen``, and which are ``hidden``."""

    pose: RoofPose
    plan: WindowPlan
    fit: ProfileFit
    seen: BoolArray
    hidden: BoolArray

    def is_part_of(self, pose: RoofPose, colours: FloatArray) -> bool:
        """Whether it is no larger than a roof, which has its colours (4, 3) within all sides that are not hidden."""
        larger_px = self.pose.size_px - pose.size_px
        return bool(larger_px.max() <= GROWING_PX and same_colour(self.fit.roof, colours)[~self.hidden].all())

    def followed(self, pose: RoofPose, hidden: BoolArray) -> FollowedRoof:
        """As the roof of ``pose``, what was measured being the part of it that shows up to its ``hidden`` sides."""
        seen = self.seen & ~hidden
        roof = Roof(pose.corners_px, seen, np.where(self.fit.walled & seen, self.fit.walls_px, 0.0))
        return FollowedRoof(
            roof, pose, self.pose, hidden, pose, 0, _Reference(self.plan, self.fit, LinearModel.of(self.fit, self.plan))
        )


def _fitted(
    image: ImageArray, pose: RoofPose, walls_px: FloatArray | None, hidden: BoolArray = _NONE
) -> _Fitted | None:
    """The rectangle near ``pose``; sides that are ``hidden`` (4,) move along with the opposite ones."""
    for _ in range(LOOKS):
        if not pose.inside(image, hidden):
            return None
        plan = WindowPlan.of(pose.size_px)
        fit = fit_profiles(plan.profiles(image, pose).astype(np.float64), plan, walls_px, hidden)
        seen: BoolArray = (fit.costs <= ODD_COST) & ~hidden
        if not ((seen | seen[OPPOSITE]) & (_ends(fit) | hidden)).all():
            return None
        offset, growth = _motion(fit.edges_px, seen)
        pose = pose.moved(offset, fit.turn_rad).resized(growth)
        if np.abs(offset).max() <= LINEAR_PX and abs(fit.turn_rad) <= LINEAR_RAD:
            break
    return _Fitted(pose, WindowPlan.of(pose.size_px), fit, seen, hidden)


def _ends(fit: ProfileFit) -> BoolArray:
    """(4,) at which sides something else than the roof begins."""
    contrast = np.linalg.norm(fit.roof - fit.background, axis=1)
    return np.asarray(contrast >= LEAST_CONTRAST * np.linalg.norm(fit.roof, axis=1))


def _motion(edges_px: FloatArray, seen: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Offset and growth (2,) along the long and the short axis; from one end alone where the other is not seen."""
    forth, back = edges_px[FORTH], edges_px[BACK]
    both = seen[FORTH] & seen[BACK]
    offset = np.where(both, (forth - back) / 2, np.where(seen[FORTH], forth, -back))
    return offset, np.where(both, forth + back, 0.0)

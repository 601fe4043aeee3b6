"""A roof that was measured a frame ago, measured again: one resampling and one product with a prepared matrix.

The model of the profiles, its priors and the test that decides on walls are those of ``edge_profile``. Every few
frames the model is fitted anew; there its Jacobian tells, for all frames until the next fit, how a small departure of
the profiles from the model splits into moved edges, a turn, and everything that is no motion (a wall that grows,
another background): Gauss-Newton with a frozen Jacobian, the chord method. A departure beyond the linear range is
looked at again from where the first look said that the roof is.
"""

from dataclasses import dataclass

import numpy as np

from contracts import BoolArray, FloatArray, ImageArray
from perception.profile_fit import LinearModel, ProfileFit, fit_profiles
from perception.roof import Roof
from perception.roof_window import RoofPose, WindowPlan

REFIT_EVERY = 8  # frames
LINEAR_PX, LINEAR_RAD = 0.5, 0.015  # of departure, that one look bears
LOOKS = 3
FARTHEST_PX = 6.0  # from where it was looked for, it is another edge that was found
ODD_COST = 120.0  # of a side's profile: something stands before it
DOUBTFUL_COST = 8.0  # beyond this the linear model is not trusted with a side
SAME_COLOUR = 0.15  # by which the direction of a roof's colour may change from fit to fit
COVERED_PX = 1.0  # by which a roof does not become shorter from one frame to the next
_OPPOSITE = np.array([2, 3, 0, 1])
_FORTH, _BACK = np.array([1, 2]), np.array([3, 0])  # the sides at the ends of the long and the short axis


@dataclass(frozen=True, eq=False)
class FollowedRoof:
    """A measured roof and what the next frames are compared with.

    roof: as ``measure_roof`` gives it. pose: the same as a rectangle. age: frames since the model was fitted.
    """

    roof: Roof
    pose: RoofPose
    age: int
    _reference: "_Reference"


@dataclass(frozen=True, eq=False)
class _Reference:
    """The fitted model, and how it is looked at."""

    plan: WindowPlan
    fit: ProfileFit
    linear: LinearModel


def start_following(image: ImageArray, quad_px: FloatArray) -> FollowedRoof | None:
    """From a roof (4, 2) that a detector measured, first side long; None where it cannot be followed, as when cut."""
    return _fitted(image, RoofPose.of(np.asarray(quad_px, np.float64)), None, followed=False)


def resume_following(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> FollowedRoof | None:
    """A roof that had been lost, at a ``pose`` of the size that it had; something may still cover an end of it."""
    return _refitted(image, pose, last._reference.fit)


def follow_roof(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> FollowedRoof | None:
    """The roof in a later frame, given about where it is; None where it cannot be told and a full search must.

    image: (H, W, 3) BGR. last: what is known. pose: where the roof is expected, to a few pixels; of ``last``'s size.
    """
    reference = last._reference
    if last.age + 1 >= REFIT_EVERY:
        return _refitted(image, pose, reference.fit)
    looked = _looked(image, last, pose)
    if looked is None or np.abs(looked.pose.centre_px - pose.centre_px).max() > FARTHEST_PX:
        return None
    if not looked.trusted:
        return _refitted(image, looked.pose, reference.fit)
    roof = Roof(looked.pose.corners_px, last.roof.sides_measured, last.roof.walls_px)
    return FollowedRoof(roof, looked.pose, last.age + 1, reference)


@dataclass(frozen=True, eq=False)
class _Look:
    """What the linear model says; not to be trusted where the profiles are too far from it."""

    pose: RoofPose
    trusted: bool


def _looked(image: ImageArray, last: FollowedRoof, pose: RoofPose) -> _Look | None:
    """The roof by the linear model, looked at again until it lies where it was looked for."""
    reference, seen = last._reference, last.roof.sides_measured
    for _ in range(LOOKS):
        if not pose.inside(image):
            return None
        edges_px, turn_rad, costs = reference.linear.read(reference.plan.profiles(image, pose))
        offset, growth = _motion(edges_px, seen)
        if growth.min() < -COVERED_PX:  # only from where the roof was expected can be told which end it is
            return _Look(pose, trusted=False)
        pose = pose.moved(offset, turn_rad)
        if np.abs(offset).max() <= LINEAR_PX and abs(turn_rad) <= LINEAR_RAD:
            return _Look(pose, trusted=bool(costs[seen].max() <= DOUBTFUL_COST))
    return None


def _refitted(image: ImageArray, pose: RoofPose, last: ProfileFit) -> FollowedRoof | None:
    """The roof by a fit of the whole model, started from the ``last`` one; it must still have the same colour."""
    roof = _fitted(image, pose, last.walls_px, followed=True)
    if roof is None:
        return None
    known, now = (colour.mean(axis=0) for colour in (last.roof, roof._reference.fit.roof))
    departure = np.linalg.norm(now / max(np.linalg.norm(now), 1.0) - known / max(np.linalg.norm(known), 1.0))
    return roof if departure <= SAME_COLOUR else None


def _fitted(image: ImageArray, pose: RoofPose, walls_px: FloatArray | None, *, followed: bool) -> FollowedRoof | None:
    """The roof near ``pose``. One that is followed keeps its size: if it seems shorter, something covers an end."""
    for _ in range(LOOKS):
        if not pose.inside(image):
            return None
        plan = WindowPlan.of(pose.size_px)
        profiles = plan.profiles(image, pose).astype(np.float64)
        fit = fit_profiles(profiles, plan, walls_px)
        seen: BoolArray = fit.costs <= ODD_COST
        if followed:
            seen = seen & ~_covered(fit.edges_px)
        if not (seen | seen[_OPPOSITE]).all():
            return None
        offset, growth = _motion(fit.edges_px, seen)
        pose = pose.moved(offset, fit.turn_rad).resized(growth)
        if np.abs(offset).max() <= LINEAR_PX and abs(fit.turn_rad) <= LINEAR_RAD:
            break
    plan = WindowPlan.of(pose.size_px)
    roof = Roof(pose.corners_px, seen, np.where(fit.walled, fit.walls_px, 0.0))
    return FollowedRoof(roof, pose, 0, _Reference(plan, fit, LinearModel.of(fit, plan)))


def _motion(edges_px: FloatArray, seen: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Offset and growth (2,) along the long and the short axis; from one end alone where the other is not seen."""
    forth, back = edges_px[_FORTH], edges_px[_BACK]
    both = seen[_FORTH] & seen[_BACK]
    offset = np.where(both, (forth - back) / 2, np.where(seen[_FORTH], forth, -back))
    return offset, np.where(both, forth + back, 0.0)


def _covered(edges_px: FloatArray) -> BoolArray:
    """(4,) the sides that cannot be the roof's end, for the roof would be shorter: those farther off."""
    shorter = edges_px + edges_px[_OPPOSITE] < -COVERED_PX
    return np.asarray(shorter & (np.abs(edges_px) > np.abs(edges_px[_OPPOSITE])))

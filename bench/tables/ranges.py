"""What paper T's protocol hides: the whole error in the plane, by range, against the truth."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from bench.scores import Score
from bench.scoring.ground import ELLIPSE_90
from bench.tables.part import Grid, Part, number
from bench.tables.road_film import CALIBRATORS, FilmedCamera
from contracts import BoolArray, FloatArray
from georef.calibrated import CalibratedCamera
from georef.hd_map import LaneUse
from georef.locate import locate_pixels
from sim.projection import project

RANGES_M = ((0.0, 20.0), (20.0, 30.0), (30.0, 40.0), (40.0, 50.0), (50.0, 60.0))
WITHIN_M = 40.0
_STEP_M = 1.0


@dataclass(frozen=True, eq=False)
class PlaceErrors:
    """Of N places before one camera, or before many. NaN, and no True, where nothing was located.

    ranges_m: (N,) from the pole's foot. errors_m: (N,) in the plane. inside: (N,) within their own 90 % ellipse.
    """

    ranges_m: FloatArray
    errors_m: FloatArray
    inside: BoolArray

    @classmethod
    def of_all(cls, some: Sequence["PlaceErrors"]) -> "PlaceErrors":
        """Of many cameras together."""
        return cls(
            np.concatenate([np.empty(0), *(one.ranges_m for one in some)]),
            np.concatenate([np.empty(0), *(one.errors_m for one in some)]),
            np.concatenate([np.empty(0, np.bool_), *(one.inside for one in some)]),
        )


ByCalibrator = dict[str, list[PlaceErrors]]
"""One entry for each camera that was calibrated."""


def errors_by_place(filmed: FilmedCamera, calibrator: str, *, flat: bool = False) -> PlaceErrors:
    """Errors at places of the road in the image.

    The image of each place is exact: OpenCV's, through the true camera. flat: the ground is taken to be
    as high everywhere as below the camera, which only a camera, no homography, can do.
    """
    found = filmed.found[calibrator]
    if isinstance(found, str):
        return PlaceErrors.of_all(())
    places = road_places(filmed)
    pixels, _ = project(filmed.true, places)
    if flat and filmed.ground is not None and isinstance(found, CalibratedCamera):
        below = filmed.ground.heights_m(found.camera.pose.position_m[None, :2])
        located = locate_pixels(found, pixels, heights_m=float(below[0]))
    else:
        located = locate_pixels(found, pixels, ground=filmed.ground)
    ranges = np.linalg.norm(places[:, :2] - filmed.true.pose.position_m[:2], axis=1)
    errors = located.positions_m - places[:, :2]
    inside = np.zeros(len(errors), np.bool_)
    ok = located.valid
    towards = np.linalg.solve(located.covs_m2[ok], errors[ok][:, :, None])[:, :, 0]
    inside[ok] = (errors[ok] * towards).sum(axis=1) <= ELLIPSE_90
    return PlaceErrors(ranges, np.linalg.norm(errors, axis=1), inside)


def road_places(filmed: FilmedCamera) -> FloatArray:
    """Places (N, 3) a metre apart along the middle of every lane that the true camera sees."""
    lanes = [lane for lane in filmed.true_map.centrelines if lane.use is not LaneUse.PEDESTRIANS]
    places = np.concatenate([lane.places_m(np.arange(0.0, lane.length_m, _STEP_M)) for lane in lanes])
    pixels, valid = project(filmed.true, places)
    size = filmed.true.intrinsics
    inside = (pixels > 0).all(axis=1) & (pixels < (size.width_px - 1, size.height_px - 1)).all(axis=1)
    near = shapely.dwithin(
        shapely.points(places[:, :2]), shapely.Point(filmed.true.pose.position_m[:2]), RANGES_M[-1][1]
    )
    return np.asarray(places[valid & inside & near])


def ranges(everything: ByCalibrator, refused: dict[str, int]) -> Part:
    """One row per calibrator: root mean square by range, and the mean within 40 m. refused: cameras, by calibrator."""
    says = (
        "Places a metre apart on the lanes before the true camera, imaged exactly, and located: root mean square of "
        "the whole distance from the truth, metres, by range from the pole's foot. Held to the lane's centreline "
        "only, as the paper does, the part along the road does not count."
    )
    return _part("ranges", "The whole error by range", says, everything, refused)


def flat_ground(everything: ByCalibrator, refused: dict[str, int]) -> Part:
    """The same where the road climbs and is taken to be level."""
    says = (
        "The same places of the roads that climb, as if the ground were everywhere as high as below the camera, "
        "instead of on the heights of the map."
    )
    return _part("flat_ground", "What flat ground costs on a slope", says, everything, refused)


def _part(key: str, title: str, says: str, everything: ByCalibrator, refused: dict[str, int]) -> Part:
    rows, scores = [], []
    for name, seen in everything.items():
        all_places = PlaceErrors.of_all(seen)
        away, errors = all_places.ranges_m, all_places.errors_m
        bins = [errors[(away >= low) & (away < high) & np.isfinite(errors)] for low, high in RANGES_M]
        near = errors[(away < WITHIN_M) & np.isfinite(errors)]
        mean = float(near.mean()) if len(near) else float("nan")
        figures = [float(np.sqrt((some**2).mean())) if len(some) else float("nan") for some in bins]
        located = np.isfinite(errors)
        inside = float(all_places.inside[located].mean()) if located.any() else float("nan")
        cameras = f"{len(seen)}, {refused[name]} refused" if refused[name] else str(len(seen))
        by_range = (number(value, ".3f") for value in figures)
        rows.append((CALIBRATORS[name], cameras, *by_range, number(mean, ".3f"), number(inside, ".1%")))
        scores.append(Score.of(f"{key}.{name}.coverage_90", inside, "1", int(located.sum())))
        scores.append(Score.of(f"{key}.{name}.mean_within_40_m", mean, "m", len(near)))
        scores += [
            Score.of(f"{key}.{name}.rms_{low:.0f}_{high:.0f}_m", value, "m", len(some))
            for (low, high), value, some in zip(RANGES_M, figures, bins, strict=True)
        ]
    head = (
        "camera calibrated from",
        "cameras",
        *(f"{low:.0f} – {high:.0f} m" for low, high in RANGES_M),
        "mean to 40 m",
        "inside own 90 % ellipse",
    )
    return Part(key, title, says, (Grid(head, tuple(rows)),), scores=tuple(scores))

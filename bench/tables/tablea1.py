"""Table A1 of paper T: points on the lanes' paths in the image, projected, and held to the map's centrelines."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.scores import Score
from bench.tables.part import Grid, Part, number
from bench.tables.road_film import CALIBRATORS, FilmedCamera
from contracts import FloatArray
from georef.hd_map import LaneUse
from georef.lanes import LaneIndex
from georef.locate import locate_pixels
from perception.lane_paths import LanePath, lane_path
from perception.road_paint import brightness

POINTS, FARTHEST_M = 26, 60.0
PAPER = {"mean": 0.15, "rms": 0.19, "largest": 0.48, "smallest": 0.02}
_NEAR_AXIS_DEG = 20.0


@dataclass(frozen=True, eq=False)
class Projected:
    """The points of one lane as one calibrator projects them.

    pixels, positions_m: (26, 2). wgs84_deg: (26, 2) latitude, longitude. errors_m: (26,) distance from the foot.
    """

    camera: str
    lane: str
    pixels: FloatArray
    positions_m: FloatArray
    wgs84_deg: FloatArray
    errors_m: FloatArray


def lane_paths(filmed: FilmedCamera) -> list[LanePath]:
    """Lanes of cars that run within 20 degrees of the viewing direction and are found in the image.

    Where to look is told by the camera as found in its own frames: the same pixels are projected by every calibrator.
    """
    guide = filmed.found["frames"] if not isinstance(filmed.found["frames"], str) else filmed.found["whole"]
    if isinstance(guide, str) or not hasattr(guide, "camera"):
        return []
    light, camera = brightness(filmed.picture), guide.camera
    ahead = camera.pose.world_from_camera[:2, 2]
    paths = []
    for lane in filmed.owners_map.centrelines:
        if lane.use is LaneUse.CARS and not lane.inner and _is_along(lane.points_m, camera.pose.position_m, ahead):
            path = lane_path(light, camera, lane)
            if path is not None:
                paths.append(path)
    return paths


def project_lanes(filmed: FilmedCamera, paths: Sequence[LanePath], calibrator: str, seed: int) -> list[Projected]:
    """26 points of each path, uniform in range, by one calibrator; none where it refused."""
    found = filmed.found[calibrator]
    if isinstance(found, str):
        return []
    index = LaneIndex.of(filmed.owners_map)
    row_of = {lane.id: row for row, lane in enumerate(index.centrelines)}
    eye = filmed.true.pose.position_m[:2]
    projected = []
    for path in paths:
        located = locate_pixels(found, path.pixels, ground=filmed.ground)
        ranges = np.linalg.norm(located.positions_m - eye, axis=1)
        usable = located.valid & (ranges < FARTHEST_M)
        if usable.sum() < 2:
            continue
        pixels = _uniform(path.pixels[usable], ranges[usable], np.random.default_rng(seed))
        places = locate_pixels(found, pixels, ground=filmed.ground).positions_m
        feet = index.places_on(np.full(POINTS, row_of[path.lane]), places)
        wgs84 = filmed.owners_map.geo.to_wgs84(places)
        projected.append(Projected(filmed.true.name, path.lane, pixels, places, wgs84, feet.distances_m))
    return projected


def table_a1(everything: dict[str, list[Projected]]) -> Part:
    """One row per calibrator over all lanes, beside the paper's; then the 26 points of the first lane in full."""
    rows = [_row(CALIBRATORS[name], projected) for name, projected in everything.items()]
    rows.append(("paper T, 25 picks", "26", *(number(PAPER[key], ".2f") for key in PAPER), number(None)))
    head = ("camera calibrated from", "points", "mean, m", "RMS, m", "largest, m", "smallest, m", "lanes")
    grids = [Grid(head, tuple(rows))]
    first = next((projected[0] for projected in everything.values() if projected), None)
    if first is not None:
        grids.append(_points(first))
    says = (
        "Lanes are found in the image by the strokes that bound them; 26 points of the path between, uniform in "
        "range to 60 m, are projected to the map and held to the foot of the perpendicular on the lane's centreline. "
        "The paper prints errors that do not follow from its printed coordinates: in its row 1, 0.27 m beside 0.08 m "
        "between the coordinates."
    )
    scores = tuple(score for name, projected in everything.items() for score in _scores(name, projected))
    return Part("tableA1", "Table A1: points on lanes", says, tuple(grids), scores=scores)


def _errors(projected: Sequence[Projected]) -> FloatArray:
    return np.concatenate([np.empty(0), *(one.errors_m for one in projected)])


def _figures(projected: Sequence[Projected]) -> dict[str, float]:
    errors = _errors(projected)
    if not len(errors):
        return dict.fromkeys(PAPER, float("nan"))
    rms = float(np.sqrt((errors**2).mean()))
    return {"mean": float(errors.mean()), "rms": rms, "largest": float(errors.max()), "smallest": float(errors.min())}


def _row(name: str, projected: Sequence[Projected]) -> tuple[str, ...]:
    figures = _figures(projected)
    return (
        name,
        str(len(_errors(projected))),
        *(number(value, ".3f") for value in figures.values()),
        str(len(projected)),
    )


def _scores(name: str, projected: Sequence[Projected]) -> list[Score]:
    n = len(_errors(projected))
    return [Score.of(f"tableA1.{name}.{key}_m", value, "m", n) for key, value in _figures(projected).items()]


def _points(projected: Projected) -> Grid:
    rows = tuple(
        (str(k + 1), f"{latitude:.7f}", f"{longitude:.7f}", number(error, ".3f"))
        for k, ((latitude, longitude), error) in enumerate(
            zip(projected.wgs84_deg.tolist(), projected.errors_m.tolist(), strict=True)
        )
    )
    return Grid((f"{projected.camera}, lane {projected.lane}", "latitude", "longitude", "error, m"), rows)


def _uniform(pixels: FloatArray, ranges_m: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Points (26, 2) of a path whose ranges are drawn evenly between its nearest and its farthest."""
    order = np.argsort(ranges_m)
    wanted = np.sort(rng.uniform(ranges_m.min(), ranges_m.max(), POINTS))
    return np.column_stack([np.interp(wanted, ranges_m[order], pixels[order, axis]) for axis in range(2)])


def _is_along(points_m: FloatArray, eye_m: FloatArray, ahead: FloatArray) -> bool:
    """Whether a lane runs within 20 degrees of the viewing direction, either way, where it is nearest to 30 m away."""
    away = np.abs(np.linalg.norm(points_m[:, :2] - eye_m[:2], axis=1) - FARTHEST_M / 2)
    side = min(int(away.argmin()), len(points_m) - 2)
    course = points_m[side + 1, :2] - points_m[side, :2]
    cosine = abs(float(course @ ahead)) / float(np.linalg.norm(course) * np.linalg.norm(ahead))
    return bool(cosine > np.cos(np.radians(_NEAR_AXIS_DEG)))

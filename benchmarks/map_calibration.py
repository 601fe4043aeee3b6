"""How well do picked map points calibrate a pole camera? By the traffic paper's protocol and against the bound.

    python -m benchmarks.map_calibration [--cameras 200 --json]

Each camera is drawn: on a pole of 6 to 10 m, 1920 x 1080 px, 40 to 75 degrees across, looking to the road 20 to 40 m
away. *Whole* cameras have a lens (k1 to -0.3), a principal point up to 30 px off the centre and up to 1.5 degrees of
roll; *plain* ones have none of these, as the traffic paper assumes. The map offers ends and corners of markings, and
some signs and lamps. The owner picks eight spread over the image, calibrates, and picks 17 more as ``georef.next_pick``
advises: 25 in all. Each has 1 px of noise per axis; 10 % are wrong: half are another point of the map, half lie 5 to
60 px off. Images are OpenCV's. What is measured:

- **protocol**: 26 points of each lane's centreline, uniform in range from the nearest seen to 60 m, located and held to
  the foot of the perpendicular on the true centreline: lanes within 20 degrees of the viewing direction, and others.
- **error by range**: the distance from the true place, RMS over cameras, over the RMS of the Cramer-Rao bound, which is
  computed at the true camera from the right picks and the stated beliefs; the image of the place itself is exact.
- **coverage**: share of true places inside their own 90 % ellipse.
"""

import argparse
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context

import cv2
import numpy as np

from bench.scores import Score, to_json
from contracts import BoolArray, CalibrationError, Camera, FloatArray, IntArray, Intrinsics, Pose
from georef.calibrated import CalibratedCamera
from georef.camera_models import Beliefs, CameraModel, CameraState, FullState, PanTiltState
from georef.ground_homography import GroundHomography, HomographyModel, HomographyState
from georef.homography import image_from_plane
from georef.locate import locate_pixels
from georef.map_calibration import calibrate_camera, calibrate_homography, calibrate_pan_tilt
from georef.next_pick import choose
from georef.picks import LinePicks, PointPicks

SIZE = (1920, 1080)
FARTHEST_M, LANE_M = 60.0, 3.5
PICKS, FIRST_PICKS, WRONG_SHARE = 25, 8, 0.1
PROTOCOL_POINTS, NEAR_AXIS_DEG = 26, 20.0
RANGES_M = ((0.0, 20.0), (20.0, 30.0), (30.0, 40.0), (40.0, 50.0), (50.0, 60.0))
CHI2_90 = 4.605170185988092
MODELS = ("full", "pan_tilt", "homography")
Finding = CalibratedCamera | GroundHomography


@dataclass(frozen=True, eq=False)
class Placed:
    """Places found by one model: error (N, 2), what the model states (N, 2, 2) and its bound (N, 2, 2), metres."""

    errors_m: FloatArray
    stated_m2: FloatArray
    bound_m2: FloatArray

    @property
    def inside(self) -> float:
        """Share of true places inside their own 90 % ellipse."""
        squares = np.einsum("ni,nij,nj->n", self.errors_m, np.linalg.inv(self.stated_m2), self.errors_m)
        return float(np.mean(squares <= CHI2_90))

    def across(self, normal: FloatArray) -> "Across":
        """Along ``normal`` alone, as the traffic paper measures it."""
        return Across(np.abs(self.errors_m @ normal), np.sqrt(np.einsum("i,nij,j->n", normal, self.bound_m2, normal)))


@dataclass(frozen=True, eq=False)
class Across:
    """Distances (N,) from a lane's centreline, and the standard deviation (N,) that is their bound, metres."""

    errors_m: FloatArray
    bound_m: FloatArray


@dataclass(frozen=True, eq=False)
class Trial:
    """One camera: places in its image by model, and for each lane (near_axis, off_axis) by model; who refused."""

    ranges_m: FloatArray
    placed: dict[str, Placed]
    lanes: dict[str, dict[str, Across]]
    refused: tuple[str, ...]


def draw_camera(rng: np.random.Generator, *, whole: bool) -> Camera:
    """A camera at the origin's pole; the road runs about east."""
    height_m, aim_m = rng.uniform(6.0, 10.0), rng.uniform(20.0, 40.0)
    focal_px = SIZE[0] / 2 / np.tan(np.deg2rad(rng.uniform(40.0, 75.0)) / 2)
    heading, down = np.deg2rad(rng.uniform(-20.0, 20.0)), np.arctan2(height_m, aim_m)
    roll = np.deg2rad(rng.uniform(-1.5, 1.5)) if whole else 0.0
    offset = rng.uniform(-30.0, 30.0, 2) if whole else np.zeros(2)
    distortion = np.array([rng.uniform(-0.3, 0.0), rng.uniform(0.0, 0.08), 0, 0, 0]) if whole else np.zeros(5)
    ahead = np.array([np.cos(down) * np.cos(heading), np.cos(down) * np.sin(heading), -np.sin(down)])
    right = np.array([np.sin(heading), -np.cos(heading), 0.0])
    below = np.cross(ahead, right)
    right, below = np.cos(roll) * right + np.sin(roll) * below, np.cos(roll) * below - np.sin(roll) * right
    centre = (np.array(SIZE) - 1) / 2 + offset
    numbers = float(focal_px), float(focal_px), float(centre[0]), float(centre[1])
    pose = Pose(np.stack([right, below, ahead], axis=1), np.array([0.0, 0.0, height_m]))
    return Camera("pole", Intrinsics(*SIZE, *numbers, distortion), pose)


def image(camera: Camera, points_m: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Pixels (N, 2) by OpenCV, and whether they lie in the image."""
    camera_from_world = camera.pose.world_from_camera.T
    in_camera = (points_m - camera.pose.position_m) @ camera_from_world.T
    lens = camera.intrinsics
    pixels = cv2.projectPoints(in_camera, np.zeros(3), np.zeros(3), lens.matrix, lens.distortion)[0].reshape(-1, 2)
    wide = np.hypot(in_camera[:, 0], in_camera[:, 1]) > 1.2 * in_camera[:, 2]  # beyond any lens here
    inside = (in_camera[:, 2] > 0.5) & ~wide & (pixels > 2).all(axis=1) & (pixels < np.array(SIZE) - 3).all(axis=1)
    return np.asarray(pixels, dtype=np.float64), np.asarray(inside)


def draw_map(rng: np.random.Generator) -> FloatArray:
    """(K, 3) points of a road with a crossing: ends of dashes, corners of crosswalks and stop lines, signs, lamps."""
    lines_m = LANE_M * np.arange(-5, 6) + rng.uniform(-LANE_M, LANE_M)
    along = np.concatenate([start + np.arange(6.0, 66.0, 8.0) for start in (rng.uniform(-4, 4), rng.uniform(-4, 4))])
    dashes = np.array([[x, y, 0.0] for x in along for y in lines_m])
    crossing = rng.uniform(18.0, 45.0)
    stripes = np.array([[x, y, 0.0] for x in (crossing, crossing + 4.0) for y in np.arange(-12.0, 12.0, 1.0)])
    raised = np.column_stack([rng.uniform(15, 60, 24), rng.uniform(-25, 25, 24), rng.uniform(2.0, 6.0, 24)])
    return np.concatenate([dashes, stripes, raised])


def pick(camera: Camera, on_map: FloatArray, rng: np.random.Generator, *, ground: bool) -> tuple[PointPicks, BoolArray]:
    """25 picks as a careful owner makes them, and which are right."""
    pixels, seen = image(camera, on_map)
    near = np.hypot(*(on_map[:, :2] - camera.pose.position_m[:2]).T) < FARTHEST_M
    candidates = np.flatnonzero(seen & near & ((on_map[:, 2] == 0.0) | (not ground)))
    first = _spread_out(pixels[candidates], on_map[candidates, 2] == 0.0, FIRST_PICKS)
    noisy = pixels + rng.standard_normal(pixels.shape)
    road = on_map[candidates][on_map[candidates, 2] == 0.0][:, :2]
    start = PointPicks.exact(noisy[candidates[first]], on_map[candidates[first]])
    seed = np.random.default_rng(0)
    guess: Finding
    try:
        if ground:
            guess = calibrate_homography("pole", SIZE, start, rng=seed).homography
        else:
            guess = calibrate_camera("pole", SIZE, start, rng=seed).calibrated
        left = np.setdiff1d(np.arange(len(candidates)), first)
        more = left[choose(guess, on_map[candidates[left]], road, PICKS - FIRST_PICKS)]
        chosen = candidates[np.concatenate([first, more])]
    except CalibrationError:  # a lens so strong that eight points fit no homography: by eye alone
        chosen = candidates[_spread_out(pixels[candidates], on_map[candidates, 2] == 0.0, PICKS)]
    wrong = rng.permutation(len(chosen))[: round(WRONG_SHARE * len(chosen))]
    picked = noisy[chosen].copy()
    for number, row in enumerate(wrong):
        if number % 2:
            picked[row] = pixels[rng.choice(candidates)]
        else:
            angle = rng.uniform(0, 2 * np.pi)
            picked[row] += rng.uniform(5.0, 60.0) * np.array([np.cos(angle), np.sin(angle)])
    right = np.linalg.norm(picked - pixels[chosen], axis=1) < 4.9
    return PointPicks.exact(picked, on_map[chosen]), right


def _spread_out(pixels: FloatArray, on_ground: BoolArray, count: int) -> IntArray:
    """Farthest-point choice in the image, from the lowest point on, on the ground: what an eye calls spread out."""
    chosen = [int(np.where(on_ground, pixels[:, 1], -np.inf).argmax())]
    while len(chosen) < min(count, int(on_ground.sum())):
        apart = np.linalg.norm(pixels[:, None] - pixels[chosen][None], axis=-1).min(axis=1)
        chosen.append(int(np.where(on_ground, apart, -np.inf).argmax()))
    return np.array(chosen)


def information_bound(state: CameraState, points: PointPicks) -> FloatArray:
    """(15, 15) least covariance of any unbiased estimate from ``points`` with 1 px of noise and the stated beliefs."""
    model = CameraModel(points, LinePicks.none(), Beliefs())
    rows = model.observe(state)[0].by_parameters.reshape(-1, state.by_free.shape[1])
    _, believed = model.beliefs(state)
    least: FloatArray = state.by_free @ np.linalg.inv(rows.T @ rows + believed.T @ believed) @ state.by_free.T
    return least


def homography_bound(camera: Camera, points: PointPicks) -> GroundHomography:
    """The true homography with its least covariance."""
    points = points.chosen(points.points_m[:, 2] == 0.0)
    model = HomographyModel(points, *SIZE)
    true = image_from_plane(camera)
    scale = np.diag([1 / model.unit_px, 1 / model.unit_px, 1.0])
    scale[:2, 2] = -model.centre_px / model.unit_px
    back = np.array([[model.unit_m, 0, model.origin_m[0]], [0, model.unit_m, model.origin_m[1]], [0, 0, 1]])
    entries = scale @ true @ back
    entries /= np.linalg.norm(entries) * np.sign((true @ [*points.points_m[0, :2], 1.0])[2])
    state = HomographyState(entries)
    rows = model.observe(state)[0].by_parameters.reshape(-1, 8)
    return model.finished("pole", SIZE, state, np.linalg.inv(rows.T @ rows))


def one_camera(seed: int, whole: bool) -> Trial:
    """Draw, pick, calibrate by every model, and locate."""
    rng = np.random.default_rng([whole, seed])
    camera = draw_camera(rng, whole=whole)
    on_map = draw_map(rng)
    refused: list[str] = []
    placed: dict[str, Placed] = {}
    places_m = _places(camera, rng)
    drawn = {"near_axis": draw_lane(camera, rng, near_axis=True), "off_axis": draw_lane(camera, rng, near_axis=False)}
    lanes: dict[str, dict[str, Across]] = {name: {} for name in drawn}
    with_signs = pick(camera, on_map, rng, ground=False)
    flat = pick(camera, on_map, rng, ground=True)
    for model in MODELS:
        points, right = flat if model == "homography" else with_signs
        try:
            found = _calibrated(model, points)
        except CalibrationError:
            refused.append(model)
            continue
        bound = _bound(model, camera, points.chosen(right))
        placed[model] = _placed(found, bound, camera, places_m)
        for lane, (lane_m, normal) in drawn.items():
            lanes[lane][model] = _placed(found, bound, camera, lane_m).across(normal)
    return Trial(np.linalg.norm(places_m[:, :2], axis=1), placed, lanes, tuple(refused))


def _bound(model: str, camera: Camera, points: PointPicks) -> Finding:
    """Covariance bound of ``model`` at the true camera; for simpler models as if the camera were as they assume."""
    if model == "homography":
        return homography_bound(camera, points)
    state: CameraState = FullState(camera) if model == "full" else PanTiltState.near(camera)[0]
    return CalibratedCamera(camera, information_bound(state, points))


def _calibrated(model: str, points: PointPicks) -> Finding:
    rng = np.random.default_rng(0)
    if model == "homography":
        return calibrate_homography("pole", SIZE, points, rng=rng).homography
    calibrate: Callable[..., object] = calibrate_camera if model == "full" else calibrate_pan_tilt
    return calibrate("pole", SIZE, points, rng=rng).calibrated  # type: ignore[attr-defined, no-any-return]


def _placed(found: Finding, bound: Finding, camera: Camera, places_m: FloatArray) -> Placed:
    pixels, _ = image(camera, places_m)
    located = locate_pixels(found, pixels)
    least = locate_pixels(bound, _straight(camera, places_m) if isinstance(bound, GroundHomography) else pixels)
    return Placed(located.positions_m - places_m[:, :2], located.covs_m2, least.covs_m2)


def _straight(camera: Camera, places_m: FloatArray) -> FloatArray:
    """Pixels without lens, which is what the true homography images."""
    mapped = np.column_stack([places_m[:, :2], np.ones(len(places_m))]) @ image_from_plane(camera).T
    return np.asarray(mapped[:, :2] / mapped[:, 2:])


def _places(camera: Camera, rng: np.random.Generator) -> FloatArray:
    """(40, 3) places on the road, uniform in range to 60 m and in direction, where the camera sees them."""
    kept: list[FloatArray] = []
    while len(kept) < 40:
        distance, angle = rng.uniform(5.0, FARTHEST_M), rng.uniform(-0.7, 0.7)
        heading = np.arctan2(*camera.pose.world_from_camera[1::-1, 2]) + angle
        point = np.array([distance * np.cos(heading), distance * np.sin(heading), 0.0])
        if abs(point[1]) < 18.0 and image(camera, point[None])[1][0]:
            kept.append(point)
    return np.array(kept)


def draw_lane(camera: Camera, rng: np.random.Generator, *, near_axis: bool) -> tuple[FloatArray, FloatArray]:
    """26 points (26, 3) of a straight lane's centreline, uniform in range, and the lane's normal (2,).

    near_axis: within 20 degrees of the viewing direction in the plan; else between 20 and 90. Lanes that run less than
    15 m through the image are drawn again.
    """
    viewing = np.arctan2(*camera.pose.world_from_camera[1::-1, 2])
    while True:
        angle = rng.uniform(-NEAR_AXIS_DEG, NEAR_AXIS_DEG) if near_axis else rng.uniform(NEAR_AXIS_DEG, 90.0)
        angle *= 1.0 if near_axis else rng.choice([-1.0, 1.0])
        course = np.array([np.cos(viewing + np.deg2rad(angle)), np.sin(viewing + np.deg2rad(angle))])
        distance, aside = rng.uniform(15.0, 50.0), rng.uniform(-9.0, 9.0)
        through = distance * np.array([np.cos(viewing), np.sin(viewing)]) + aside * np.array([-course[1], course[0]])
        places = np.column_stack([through + np.linspace(-80, 80, 3201)[:, None] * course, np.zeros(3201)])
        ranges = np.linalg.norm(places[:, :2], axis=1)
        seen = image(camera, places)[1] & (ranges < FARTHEST_M)
        if seen.sum() > 300:
            wanted = rng.uniform(ranges[seen].min(), ranges[seen].max(), PROTOCOL_POINTS)
            nearest = np.abs(ranges[seen][None] - wanted[:, None]).argmin(axis=1)
            return places[seen][nearest], np.array([-course[1], course[0]])


def measure(count: int) -> list[Score]:
    """All figures over ``count`` whole and as many plain cameras."""
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        kinds = {
            kind: list(pool.map(one_camera, range(count), [kind == "whole"] * count, chunksize=4))
            for kind in ("whole", "plain")
        }
    return [score for kind, trials in kinds.items() for model in MODELS for score in _scores(kind, model, trials)]


def _scores(kind: str, model: str, trials: Sequence[Trial]) -> list[Score]:
    name = f"map_calibration.{kind}.{model}"
    done = [trial for trial in trials if model not in trial.refused]
    scores = [Score.of(f"{name}.refused", len(trials) - len(done), "count", len(trials))]
    if not done:
        return scores
    for lane in ("near_axis", "off_axis"):
        by_camera = np.array([trial.lanes[lane][model].errors_m for trial in done])  # (cameras, 26)
        bound = np.array([trial.lanes[lane][model].bound_m for trial in done])
        scores += [
            Score.of(f"{name}.{lane}.mean_m", by_camera.mean(), "m", by_camera.size),
            Score.of(f"{name}.{lane}.rms_m", _rms(by_camera), "m", by_camera.size),
            Score.of(f"{name}.{lane}.bound_rms_m", _rms(bound), "m", bound.size),
            Score.of(f"{name}.{lane}.largest_median_m", np.median(by_camera.max(axis=1)), "m", len(done)),
            Score.of(f"{name}.{lane}.largest_m", by_camera.max(), "m", by_camera.size),
            Score.of(f"{name}.{lane}.bound_mean_m", np.sqrt(2 / np.pi) * bound.mean(), "m", bound.size),
        ]
    ranges = np.concatenate([trial.ranges_m for trial in done])
    squares = np.concatenate([(trial.placed[model].errors_m ** 2).sum(axis=1) for trial in done])
    least = np.concatenate([np.trace(trial.placed[model].bound_m2, axis1=1, axis2=2) for trial in done])
    for low, high in (*RANGES_M, (0.0, FARTHEST_M)):
        within = (ranges >= low) & (ranges < high)
        label = f"{name}.range_{low:.0f}_{high:.0f}"
        error, bound = np.sqrt(squares[within].mean()), np.sqrt(least[within].mean())
        scores += [
            Score.of(f"{label}.rms_m", error, "m", int(within.sum())),
            Score.of(f"{label}.bound_m", bound, "m", int(within.sum())),
            Score.of(f"{label}.ratio", error / bound, "1", int(within.sum())),
        ]
    inside = [trial.placed[model].inside for trial in done]
    return [*scores, Score.of(f"{name}.coverage_90", float(np.mean(inside)), "1", len(done))]


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--cameras", type=int, default=200, help="of each kind")
    parser.add_argument("--json", action="store_true", help="print JSON and nothing else")
    arguments = parser.parse_args()
    scores = measure(arguments.cameras)
    if arguments.json:
        print(to_json(scores))
        return
    for score in scores:
        value = "-" if score.value is None else f"{score.value:.4f}"
        print(f"{score.name:58} {value:>9} {score.unit:5} n = {score.n}")


if __name__ == "__main__":
    main()

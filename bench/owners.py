"""What the owners' commands do: calibrate a real camera and place its pixels. Uses georef only, no simulation."""

import json as json_module
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from contracts import Checkerboard, FloatArray, Frame, InputError
from contracts.errors import CalibrationError
from georef.calibrated import CalibratedCamera
from georef.camera_file import write_stored
from georef.camera_forms import CameraForm, StoredCamera
from georef.camera_models import Beliefs
from georef.geo_reference import GeoReference
from georef.ground_homography import GroundHomography
from georef.hd_map import HdMap, Line, Point
from georef.hd_map_file import read_map
from georef.homography_file import read_found, write_homography
from georef.intrinsics import IntrinsicCalibration, calibrate_intrinsics
from georef.locate import Located, locate_pixels
from georef.map_calibration import PickVerdict, calibrate_camera, calibrate_homography, calibrate_pan_tilt
from georef.mixture import Noise
from georef.next_pick import gains
from georef.picks_file import PicksFile, read_picks, read_table

_PIXEL_COLUMNS = ("name", "u_px", "v_px", "height_m", "sigma_px")
_WRONG_BELOW = 0.5


@dataclass(frozen=True)
class Wanted:
    """What ``gantry calibrate camera`` was asked for."""

    model: str
    name: str
    size_px: tuple[int, int]
    noise_px: float
    height_m: float | None
    seed: int
    form: str

    def __post_init__(self) -> None:
        if not (np.isfinite(self.noise_px) and self.noise_px > 0):
            raise InputError(f"--noise-px {self.noise_px} must be positive")
        if self.height_m is not None and not (np.isfinite(self.height_m) and self.height_m > 0):
            raise InputError(f"--height-m {self.height_m} must be positive")
        if self.seed < 0:
            raise InputError(f"--seed {self.seed} must not be negative")
        if self.model == "homography" and self.form != CameraForm.GANTRY:
            raise InputError(f"a homography is no camera: the form {self.form} cannot say it; leave --form away")


@dataclass(frozen=True, eq=False)
class Calibration:
    """A calibration from picks, with what to pick next: a name of the map and the drop in metres, or None."""

    found: CalibratedCamera | GroundHomography
    verdict: PickVerdict
    picks: PicksFile
    next_pick: tuple[str, float] | None


def calibrate_lens(
    images: Sequence[Path], board: tuple[int, int, float], name: str, out: Path, form: str
) -> IntrinsicCalibration:
    """Zhang's method on image files; writes the camera file, without pose. Raises InputError, CalibrationError."""
    frames = []
    for index, path in enumerate(images):
        image = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
        if image is None:
            raise InputError(f"{path} is no image that can be read")
        frames.append(Frame(name, index, 0, np.asarray(image, dtype=np.uint8)))
    lens = calibrate_intrinsics(frames, Checkerboard(*board))
    covariance = np.zeros((15, 15))
    covariance[:9, :9] = lens.covariance
    write_stored(out, StoredCamera(name, lens.intrinsics, None, covariance), CameraForm(form))
    return lens


def calibrate_from_picks(
    table: Path, map_path: Path | None, origin_deg: tuple[float, float] | None, wanted: Wanted, out: Path
) -> Calibration:
    """Fit the wanted model and write its file. Raises InputError and CalibrationError."""
    if map_path is not None and origin_deg is not None:
        raise InputError("the map has an origin of its own: leave --origin away")
    hd_map = read_map(map_path) if map_path else None
    picks = read_picks(table, hd_map=hd_map, geo=GeoReference(*origin_deg) if origin_deg else None)
    rng, noise = np.random.default_rng(wanted.seed), Noise(wanted.noise_px)
    found: CalibratedCamera | GroundHomography
    try:
        if wanted.model == "homography":
            flat = calibrate_homography(wanted.name, wanted.size_px, picks.points, rng=rng, noise=noise)
            found, verdict = flat.homography, flat.picks
            write_homography(out, flat.homography, picks.geo)
        else:
            calibrate = calibrate_camera if wanted.model == "full" else calibrate_pan_tilt
            knows = Beliefs(height_m=wanted.height_m)
            whole = calibrate(
                wanted.name, wanted.size_px, picks.points, picks.lines, rng=rng, noise=noise, beliefs=knows
            )
            found, verdict = whole.calibrated, whole.picks
            write_stored(out, StoredCamera.of(whole.calibrated, picks.geo), CameraForm(wanted.form))
    except CalibrationError as error:
        raise CalibrationError(f"{table}: {error}") from error
    return Calibration(found, verdict, picks, _next_pick(found, verdict, picks, hd_map))


def _next_pick(
    found: CalibratedCamera | GroundHomography, verdict: PickVerdict, picks: PicksFile, hd_map: HdMap | None
) -> tuple[str, float] | None:
    """The map's point that would help most, and the standard deviation (m) that places on the road would lose."""
    named = _map_points(hd_map) if hd_map else []
    free = [(name, place) for name, place in named if name not in picks.points.names]
    if not free:
        return None
    road = picks.points.points_m[np.abs(picks.points.points_m[:, 2]) < 1.0][:, :2]
    gain = gains(found, np.array([place for _, place in free]), road, sigma_px=verdict.noise_px)
    if gain.best is None:
        return None
    lost = np.sqrt(gain.now_m2) - np.sqrt(max(gain.now_m2 - float(gain.drops_m2[gain.best]), 0.0))
    return free[gain.best][0], float(lost)


def _map_points(hd_map: HdMap) -> list[tuple[str, FloatArray]]:
    """Every point and every corner of a line, under the name that a pick gives it."""
    points: list[tuple[str, FloatArray]] = []
    for feature in hd_map.features():
        if isinstance(feature, Point):
            points.append((feature.id, feature.position_m))
        elif isinstance(feature, Line):
            points += [(f"{feature.id}#{number + 1}", place) for number, place in enumerate(feature.points_m)]
    return points


def print_lens(lens: IntrinsicCalibration, out: Path, *, json: bool) -> None:
    """K, lens, residuals."""
    k, sigmas = lens.intrinsics, np.sqrt(np.diag(lens.covariance))
    values = [k.fx_px, k.fy_px, k.cx_px, k.cy_px, *k.distortion.tolist()]
    rows = dict(zip(("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3"), values, strict=True))
    _print_parameters(rows, sigmas, {"residual_rms_px": lens.residual_rms_px, "views": lens.views}, out, json=json)


def print_calibration(calibration: Calibration, out: Path, *, json: bool) -> None:
    """Parameters, residuals, wrong picks and the next one."""
    found, verdict = calibration.found, calibration.verdict
    wrong = [
        name
        for names, good in (
            (calibration.picks.points.names, verdict.good),
            (calibration.picks.lines.names, verdict.line_good),
        )
        for name, probability in zip(names, good, strict=False)
        if probability < _WRONG_BELOW
    ]
    extra: dict[str, Any] = {
        "noise_px": verdict.noise_px,
        "picks": int(np.isfinite(verdict.good).sum()) + len(verdict.line_good),
        "wrong_picks": wrong,
        "next_pick": calibration.next_pick[0] if calibration.next_pick else None,
    }
    if isinstance(found, GroundHomography):
        names = [f"h{row}{column}" for row in (1, 2, 3) for column in (1, 2, 3)]
        rows = dict(zip(names, found.image_from_ground.ravel().tolist(), strict=True))
    else:
        k, pose = found.camera.intrinsics, found.camera.pose
        ahead, right = pose.world_from_camera[:, 2], pose.world_from_camera[:, 0]
        extra["heading_deg"] = float(np.rad2deg(np.arctan2(ahead[1], ahead[0])))
        extra["down_deg"] = float(np.rad2deg(-np.arcsin(np.clip(ahead[2], -1, 1))))
        extra["roll_deg"] = float(np.rad2deg(np.arcsin(np.clip(-right[2], -1, 1))))
        values = [k.fx_px, k.cx_px, k.cy_px, *k.distortion[:2].tolist(), *pose.position_m.tolist()]
        rows = dict(zip(("f_px", "cx_px", "cy_px", "k1", "k2", "x_m", "y_m", "z_m"), values, strict=True))
    sigmas = np.sqrt(np.diag(found.covariance))
    kept = sigmas if isinstance(found, GroundHomography) else sigmas[[0, 2, 3, 4, 5, 12, 13, 14]]
    _print_parameters(rows, kept, extra, out, json=json)


def _print_parameters(
    rows: dict[str, float], sigmas: FloatArray, extra: dict[str, Any], out: Path, *, json: bool
) -> None:
    if json:
        told = {
            name: {"value": value, "sigma": float(s)} for (name, value), s in zip(rows.items(), sigmas, strict=True)
        }
        print(json_module.dumps({"file": str(out), "parameters": told, **extra}, indent=2))
        return
    for (name, value), sigma in zip(rows.items(), sigmas, strict=True):
        print(f"{name:8} {value:14.6g} +- {sigma:.2g}")
    for name, told in extra.items():
        if told is not None:
            shown = f"{told:.4g}" if isinstance(told, float) else ", ".join(told) if isinstance(told, list) else told
            print(f"{name.replace('_', ' ')}: {shown if shown != '' else 'none'}")
    print(out)


@dataclass(frozen=True, eq=False)
class Places:
    """Located pixels with their names; latitudes and longitudes (N, 2) where the camera's file says where it stands."""

    names: tuple[str, ...]
    located: Located
    places_deg: FloatArray | None


def locate_table(camera: Path, table: Path) -> Places:
    """Place the pixels of a table: u_px, v_px and perhaps height_m, sigma_px (1 if not given), name."""
    found, geo = read_found(camera)
    rows = read_table(table, _PIXEL_COLUMNS, required=("u_px", "v_px"))
    pixels = np.array([[row.required("u_px"), row.required("v_px")] for row in rows])
    heights = np.array([row.number("height_m") or 0.0 for row in rows])
    told = [row.number("sigma_px") for row in rows]
    sigmas = np.array([1.0 if sigma is None else sigma for sigma in told])
    if (sigmas < 0).any():
        raise InputError(f"{rows[int(sigmas.argmin())].where}, column sigma_px: must not be negative")
    located = locate_pixels(found, pixels, heights_m=heights, covs_px2=sigmas[:, None, None] ** 2 * np.eye(2))
    names = tuple(row.cells.get("name") or str(number + 1) for number, row in enumerate(rows))
    return Places(names, located, geo.to_wgs84(located.positions_m) if geo else None)


def print_places(places: Places, *, json: bool) -> None:
    """One place a line; what meets no ground is said to be not valid."""
    rows = [_place_row(places, number) for number in range(len(places.names))]
    if json:
        print(json_module.dumps(rows, indent=2))
        return
    print(
        "name x_m y_m sigma_east_m sigma_north_m"
        + (" latitude_deg longitude_deg" if places.places_deg is not None else "")
    )
    for row in rows:
        if not row["valid"]:
            print(f"{row['name']} - not on the ground: at or above the horizon, or beyond the lens")
            continue
        (east, _), (_, north) = row["cov_m2"]
        line = f"{row['name']} {row['x_m']:.3f} {row['y_m']:.3f} {np.sqrt(east):.3f} {np.sqrt(north):.3f}"
        print(line + (f" {row['latitude_deg']:.9f} {row['longitude_deg']:.9f}" if "latitude_deg" in row else ""))


def _place_row(places: Places, number: int) -> dict[str, Any]:
    located, valid = places.located, bool(places.located.valid[number])
    row: dict[str, Any] = {"name": places.names[number], "valid": valid}
    for column, value in zip(("x_m", "y_m"), located.positions_m[number].tolist(), strict=True):
        row[column] = value if valid else None
    row["cov_m2"] = located.covs_m2[number].tolist() if valid else None
    if places.places_deg is not None:
        for column, value in zip(("latitude_deg", "longitude_deg"), places.places_deg[number].tolist(), strict=True):
            row[column] = value if valid else None
    return row

"""What the owners' commands print, for people or as JSON."""

import json as json_module
from pathlib import Path
from typing import Any

import numpy as np

from bench.owners.calibrations import Calibration
from bench.owners.places import Places
from contracts import FloatArray
from georef.calibrated import PARAMETERS
from georef.ground_homography import GroundHomography
from georef.intrinsics import IntrinsicCalibration

_CAMERA_ROWS = {
    "f_px": "fx",
    "cx_px": "cx",
    "cy_px": "cy",
    **{name: name for name in ("k1", "k2", "p1", "p2")},
    **{f"{axis}_m": axis for axis in "xyz"},
}
"""What is printed of a camera, and what ``PARAMETERS`` calls it."""


def print_lens(lens: IntrinsicCalibration, out: Path, *, json: bool) -> None:
    """K, lens, residuals, and the images that were of no use."""
    k, sigmas = lens.intrinsics, np.sqrt(np.diag(lens.covariance))
    values = [k.fx_px, k.fy_px, k.cx_px, k.cy_px, *k.distortion.tolist()]
    rows = dict(zip(("fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "p1", "p2", "k3"), values, strict=True))
    extra = {
        "residual_rms_px": lens.residual_rms_px,
        "views": lens.views,
        "no_board_found_in": list(lens.unused),
    }
    _print_parameters(rows, sigmas, extra, out, json=json)


def print_calibration(calibration: Calibration, out: Path, *, json: bool) -> None:
    """Parameters, residuals, wrong picks and the next one."""
    found = calibration.found
    extra: dict[str, Any] = {
        "noise_px": calibration.noise_px,
        "picks": calibration.picks,
        "wrong_picks": list(calibration.wrong_picks),
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
        values = [k.fx_px, k.cx_px, k.cy_px, *k.distortion[:4].tolist(), *pose.position_m.tolist()]
        rows = dict(zip(_CAMERA_ROWS, values, strict=True))
    sigmas = np.sqrt(np.diag(found.covariance))
    kept = (
        sigmas if isinstance(found, GroundHomography) else sigmas[[PARAMETERS.index(n) for n in _CAMERA_ROWS.values()]]
    )
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

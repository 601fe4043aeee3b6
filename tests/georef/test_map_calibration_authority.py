"""The whole camera against OpenCV's own optimisers on the same picks, where nothing was believed beforehand."""

import cv2
import numpy as np
from map_cases import SIZE, STRONG_LENS, image, picks, pole

from georef.camera_models import Beliefs
from georef.map_calibration import calibrate_camera
from georef.mixture import Noise

TRUE = pole(roll_deg=1.0, offset_px=(18.0, -12.0), distortion=STRONG_LENS)
PICKS = picks(TRUE, 3, count=40, noise_px=0.3, raised=0.5)
NOTHING = Beliefs(principal_point_share=1e3, k1=1e4, k2=1e4)
FOUND = calibrate_camera(
    "pole", SIZE, PICKS, rng=np.random.default_rng(0), noise=Noise(0.3), beliefs=NOTHING
).calibrated
SIGMAS = np.sqrt(np.diag(FOUND.covariance))


def test_calibrate_camera_finds_the_same_optimum():
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_ASPECT_RATIO | cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    _, matrix, lens, turns, shifts = cv2.calibrateCamera(
        [PICKS.points_m.astype(np.float32)],
        [PICKS.pixels.astype(np.float32)],
        SIZE,
        TRUE.intrinsics.matrix,
        np.zeros(5),
        flags=flags,
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 500, 1e-14),
    )
    position = -cv2.Rodrigues(turns[0])[0].T @ shifts[0][:, 0]
    k = FOUND.camera.intrinsics
    ours = np.array([k.fx_px, k.cx_px, k.cy_px, *k.distortion[:2], *FOUND.camera.pose.position_m])
    theirs = np.array([matrix[0, 0], matrix[0, 2], matrix[1, 2], *lens.ravel()[:2], *position])
    assert (np.abs(ours - theirs) / SIGMAS[[0, 2, 3, 4, 5, 12, 13, 14]]).max() < 0.05  # of a standard deviation


def test_solve_pnp_leaves_the_pose_where_it_is():
    camera_from_world = FOUND.camera.pose.world_from_camera.T
    turn = cv2.Rodrigues(camera_from_world)[0]
    shift = (-camera_from_world @ FOUND.camera.pose.position_m)[:, None]
    lens = FOUND.camera.intrinsics
    _, turn, shift = cv2.solvePnP(
        PICKS.points_m, PICKS.pixels, lens.matrix, lens.distortion, turn, shift, useExtrinsicGuess=True
    )
    position = -cv2.Rodrigues(turn)[0].T @ shift[:, 0]
    assert np.abs(position - FOUND.camera.pose.position_m).max() < 0.001
    assert np.abs(image(FOUND.camera, PICKS.points_m) - PICKS.pixels).max() < 1.5

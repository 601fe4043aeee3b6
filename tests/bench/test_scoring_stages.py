"""The split of the error by stage, the anchors' and the calibration's own errors, contacts."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scoring_cases import (
    SIZE_M,
    camera,
    edit_ground,
    edit_tracks,
    edit_truth,
    perfect_recording,
    perfect_recordings,
    project,
    shifted,
)

from bench.recording import Recording
from bench.scores import by_name
from bench.scoring import score
from bench.scoring.calibration import camera_errors
from bench.scoring.rays import to_pixels, to_plane
from contracts import Camera, Event, EventKind, Pose
from georef.calibrated import CalibratedCamera
from georef.location import RayPlaneLocator

small = st.floats(-0.02, 0.02)


def values(recording):
    return {name: one.value for name, one in by_name(score(recording)).items()}


def moved(true_camera: Camera, *, shift_m=(0.0, 0.0, 0.0), turn_rad=(0.0, 0.0, 0.0), focal_px=0.0) -> Camera:
    turn, _ = cv2.Rodrigues(np.array(turn_rad))
    pose = Pose(turn @ true_camera.pose.world_from_camera, true_camera.pose.position_m + np.array(shift_m))
    lens = true_camera.intrinsics
    return replace(
        true_camera,
        pose=pose,
        intrinsics=replace(lens, fx_px=lens.fx_px + focal_px, fy_px=lens.fy_px + focal_px),
    )


def with_anchor_offset(recording, offset_px):
    def offset(tracks):
        return replace(tracks, objects=replace(tracks.objects, anchors_px=tracks.objects.anchors_px + offset_px))

    return edit_tracks(recording, offset)


def with_calibration(recording, change):
    cameras = tuple(CalibratedCamera(change(one), np.zeros((15, 15))) for one in recording.manifest.true_cameras)
    return Recording(replace(recording.manifest, calibrated_cameras=cameras), recording.steps)


def located(recording) -> Recording:
    """The ground tracks that the project's own location makes of the recorded tracks."""
    locator = RayPlaneLocator({one.camera.name: one for one in recording.manifest.calibrated_cameras})
    steps = (replace(step, views=tuple(locator.locate(track) for track in step.tracks)) for step in recording.steps)
    return Recording(recording.manifest, tuple(steps))


@given(st.lists(st.tuples(small, small, st.floats(0, 0.1)), min_size=1, max_size=5))
def test_rays_meet_the_points_that_were_projected(offsets):
    points_m = np.array([[20 * x, 20 * y, z] for x, y, z in offsets])
    west = camera("west", (-0.1, 0.05, 2.8))
    pixels = project(west, points_m)
    assert np.abs(to_plane(west, pixels, points_m[:, 2]) - points_m[:, :2]).max() < 1e-9
    assert np.abs(to_pixels(west, points_m) - pixels).max() < 1e-9


def test_a_ray_that_does_not_meet_its_plane_has_no_place():
    west = camera("west", (0.0, 0.0, 2.8))
    assert np.isnan(to_plane(west, np.array([[641.0, 0.0]]), np.array([3.0]))).all()


@given(perfect_recordings())
def test_the_truth_itself_has_no_part_of_error_at_any_stage(recording):
    read = values(recording)
    for stage in ("anchor", "calibration", "location"):
        assert read[f"stage.{stage}.max_m"] < 1e-9
    assert read["anchor.rms_u_px"] == read["anchor.mean_v_px"] == 0


@given(perfect_recordings(), st.floats(-3, 3), st.floats(-3, 3))
def test_an_anchor_offset_is_read_exactly_and_is_the_anchors_part(recording, right_px, down_px):
    read = values(located(with_anchor_offset(recording, [right_px, down_px])))
    assert abs(read["anchor.mean_u_px"] - right_px) < 1e-9
    assert abs(read["anchor.rms_v_px"] - abs(down_px)) < 1e-9
    assert read["stage.calibration.max_m"] < 1e-9
    assert read["stage.location.max_m"] < 1e-7
    assert read["stage.anchor.max_m"] == pytest.approx(np.hypot(right_px, down_px) * 2.74 / 1400, rel=0, abs=5e-4)


@given(perfect_recordings(), small, small)
def test_a_displaced_calibration_is_the_calibrations_part(recording, east_m, north_m):
    displaced = with_calibration(recording, lambda one: moved(one, shift_m=(east_m, north_m, 0.0)))
    read = values(located(displaced))
    assert read["stage.anchor.max_m"] < 1e-9
    assert abs(read["stage.calibration.mean_x_m"] - east_m) < 1e-9
    assert abs(read["stage.calibration.mean_y_m"] - north_m) < 1e-9
    assert read["stage.location.max_m"] < 1e-7


@given(perfect_recordings(), small, small)
def test_a_fault_of_the_location_is_the_locations_part(recording, east_m, north_m):
    read = values(edit_ground(recording, lambda ground: shifted(ground, [east_m, north_m])))
    assert read["stage.anchor.max_m"] < 1e-9
    assert read["stage.calibration.max_m"] < 1e-9
    assert abs(read["stage.location.mean_x_m"] - east_m) < 1e-9


def test_the_naive_projection_is_off_by_what_height_and_distance_from_the_axis_say():
    recording = located(perfect_recording(steps=1, vehicles=1, cameras=1))
    west = recording.manifest.true_cameras[0]
    read = values(recording)
    outward_m = (recording.steps[0].truth.positions_m[0] - west.pose.position_m)[:2]
    expected_m = outward_m * SIZE_M[2] / (west.pose.position_m[2] - SIZE_M[2])
    assert abs(read["ground_z0.mean_x_m"] - expected_m[0]) < 1e-6
    assert abs(read["ground_z0.mean_y_m"] - expected_m[1]) < 1e-6
    assert read["ground.west.max_m"] < 1e-9


@given(st.tuples(small, small, small), st.tuples(small, small, small), st.floats(-5, 5))
def test_calibration_errors_are_read_exactly(shift_m, turn_rad, focal_px):
    west = camera("west", (-0.1, 0.05, 2.8))
    errors = camera_errors(west, moved(west, shift_m=shift_m, turn_rad=turn_rad, focal_px=focal_px))
    assert abs(errors["position_error_m"] - np.linalg.norm(shift_m)) < 1e-9
    assert abs(errors["rotation_error_rad"] - np.linalg.norm(turn_rad)) < 1e-9
    assert abs(errors["focal_error_px"] - abs(focal_px)) < 1e-9
    assert errors["principal_point_error_px"] == 0


def test_a_camera_displaced_sideways_misplaces_every_pixel_by_that_much():
    west = camera("west", (-0.1, 0.05, 2.8))
    errors = camera_errors(west, moved(west, shift_m=(0.003, -0.004, 0.0)))
    assert abs(errors["ground_rms_m"] - 0.005) < 1e-9
    assert errors["reprojection_rms_px"] == pytest.approx(0.005 * 1400 / 2.8, rel=0, abs=0.3)


def test_contacts_and_pairs_are_counted():
    touch = [Event(k, EventKind.CONTACT, ("vehicle 0", "vehicle 1")) for k in range(2)]
    passed = Event(1, EventKind.BALISE, ("vehicle 0",), "00ff")
    recording = edit_truth(
        perfect_recording(steps=3), lambda truth: replace(truth, events=(*touch, passed) if truth.index == 1 else ())
    )
    read = values(recording)
    assert read["contact.count"] == 2
    assert read["contact.pairs"] == 1


def test_tracks_that_were_not_recorded_leave_their_scores_without_value():
    recording = perfect_recording()
    bare = Recording(recording.manifest, tuple(replace(step, tracks=()) for step in recording.steps))
    read = by_name(score(bare))
    assert not read["anchor.rms_u_px"].valid
    assert not read["stage.anchor.rms_x_m"].valid
    assert read["ground.rms_x_m"].valid

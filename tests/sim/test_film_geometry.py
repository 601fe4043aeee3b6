"""Rendered dots and boxes lie where camera matrix, lens and pose say: the half pixel, the signs, the lens."""

import cv2
import numpy as np
import pytest
from film_cases import camera, empty_scene, marks_grid, state
from scipy.spatial import ConvexHull

from contracts import BoolArray, Camera, FloatArray
from contracts.truth import Truth
from sim.full_renderer import FullRenderer
from sim.lens import Lens, pinhole_camera
from sim.lights import LightPreset

OFF_CENTRE = (260.3, 275.8)
LENS = (-0.12, 0.05, 0.001, -0.0008, 0.0)


def projected_by_opencv(view: Camera, points_m: FloatArray) -> FloatArray:
    camera_from_world = view.pose.world_from_camera.T
    rotation, _ = cv2.Rodrigues(camera_from_world)
    shift = -camera_from_world @ view.pose.position_m
    pixels, _ = cv2.projectPoints(points_m, rotation, shift, view.intrinsics.matrix, view.intrinsics.distortion)
    return pixels.reshape(-1, 2)


def pictures(view: Camera, *scenes: object) -> list[np.ndarray]:
    """Through the lens, without noise, under an even light."""
    lens = Lens.of(view.intrinsics)
    images = []
    for scene in scenes:
        renderer = FullRenderer(scene, [pinhole_camera(view, lens)], LightPreset.CLOUDY)
        images.append(lens.bend(renderer.render(state(), view.name).image))
        renderer.close()
    return images


def dot_centres(view: Camera, expected_px: FloatArray, half_px: int) -> FloatArray:
    """Centre of mass of each dot: the picture with dots less the picture without, in a window around each."""
    with_dots, without = pictures(view, marks_grid(0.1), empty_scene())
    weight = np.abs(with_dots.astype(float) - without).sum(axis=2)
    centres = []
    for u, v in expected_px.round().astype(int):
        window = weight[v - half_px : v + half_px + 1, u - half_px : u + half_px + 1]
        ticks = np.arange(-half_px, half_px + 1)
        centres.append([u + window.sum(0) @ ticks / window.sum(), v + window.sum(1) @ ticks / window.sum()])
    return np.array(centres)


@pytest.mark.film
@pytest.mark.parametrize("distortion", [(0.0,) * 5, LENS], ids=["pinhole", "lens"])
@pytest.mark.parametrize("principal_px", [None, OFF_CENTRE], ids=["centred", "off-centre"])
def test_rendered_dots_lie_where_matrix_lens_and_pose_say(principal_px, distortion):
    view = camera(principal_px=principal_px, distortion=distortion)
    points = marks_grid(0.1).control_points_m
    expected = projected_by_opencv(view, points)
    inside = ((expected > 12) & (expected < np.array([640, 480]) - 13)).all(axis=1)
    error = dot_centres(view, expected[inside], half_px=11) - expected[inside]
    assert inside.sum() >= 60
    assert np.abs(error.mean(axis=0)).max() <= 0.02
    assert np.sqrt((error**2).mean(axis=0)).max() <= 0.05


@pytest.mark.film
def test_a_wrong_half_pixel_or_sign_of_the_principal_point_would_be_seen():
    """The planted fault reads back as itself, so the test above can fail."""
    view = camera(principal_px=OFF_CENTRE)
    points = marks_grid(0.1).control_points_m
    expected = projected_by_opencv(view, points) + 0.5
    inside = ((expected > 12) & (expected < np.array([640, 480]) - 13)).all(axis=1)
    error = dot_centres(view, expected[inside], half_px=11) - expected[inside]
    assert np.abs(error.mean(axis=0) + 0.5).max() <= 0.02


@pytest.mark.film
@pytest.mark.parametrize(("distortion", "shift_px", "wrong_px"), [((0.0,) * 5, 0.002, 3), (LENS, 0.1, 600)])
def test_instance_masks_cover_the_boxes_of_the_truth(distortion, shift_px, wrong_px):
    """To the pixel through a pinhole; through a lens each edge falls on one side or the other, without bias."""
    view = camera(distortion=distortion, azimuth_deg=133.0)
    lens = Lens.of(view.intrinsics)
    renderer = FullRenderer(empty_scene(), [pinhole_camera(view, lens)], LightPreset.CLOUDY)
    places = [(x, y, 50.0 * x + 170.0 * y) for x in (-0.36, -0.12, 0.12, 0.36) for y in (-0.2, 0.0, 0.2)]
    here = state(*[("blue", *place) for place in places])
    mask = lens.bend_mask(renderer.render(here, "eye").instances)
    renderer.close()
    shifts, wrong = [], 0
    for row, corners in enumerate(box_corners(here)):
        shown, wanted = mask == row + 1, pixels_inside(projected_by_opencv(view, corners))
        wrong += (shown ^ wanted).sum()
        shifts.append(np.argwhere(shown).mean(axis=0) - np.argwhere(wanted).mean(axis=0))
    assert np.abs(np.mean(shifts, axis=0)).max() < shift_px
    assert wrong <= wrong_px  # of some 16,000


def pixels_inside(points_px: FloatArray) -> BoolArray:
    u, v = np.meshgrid(np.arange(640), np.arange(480))
    sides = ConvexHull(points_px).equations[:, :, None, None]
    return (sides[:, 0] * u + sides[:, 1] * v + sides[:, 2] <= 0.0).all(axis=0)


def box_corners(here: Truth) -> list[FloatArray]:
    corners = []
    for place, heading, size in zip(here.positions_m, here.headings_rad, here.sizes_m, strict=True):
        unit = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (0.0, 1.0)])
        turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1]])
        corners.append((unit * size) @ turn.T + place)
    return corners

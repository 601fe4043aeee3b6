import numpy as np
import pytest
from georef_cases import cameras, overhead, perturbed, pixels
from hypothesis import given
from hypothesis import strategies as st

from contracts import Detections, InputError, Locator, Tracks
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.location import GroundPlaneLocator, RayPlaneLocator, on_plane, place
from georef.projection import project

SIGMAS = np.array([0.8, 0.8, 1.2, 1.2, 2e-3, 1e-2, 1e-4, 1e-4, 2e-2, 3e-4, 3e-4, 1e-4, 8e-4, 8e-4, 5e-4])
CHI2_90 = 4.605170186  # 2 degrees of freedom


def tracks_at(anchors_px, heights_m, covs_px2=None, camera="west"):
    n = len(anchors_px)
    boxes = np.hstack([anchors_px - 5.0, anchors_px + 5.0])
    covs = np.tile(np.eye(2), (n, 1, 1)) if covs_px2 is None else covs_px2
    objects = Detections(
        camera, 3, 120_000_000, ("blue",) * n, np.ones(n), boxes, np.zeros((n, 4, 2)), anchors_px, heights_m, covs
    )
    return Tracks(np.arange(n), objects)


@given(cameras(), pixels(), st.floats(0.0, 0.3))
def test_placement_undoes_projection(camera, image, height_m):
    placed = place(camera, image, height_m)
    points = np.column_stack([placed.positions_m, np.full(len(image), height_m)])[placed.valid]
    back, _ = project(camera, points)
    assert np.abs(back - image[placed.valid]).max(initial=0.0) < 1e-7


def test_derivatives_by_pixel_and_parameters_agree_with_finite_differences():
    camera = overhead(tilt_rad=(0.05, -0.04, 0.3))
    image = np.array([[30.0, 20.0], [640.0, 360.0], [1250.0, 700.0]])
    placed = place(camera, image, 0.06)
    for axis, step in enumerate(1e-4 * np.eye(2)):
        ahead, _ = on_plane(camera, image + step, 0.06)
        behind, _ = on_plane(camera, image - step, 0.06)
        assert np.abs((ahead - behind)[:, :2] / 2e-4 - placed.by_pixel[..., axis]).max() < 1e-8
    for index, size in enumerate([1e-2] * 4 + [1e-5] * 5 + [1e-6] * 6):
        step = np.zeros(len(PARAMETERS))
        step[index] = size
        ahead, _ = on_plane(perturbed(camera, step), image, 0.06)
        behind, _ = on_plane(perturbed(camera, -step), image, 0.06)
        assert np.abs((ahead - behind)[:, :2] / (2 * size) - placed.by_parameters[..., index]).max() < 1e-6


def test_positions_drawn_from_the_stated_errors_lie_in_the_stated_ellipse():
    rng = np.random.default_rng(3)
    truth = overhead(tilt_rad=(0.03, -0.02, 0.1))
    points = np.column_stack([rng.uniform(-1.0, 1.0, 40), rng.uniform(-0.5, 0.5, 40), np.full(40, 0.06)])
    image, _ = project(truth, points)
    anchor_cov = np.array([[0.6, 0.2], [0.2, 0.4]])
    inside = []
    for _ in range(300):
        estimate = CalibratedCamera(perturbed(truth, SIGMAS * rng.standard_normal(15)), np.diag(SIGMAS**2))
        seen = image + rng.multivariate_normal(np.zeros(2), anchor_cov, size=len(image))
        ground = RayPlaneLocator({"west": estimate}).locate(
            tracks_at(seen, points[:, 2], np.tile(anchor_cov, (40, 1, 1)))
        )
        error = ground.positions_m - points[:, :2]
        inside.append(np.einsum("ni,nij,nj->n", error, np.linalg.inv(ground.covs_m2), error) < CHI2_90)
    assert abs(np.mean(inside) - 0.90) < 0.02


def test_a_known_camera_leaves_only_the_anchors_share():
    camera = overhead(distortion=(0.0,) * 5)
    ground = RayPlaneLocator({"west": CalibratedCamera(camera, np.zeros((15, 15)))}).locate(
        tracks_at(np.array([[642.3, 355.8]]), np.array([0.0]))
    )
    expected = np.diag([(2.8 / 1600) ** 2, (2.8 / 1601.6) ** 2])
    assert np.abs(ground.covs_m2[0] - expected).max() < 1e-12
    assert np.abs(ground.positions_m).max() < 1e-12


def test_the_horizon_and_above_is_invalid():
    level = overhead(tilt_rad=(1.4, 0.0, 0.0))  # looks north, slightly down: the sky is above
    ground = RayPlaneLocator({"west": CalibratedCamera(level, np.zeros((15, 15)))}).locate(
        tracks_at(np.array([[642.0, 10.0], [642.0, 700.0]]), np.zeros(2))
    )
    assert ground.valid.tolist() == [False, True]
    assert np.isnan(ground.positions_m[0]).all()
    assert np.isnan(ground.covs_m2[0]).all()
    assert np.isfinite(ground.covs_m2[1]).all()


def test_a_plane_above_the_camera_is_not_met_from_above():
    _, valid = on_plane(overhead(), np.array([[640.0, 360.0]]), 3.0)
    assert not valid.any()


def test_a_roof_taken_for_the_ground_is_off_by_similar_triangles():
    camera = CalibratedCamera(overhead(), np.zeros((15, 15)))
    image, _ = project(camera.camera, np.array([[1.0, 0.5, 0.06]]))
    seen = tracks_at(image, np.array([0.06]))
    exact = RayPlaneLocator({"west": camera}).locate(seen).positions_m
    naive = GroundPlaneLocator({"west": camera}).locate(seen).positions_m
    assert np.abs(exact - [[1.0, 0.5]]).max() < 1e-9
    assert np.abs(naive - np.array([[1.0, 0.5]]) * 2.8 / 2.74).max() < 1e-9


def test_no_tracks_give_no_places():
    locator = RayPlaneLocator({"west": CalibratedCamera(overhead(), np.zeros((15, 15)))})
    assert isinstance(locator, Locator)
    assert len(locator.locate(Tracks(np.empty(0), Detections.empty("west", 0, 0)))) == 0


def test_an_uncalibrated_camera_is_named():
    locator = RayPlaneLocator({"west": CalibratedCamera(overhead(), np.zeros((15, 15)))})
    with pytest.raises(InputError, match=r'"east".*calibrated are: west'):
        locator.locate(Tracks(np.empty(0), Detections.empty("east", 0, 0)))

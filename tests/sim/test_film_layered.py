"""The layered renderer against the full one, its oracle."""

import cv2
import numpy as np
import pytest
from film_cases import FLOOR_M, camera, state
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from contracts import InputError, SwitchState
from contracts.truth import Truth
from scenarios.plant_file import load_plant
from sim.box_faces import faces_of, nearness_in
from sim.box_rays import SAMPLES_PX, Box, boxes_of, rays_at, rays_through, seen, shaded
from sim.box_shadow import BoxShadow
from sim.full_renderer import FullRenderer
from sim.layered_renderer import LayeredRenderer
from sim.lens import Lens, pinhole_camera
from sim.lights import RAIL_LIGHTS, Beam, LightPreset
from sim.outlines import NEAR_M, covered, window_around
from sim.plant_scene import scene_of_plant
from sim.rig import CameraSpec, Departure, RigSpec, true_cameras
from sim.scene import Scene

COLOURS = ("red", "blue", "green", "magenta", "cyan")
STATES = 3
PLANT = load_plant("oval")
RIG = RigSpec((CameraSpec("eye", (640, 400), 1000.0, (-1.1, 0.1, 2.0)),), Departure(0.05, 2.0))


def setting():
    cameras = true_cameras(RIG, 4)
    pinholes = [pinhole_camera(camera, Lens.of(camera.intrinsics)) for camera in cameras]
    return scene_of_plant(PLANT, cameras, 4), pinholes


def random_state(rng: np.random.Generator) -> Truth:
    """Five vehicles anywhere in the view, some close enough to shade and hide each other, none inside another."""
    places: list[tuple[str, float, float, float]] = []
    while len(places) < len(COLOURS):
        x, y = rng.uniform([-1.75, -0.4], [-0.45, 0.6])
        if all(np.hypot(x - other[1], y - other[2]) > 0.14 for other in places):
            places.append((COLOURS[len(places)], x, y, rng.uniform(-180, 180)))
    drawn = state(*places, time_ns=int(rng.uniform(0, 12e9)))
    switches = {name: rng.choice([SwitchState.STRAIGHT, SwitchState.DIVERGING]) for name in PLANT.switches}
    return Truth(**{**vars(drawn), "switches": switches})


@pytest.mark.film
@pytest.mark.parametrize("preset", RAIL_LIGHTS)
def test_layered_pictures_are_the_full_ones_but_for_a_few_pixels_at_edges(preset):
    scene, pinholes = setting()
    full, layered = FullRenderer(scene, pinholes, preset), LayeredRenderer(scene, pinholes, preset)
    rng = np.random.default_rng(7)
    for _ in range(STATES):
        drawn = random_state(rng)
        oracle, fast = full.render(drawn, "eye"), layered.render(drawn, "eye")
        assert (oracle.instances != fast.instances).sum() <= 6
        differs = np.abs(oracle.image.astype(int) - fast.image).max(axis=2) > 2
        edges = differs & near_edges(oracle.instances)
        assert edges.sum() <= 0.12 * near_edges(oracle.instances, 1).sum()
        assert (differs & ~edges).sum() <= 0.004 * differs.size  # edges of shadows: the map of the full one has steps
        thick = cv2.erode(differs.astype(np.uint8), np.ones((4, 4)))
        assert not thick.any()  # nowhere more than an edge's width
        nothing_moves = ~cv2.dilate((oracle.image != fast.image).any(axis=2).astype(np.uint8), np.ones((3, 3))).any()
        assert fast.instances.any() or nothing_moves
    full.close()
    layered.close()


def near_edges(instances, reach=2):
    """Pixels within ``reach`` of another identity."""
    kernel = np.ones((2 * reach + 1, 2 * reach + 1))
    return cv2.dilate(instances, kernel) != cv2.erode(instances, kernel)


@pytest.mark.film
def test_what_stands_still_shades_vehicles_and_vehicles_shade_what_stands_still():
    eye = camera(position_m=(0.0, 0.0, 1.2), tilt_deg=20.0)
    pillar, wall = [-0.12, 0.14, 0.3, 0.05, 0.08, 0.25], [0.11, -0.06, 0.1, 0.3, 0.02, 0.12]
    scene = Scene(FLOOR_M, np.array([[1.95, 1.95, 0.0]]), clutter_m=np.array([pillar, wall]), seed=1)
    drawn = state(("red", 0.0, 0.05, 20.0), ("cyan", 0.14, 0.03, -10.0))
    full, layered = (make(scene, [eye], LightPreset.SUNNY) for make in (FullRenderer, LayeredRenderer))
    oracle, fast = full.render(drawn, "eye").image.astype(int), layered.render(drawn, "eye").image
    bare = LayeredRenderer(Scene(FLOOR_M, scene.control_points_m, seed=1), [eye], LightPreset.SUNNY)
    red = layered.render(drawn, "eye").instances == 1
    darker = np.abs(bare.render(drawn, "eye").image.astype(int) - fast).max(axis=2) > 20
    assert (darker & red).sum() > 300  # the pillar's shadow lies on the red vehicle
    wrong = (np.abs(oracle - fast).max(axis=2) > 8).astype(np.uint8)
    assert not cv2.erode(wrong, np.ones((5, 5))).any()  # nothing but edges differs
    for renderer in (full, layered, bare):
        renderer.close()


@pytest.mark.film
def test_a_layered_picture_depends_on_its_state_alone():
    scene, pinholes = setting()
    rng = np.random.default_rng(8)
    one, other, third = (random_state(rng) for _ in range(3))
    first, second = (LayeredRenderer(scene, pinholes, LightPreset.LAMPS) for _ in range(2))
    first.render(third, "eye")
    first.render(other, "eye")
    again, fresh = first.render(one, "eye"), second.render(one, "eye")
    assert (again.image == fresh.image).all()
    assert (again.instances == fresh.instances).all()
    with pytest.raises(InputError, match="eye"):
        first.render(one, "north")
    first.close()
    second.close()


CAMERA = setting()[1][0]
WINDOW = (slice(100, 160), slice(200, 300))


@given(st.floats(-1.6, -0.6), st.floats(-0.2, 0.4), st.floats(-3.2, 3.2), st.floats(0.02, 0.3))
def test_what_a_ray_sees_lies_on_the_surface_of_the_box(x, y, heading, length):
    turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1.0]])
    box = Box(np.array([x, y, 0.05]), np.array([length, 0.1, 0.05]), turn)
    rays = rays_through(CAMERA, WINDOW, box)
    depth, axis = seen(rays, box)
    hit = np.isfinite(depth)
    place = np.stack([a * np.where(hit, depth, 0) + o for a, o in zip(rays.direction, rays.origin, strict=True)])
    overshoot = np.abs(place) - box.half_m[:, None, None, None]
    assert overshoot[:, hit].max(initial=-1.0) < 1e-5
    on_face = np.abs(np.take_along_axis(overshoot, axis[None].astype(int), axis=0)[0])
    assert on_face[hit].max(initial=0.0) < 1e-5


@st.composite
def cameras_and_boxes(draw):
    """A camera that looks at any angle, and an upright box before, beside or around its plane."""
    tilt_deg, azimuth_deg = draw(st.floats(0.0, 85.0)), draw(st.floats(-180.0, 180.0))
    eye = camera(
        width_px=96, height_px=64, focal_px=draw(st.floats(40.0, 400.0)), tilt_deg=tilt_deg, azimuth_deg=azimuth_deg
    )
    x, y, heading = draw(st.floats(-1.5, 1.5)), draw(st.floats(-1.5, 1.5)), draw(st.floats(-3.2, 3.2))
    half = np.array([draw(st.floats(0.01, 0.6)) for _ in range(3)])
    turn = np.array([[np.cos(heading), -np.sin(heading), 0], [np.sin(heading), np.cos(heading), 0], [0, 0, 1.0]])
    return eye, Box(np.array([x, y, half[2]]), half, turn)


ALL_OF_IT = (slice(0, 64), slice(0, 96))


@settings(deadline=None, max_examples=60)
@given(cameras_and_boxes())
def test_outlines_of_faces_hold_the_samples_whose_rays_meet_the_box(case):
    eye, box = case
    inside = np.abs((eye.pose.position_m - box.centre_m) @ box.world_from_box) < box.half_m + 1e-3
    assume(not inside.all())
    depth, axis = seen(rays_through(eye, ALL_OF_IT, box), box)
    slow = np.where(np.isfinite(depth) & (depth > NEAR_M), axis + 1, 0)
    faces = faces_of(box, eye)
    fast = np.zeros_like(slow)
    for face_axis, face in zip(
        faces.axes, covered(faces.outlines_px, ALL_OF_IT, SAMPLES_PX) if faces.axes else [], strict=True
    ):
        fast[face] = face_axis + 1
    assert (fast != slow).sum() <= 3  # rays of single precision along an edge
    both = (fast == slow) & (slow > 0)
    if both.any():
        near = nearness_in(faces, ALL_OF_IT, SAMPLES_PX)
        terms = np.abs(faces.nearness * (96.0, 64.0, 1.0)).max()  # large where a face is seen edge-on, and cancelling
        per_metre = max(2e-5, 4 * terms * np.finfo(np.float32).eps)
        assert np.abs(1.0 / near[both] - depth[both]).max() < per_metre * depth[both].max() ** 2 + 1e-6
        rows, columns = window_around(eye, faces.points_px)
        held = np.zeros_like(both)
        held[:, rows, columns] = True
        assert held[both].all()


@settings(deadline=None, max_examples=60)
@given(cameras_and_boxes(), st.floats(0.3, 1.5), st.floats(-3.2, 3.2), st.floats(0.0, 0.3))
def test_a_shadows_outlines_hold_what_may_and_what_must_be_shaded(case, elevation, azimuth, height_m):
    eye, box = case
    shadow = BoxShadow(box, Beam(azimuth, elevation, (1.0, 1.0, 1.0)), eye)
    u, v = np.meshgrid(np.arange(96.0), np.arange(64.0))
    x, y = (u - eye.intrinsics.cx_px) / eye.intrinsics.fx_px, (v - eye.intrinsics.cy_px) / eye.intrinsics.fy_px
    climb = np.stack([x, y, np.ones_like(x)], axis=-1) @ eye.pose.world_from_camera[2]
    assume((climb < 0).any())
    depth = np.where(climb < 0, (height_m - eye.pose.position_m[2]) / np.minimum(climb, -1e-9), 1e6)
    dark = shaded(rays_at(eye, u, v, box), depth.astype(np.float32), box, shadow.beam) & (depth < 20.0)
    middle = np.zeros((1, 2))
    if height_m < 2.0 * box.half_m[2]:
        assert not (dark & ~covered([shadow.outline_px()], ALL_OF_IT, middle)[0, 0]).any()
    sure = shadow.sure_px(height_m)
    if sure:
        certain = covered(sure, ALL_OF_IT, middle).all(axis=0)[0] & (depth < 20.0)
        assert not (certain & ~dark).any()


@given(st.floats(0.3, 1.5), st.floats(-3.2, 3.2))
def test_the_shadow_on_the_ground_ends_where_the_roofs_edge_throws_it(elevation, azimuth):
    box = boxes_of(state(("red", 0.0, 0.0, 0.0)))[0]
    beam = Beam(azimuth, elevation, (1.0, 1.0, 1.0))
    rays = rays_through(CAMERA, WINDOW, box, SAMPLES_PX[:1])
    x, y = np.meshgrid(np.linspace(-0.4, 0.4, 100), np.linspace(-0.3, 0.3, 60))
    ground = np.stack([x, y, np.full_like(x, -0.03)])[:, None].astype(np.float32)  # box axes: z = 0 is its middle
    fake = type(rays)(tuple(ground), np.zeros(3))
    dark = shaded(fake, np.ones((1, 60, 100), np.float32), box, beam)[0]
    travel = 0.06 / np.tan(elevation) * np.array([-np.cos(azimuth), -np.sin(azimuth)])
    roof = np.array([[-0.06, -0.03], [0.06, -0.03], [0.06, 0.03], [-0.06, 0.03]])
    hull = cv2.convexHull(np.concatenate([roof, roof + travel]).astype(np.float32))
    for v, u in np.argwhere(np.ones_like(dark)):
        gap = cv2.pointPolygonTest(hull, (float(x[v, u]), float(y[v, u])), True)
        if abs(gap) > 2.5e-3:  # a millimetre of the box lets light through
            assert dark[v, u] == (gap > 0)

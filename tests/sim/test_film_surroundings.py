"""Objects and bridges on film: both renderers draw them alike, and the truth knows what they hide."""

import cv2
import numpy as np
import pytest
from film_cases import FLOOR_M, camera, state

from sim.camera_truth import camera_truth
from sim.full_renderer import FullRenderer
from sim.layered_renderer import LayeredRenderer
from sim.light_program import LightChange, LightProgram
from sim.lights import LightPreset
from sim.projection import project
from sim.scene import Scene
from sim.surroundings import BridgeSpec, ObjectSpec, Surroundings

BRIDGE = BridgeSpec((0.0, 0.0), 90.0, span_m=0.16, width_m=0.10)
BOX = ObjectSpec((-0.22, 0.22), (0.16, 0.10, 0.20), (180, 40, 30), heading_deg=25.0)
CUP = ObjectSpec((0.22, 0.14), (0.08, 0.08, 0.12), (30, 140, 150), shape="cylinder")
SHEET = ObjectSpec((0.18, -0.25), (0.21, 0.15, 0.001), (100, 140, 210), heading_deg=-15.0)
THINGS = Surroundings(objects=(BOX, CUP, SHEET), bridges=(BRIDGE,)).things
SCENE = Scene(FLOOR_M, np.array([[1.95, 1.95, 0.0]]), things=THINGS)
VIEW = camera(width_px=480, height_px=360, focal_px=600.0, position_m=(0.0, 0.0, 1.4), tilt_deg=2.0, azimuth_deg=90.0)
PROGRAM = LightProgram(LightPreset.SUNNY, (LightChange(1.0, LightPreset.LAMPS, 2.0),))
SCENES = [
    state(("blue", 0.07, 0.0, 0.0), ("red", -0.14, 0.09, 10.0), time_ns=0),  # half beneath; in the box's shadow
    state(("blue", -0.02, 0.01, 2.0), ("red", 0.26, 0.06, 80.0), time_ns=2_000_000_000),  # beneath; by the cup
]


@pytest.mark.film
def test_both_renderers_draw_objects_bridges_and_their_shadows_on_vehicles_alike():
    full, layered = FullRenderer(SCENE, [VIEW], PROGRAM), LayeredRenderer(SCENE, [VIEW], PROGRAM)
    for drawn in SCENES:
        oracle, fast = full.render(drawn, "eye"), layered.render(drawn, "eye")
        assert (oracle.instances != fast.instances).sum() <= 6
        differs = np.abs(oracle.image.astype(int) - fast.image).max(axis=2) > 3
        assert differs.mean() < 0.006
        assert not cv2.erode(differs.astype(np.uint8), np.ones((4, 4))).any()  # nowhere more than an edge's width
    full.close()
    layered.close()


@pytest.mark.film
def test_a_bridge_hides_what_opencv_says_and_changes_nothing_else_of_the_truth():
    bare = Scene(FLOOR_M, np.array([[1.95, 1.95, 0.0]]))
    renderers = [LayeredRenderer(scene, [VIEW], LightPreset.CLOUDY) for scene in (SCENE, bare)]
    hidden, free = (camera_truth(VIEW, SCENES[0], renderer.render(SCENES[0], "eye")) for renderer in renderers)
    pictures = [renderer.render(SCENES[0], "eye") for renderer in renderers]
    deck = THINGS[3].solid
    top, _ = project(VIEW, deck.corners_m)
    cover = np.zeros((360, 480), np.uint8)
    cv2.fillConvexPoly(cover, cv2.convexHull(np.rint(top).astype(np.int32)), 1)
    mine = pictures[1].instances == 1
    expected = (mine & (cover == 0)).sum() / mine.sum()
    assert 0.2 < expected < 0.9
    assert abs(hidden.visible_fractions[0] - expected * free.visible_fractions[0]) < 0.03
    assert (hidden.visible_fractions <= free.visible_fractions).all()
    for name in ("full_boxes_px", "footprints_px", "roofs_px"):
        assert (getattr(hidden, name) == getattr(free, name)).all()
    for renderer in renderers:
        renderer.close()


@pytest.mark.film
def test_an_object_is_drawn_where_opencv_projects_its_top():
    renderer = LayeredRenderer(SCENE, [VIEW], LightPreset.CLOUDY)
    image = renderer.render(state(), "eye").image
    renderer.close()
    for thing in (BOX, CUP, SHEET):
        solid = thing.solid
        pixels, _ = project(VIEW, np.column_stack([solid.outline_m, np.full(len(solid.outline_m), solid.top_m)]))
        (u, v), _ = project(VIEW, np.array([*thing.at_m, solid.top_m]))
        colour = image[round(v), round(u)].astype(int)
        share = colour / np.array(thing.srgb[::-1])
        assert np.ptp(share) < 0.12  # the object's own colour, in almost white light
        same = (np.abs(image.astype(int) - colour).max(axis=2) <= 2).astype(np.uint8)
        area = cv2.contourArea(pixels.astype(np.float32))
        left, top = np.floor(pixels.min(axis=0)).astype(int) - 2
        right, bottom = np.ceil(pixels.max(axis=0)).astype(int) + 3
        seen = same[max(top, 0) : bottom, max(left, 0) : right].sum()
        assert abs(seen - area) < 0.6 * cv2.arcLength(pixels.astype(np.float32), True)  # about half a pixel all round

"""The road's film: layered as drawn anew, true to its boxes, and honest about what hides what."""

from dataclasses import replace

import numpy as np
import pytest
from road_film_cases import BUSY, crossroads, pole_camera, users

from contracts import InputError
from sim.body_shapes import Wardrobe
from sim.film import CameraFilm
from sim.lens import Lens, pinhole_camera
from sim.lights import LightPreset
from sim.projection import project
from sim.renderer import Rendered, RendererName, Still
from sim.road_truth import BORDER, occlusions, road_camera_truth
from sim.sensor import SensorSpec

CAMERA = pole_camera()
CLEAN = SensorSpec(noise=0.0, defocus_px=0.0, exposure_ms=0.0)


def renderers(light):
    return [crossroads(CAMERA, light, name=name).renderer([CAMERA]) for name in RendererName]


@pytest.mark.film
@pytest.mark.parametrize("light", [LightPreset.SUNNY, LightPreset.CLOUDY])
def test_the_layered_film_shows_what_a_drawing_of_everything_shows(light):
    layered, full = renderers(light)
    ours, oracle = (renderer.render(BUSY, "pole") for renderer in (layered, full))
    layered.close()
    full.close()
    apart = np.abs(ours.image.astype(int) - oracle.image).max(axis=2)
    assert (ours.instances != oracle.instances).mean() < 2e-4
    assert (apart > 4).mean() < (0.015 if light is LightPreset.SUNNY else 0.002)  # a shadow map frays its edges
    assert set(np.unique(ours.instances)) == set(range(1 + len(BUSY.ids)))


@pytest.mark.film
def test_outside_of_its_windows_a_picture_is_the_empty_road():
    renderer = crossroads(CAMERA).renderer([CAMERA])
    busy, empty = (renderer.render(state, "pole") for state in (BUSY, users()))
    renderer.close()
    assert not empty.windows
    assert not empty.instances.any()
    assert (empty.image == busy.still).all()
    differs = (busy.image != busy.still).any(axis=2)
    for window in busy.windows:
        differs[window] = False
    assert not differs.any()


@pytest.mark.film
def test_silhouettes_fill_the_box_of_the_truth_through_the_lens():
    camera = pole_camera(distortion=(-0.10, 0.03, 0.0004, -0.0003, 0.0))
    lens = Lens.of(camera.intrinsics)
    studio = crossroads(camera, LightPreset.CLOUDY)
    renderer = studio.renderer([pinhole_camera(camera, lens)])
    alone = users(("saloon", 0.0, 0.0, 30.0), ("city_bus", -4.0, 9.0, 90.0), ("adult", -6.0, -7.0, 0.0))
    _, truth = CameraFilm(camera, lens, renderer, CLEAN, noise_seed=1, view=studio.view).shoot(alone)
    renderer.close()
    assert (truth.visible_fractions > 0.97).all()
    assert np.abs(truth.visible_boxes_px - truth.full_boxes_px).max() < 1.6  # a pixel, and half of one at its edge
    length, width, _ = alone.sizes_m[1]  # the bus looks north: its right is east
    rear_right = alone.positions_m[1] + (width / 2, -length / 2, 0.0)
    assert np.allclose(truth.footprint_corners_px[1, 0], project(camera, rear_right)[0], atol=1e-9, rtol=0)


@pytest.mark.film
def test_the_truth_names_what_hides_a_user():
    studio = crossroads(CAMERA, LightPreset.CLOUDY)
    renderer = studio.renderer([CAMERA])
    queue = users(("city_bus", 2.0, 2.0, 135.0), ("adult", 4.0, 4.0, 0.0), ("saloon", 60.0, -14.0, 0.0))
    seen = renderer.render(queue, "pole")
    renderer.close()
    truth = road_camera_truth(CAMERA, queue, seen, Wardrobe(studio.seed))
    bus, walker, _ = truth.hidden_by
    assert sum(one.fraction for one in bus) < 0.01  # the tip of a lamp's pole
    assert walker[0].by == "city_bus/0"
    assert walker[0].fraction + truth.visible_fractions[1] == pytest.approx(1.0, abs=0.1)


def test_shares_of_a_hidden_object_add_up_by_hand():
    instances = np.zeros((4, 8), np.uint8)
    instances[1, 2:4], instances[2, 2] = 1, 2
    things = Still(np.zeros((4, 8), np.uint8), ("ground", "tree"), frozenset({"tree"}))
    things.kinds[2, 3:] = 2
    things.kinds[3] = 1
    seen = Rendered(np.zeros((4, 8, 3), np.uint8), instances, things=things)
    alone = np.ones((5, 2), bool)  # columns 2 and 3, rows 0 to 4: one row below the image
    found = {one.by: one.fraction for one in occlusions(alone, (2, 0), 0, ("me", "you"), seen)}
    assert found == {BORDER: 0.2, "you": 0.1, "tree": 0.1}


def test_whoever_is_behind_the_camera_has_no_box():
    behind = users(("saloon", -30.0, -30.0, 0.0))
    seen = Rendered(np.zeros((270, 480, 3), np.uint8), np.zeros((270, 480), np.uint8))
    truth = road_camera_truth(CAMERA, behind, seen, Wardrobe(1))
    assert np.isnan(truth.full_boxes_px).all()
    assert truth.visible_fractions[0] == 0.0
    assert truth.hidden_by == ((),)


@pytest.mark.film
def test_paint_is_where_opencv_projects_the_map():
    studio = crossroads(CAMERA, LightPreset.CLOUDY)
    renderer = studio.renderer([CAMERA])
    image = renderer.render(users(), "pole").image.astype(float).mean(axis=2)
    renderer.close()
    # the southern crosswalk's bars end where the map says: along a row of bars, bright and dark change places
    edges = crosswalk_bar_corners()
    pixels, valid = project(CAMERA, edges)
    inner = valid & (pixels > 3).all(axis=-1) & (pixels < (476, 266)).all(axis=-1)
    assert inner.any()
    for u, v in pixels[inner].reshape(-1, 2):
        around = image[int(v) - 2 : int(v) + 4, int(u) - 2 : int(u) + 4]
        assert around.max() - around.min() > 40  # a corner of white on dark


def crosswalk_bar_corners():
    from georef.hd_map import AreaKind
    from scenarios.network_file import load_network
    from sim.road_map import map_of_network
    from sim.road_surface import crosswalk_bars

    areas = map_of_network(load_network("crossroads")).painted_areas
    bars = [bar for area in areas if area.kind is AreaKind.CROSSWALK for bar in crosswalk_bars(area)]
    corners = np.array([bar.exterior.coords[:4] for bar in bars])
    flat = np.concatenate([corners, np.zeros((*corners.shape[:2], 1))], axis=-1)
    near = np.linalg.norm(flat[..., :2] - CAMERA.pose.position_m[:2], axis=-1) < 22.0
    return flat[near]


def test_an_unknown_camera_is_refused():
    renderer = crossroads(CAMERA).renderer([CAMERA])
    with pytest.raises(InputError, match="camera nobody is not in this renderer"):
        renderer.render(replace(BUSY), "nobody")
    renderer.close()

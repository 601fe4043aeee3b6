"""The road's film at night and in bad weather: as drawn anew, with lamps and mirror images where they belong."""

import numpy as np
import pytest
from road_film_cases import BUSY, crossroads, pole_camera, users

from sim.air import Air, Weather
from sim.body_shapes import Wardrobe
from sim.glow import added, street_spots
from sim.lights import LightPreset, light_at
from sim.mirror import Mirror
from sim.projection import project
from sim.renderer import RendererName
from sim.road_stage import RoadStage
from sim.sight import Sight

CAMERA = pole_camera(320, 180)
NIGHT = light_at(LightPreset.NIGHT, 0)


def picture(light, weather, state=BUSY, name=RendererName.LAYERED):
    renderer = crossroads(CAMERA, light, weather, name).renderer([CAMERA])
    rendered = renderer.render(state, "pole")
    renderer.close()
    return rendered


@pytest.fixture(scope="module")
def still():
    """The empty crossroads as the camera sees it, and its lamps."""
    scene = crossroads(CAMERA).scene
    stage = RoadStage(scene, (320, 180), Wardrobe(1))
    sight = Sight.of(CAMERA, stage)
    stage.close()
    return sight, scene.lamps_m


@pytest.mark.film
@pytest.mark.parametrize(
    ("light", "weather"),
    [
        (LightPreset.NIGHT, Weather.DRY),
        (LightPreset.NIGHT, Weather.RAIN),
        (LightPreset.DUSK, Weather.FOG),
        (LightPreset.CLOUDY, Weather.WET),
        (LightPreset.SUNNY, Weather.WET),
    ],
)
def test_the_layered_film_shows_what_a_drawing_of_everything_shows(light, weather):
    ours, oracle = (picture(light, weather, name=name) for name in RendererName)
    apart = np.abs(ours.image.astype(int) - oracle.image).max(axis=2)
    assert (ours.instances != oracle.instances).mean() < 3e-4
    assert (apart > 4).mean() < (0.015 if light is LightPreset.SUNNY else 0.003)  # a shadow map frays its edges
    assert np.abs(ours.image.astype(float) - oracle.image).mean() < (0.4 if light is LightPreset.SUNNY else 0.2)


@pytest.mark.film
def test_weather_changes_no_truth():
    dry, wet = (picture(LightPreset.NIGHT, weather) for weather in (Weather.DRY, Weather.RAIN))
    assert (dry.instances == wet.instances).all()
    assert (dry.things.kinds == wet.things.kinds).all()
    assert (dry.image != wet.image).any()


@pytest.mark.film
def test_at_night_the_ground_below_a_lamp_is_brighter_than_between_lamps(still):
    sight, lamps_m = still
    image = picture(LightPreset.NIGHT, Weather.DRY, users()).image.astype(float).mean(axis=2)
    away_m = np.linalg.norm(sight.points_m[..., None, :2] - lamps_m[:, :2].astype(np.float32), axis=3).min(axis=2)
    # one kind of surface at a time, and none of it near the windows' and lamps' own light
    grass = (sight.kinds == 1) & (sight.range_m < 60.0)
    below, between = grass & (away_m < 4.0), grass & (away_m > 11.0)
    assert below.sum() > 20
    assert between.sum() > 20
    assert image[below].mean() > 2.0 * image[between].mean()


@pytest.mark.film
def test_a_lamp_is_mirrored_where_its_mirror_image_would_be_seen(still):
    sight, lamps_m = still
    mirror = Mirror(sight, Weather.WET, 1)
    nothing_m = np.full((mirror.camera.intrinsics.height_px, mirror.camera.intrinsics.width_px), 600.0, np.float32)
    spots = list(street_spots(mirror.camera, lamps_m[:12], nothing_m, Air.of(Weather.WET, NIGHT)))
    flat = mirror.in_place(added(spots, (*nothing_m.shape, 3)))[..., 2]
    pixels, valid = project(CAMERA, lamps_m[:12] * (1, 1, -1))
    inside = valid & (pixels > 8).all(axis=1) & (pixels < (312, 172)).all(axis=1)
    assert inside.any()
    for u, v in pixels[inside]:
        left, top = int(u) - 5, int(v) - 5
        row, column = np.unravel_index(flat[top : top + 11, left : left + 11].argmax(), (11, 11))
        assert np.hypot(left + column - u, top + row - v) < 1.5  # half of the pixels: one of them, and half a one

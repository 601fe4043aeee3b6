"""The rail world as a whole: steps, determinism, and that what should not matter does not."""

import multiprocessing
import subprocess
import sys

import numpy as np
import pytest
from film_cases import state

from contracts import InputError, Intrinsics
from scenarios.plant_file import load_plant
from sim.film import CameraFilm, advanced
from sim.filmed_world import Filming
from sim.lens import Lens
from sim.lights import RAIL_LIGHTS, ROAD_LIGHTS
from sim.rail_world import RailWorld
from sim.renderer import Rendered
from sim.rig import CameraSpec, RigSpec
from sim.sensor import SensorSpec

LENS = (-0.1, 0.04, 0.0005, -0.0004, 0.0)
RIG = RigSpec(
    (
        CameraSpec("west", (320, 240), 400.0, (-0.35, 0.0, 1.4), distortion=LENS),
        CameraSpec("east", (320, 240), 400.0, (0.35, 0.0, 1.4), distortion=LENS),
    )
)
NO_LENS = Lens.of(Intrinsics(320, 240, 400.0, 400.0, 160.0, 120.0, np.zeros(5)))
TIMES_NS = (0, 40_000_000, 80_000_000)


class Straight:
    """Two vehicles pass each other."""

    def run(self, times_ns):
        for index, time_ns in enumerate(times_ns):
            x = 0.4 * time_ns * 1e-9
            yield state(("red", x - 0.3, 0.1, 0.0), ("blue", 0.3 - x, -0.1, 180.0), time_ns=time_ns, index=index)


def world(**changes) -> RailWorld:
    light = changes.pop("light", "sunny")
    return RailWorld(load_plant("oval"), Straight(), TIMES_NS, Filming(RIG, **{"seed": 3, **changes}), light=light)


def images(filmed: RailWorld) -> list[np.ndarray]:
    return [frame.image for step in filmed.steps() for frame in step.frames]


@pytest.mark.film
def test_frames_are_the_same_again_and_shared_among_processes_and_the_noise_changes_nothing_else():
    here, team, noisier = (list(world(**c).steps()) for c in ({}, {"workers": 2}, {"noise_seed": 9}))
    assert len(here) == len(TIMES_NS)
    for one, other, noisy in zip(here, team, noisier, strict=True):
        assert [frame.camera for frame in one.frames] == ["west", "east"]
        for a, b, c in zip(one.frames, other.frames, noisy.frames, strict=True):
            assert (a.camera, a.index, a.time_ns) == (b.camera, b.index, b.time_ns)
            assert (a.image == b.image).all()
            assert (a.image != c.image).mean() > 0.3
        for a, b, c in zip(one.truth.cameras, other.truth.cameras, noisy.truth.cameras, strict=True):
            for field in ("visible_fractions", "full_boxes_px", "visible_boxes_px", "footprints_px", "instances"):
                assert np.array_equal(getattr(a, field), getattr(b, field), equal_nan=True)
                assert np.array_equal(getattr(a, field), getattr(c, field), equal_nan=True)
    assert max(view.visible_fractions.max() for view in here[0].truth.cameras) > 0.99


def test_a_film_that_nobody_watches_ends_its_processes():
    steps = world(workers=2).steps()
    assert len(multiprocessing.active_children()) == 2
    del steps
    assert not multiprocessing.active_children()


def test_a_world_without_film_gives_the_truth_and_loads_no_graphics():
    steps = list(world(film=False).steps())
    assert [step.truth.time_ns for step in steps] == list(TIMES_NS)
    assert all(step.frames == () and step.truth.cameras == () for step in steps)
    code = "import sim.rail_world, sys; sys.exit(any(m.split('.')[0] in ('mujoco', 'OpenGL') for m in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_the_survey_knows_the_nominal_cameras_only():
    filmed = world()
    for nominal, true in zip(filmed.survey.cameras, filmed.cameras, strict=True):
        assert nominal.name == true.name
        assert not nominal.intrinsics.distortion.any()
        assert np.abs(nominal.pose.position_m - true.pose.position_m).max() > 1e-3


def test_no_control_point_lies_under_the_track():
    filmed = world()
    track = np.concatenate([s.curve.points(0.01) for s in load_plant("oval").sections.values()])
    gaps = [np.hypot(*(track - mark[:2]).T).min() for mark in filmed.survey.control_points_m]
    assert min(gaps) > 0.05
    assert len(gaps) > 40


@pytest.mark.parametrize("light", ["noon", ""])
def test_an_unknown_light_is_refused_with_the_known_ones(light):
    with pytest.raises(InputError, match="sunny, cloudy"):
        world(light=light)


def test_an_unknown_camera_has_no_board_views():
    with pytest.raises(InputError, match="west, east"):
        list(world().board_views("north"))


class Painter:
    """A renderer that paints one column, where the only vehicle is: 1000 px per metre."""

    def __init__(self) -> None:
        self.times_ns: list[int] = []

    def render(self, drawn, camera):
        self.times_ns.append(drawn.time_ns)
        image = np.zeros((240, 320, 3), np.uint8)
        image[:, round(160 + 1000 * drawn.positions_m[0, 0])] = 250
        return Rendered(image, image[..., 0] // 250)

    def close(self):
        pass


def test_motion_blur_averages_moments_around_mid_exposure_and_keeps_the_middle_for_the_truth():
    view = world().cameras[0]
    painter = Painter()
    lens = NO_LENS
    sensor = SensorSpec(noise=0.0, defocus_px=0.0, exposure_ms=40.0)
    here = state(("red", 0.1, 0.0, 0.0), time_ns=10**9, speed_mps=0.25)
    frame, truth = CameraFilm(view, lens, painter, sensor, noise_seed=0).shoot(here)
    offsets = np.array(sorted(painter.times_ns)) - 10**9
    assert len(offsets) % 2 == 1
    assert len(offsets) >= 3
    assert offsets.sum() == 0
    assert offsets.max() < 20_000_000
    assert truth.time_ns == frame.time_ns == 10**9
    assert set(np.flatnonzero(truth.instances.any(axis=0))) == {260}
    assert np.count_nonzero(frame.image[0, :, 0]) >= 3


def test_what_stands_still_is_drawn_once_however_long_the_exposure():
    painter = Painter()
    view = world().cameras[0]
    film = CameraFilm(
        view,
        NO_LENS,
        painter,
        SensorSpec(exposure_ms=100.0),
        noise_seed=0,
    )
    film.shoot(state(("red", 0.1, 0.0, 0.0)))
    assert len(painter.times_ns) == 1


def test_a_state_moves_on_along_its_velocity():
    moved = advanced(state(("red", 0.1, 0.2, 90.0), speed_mps=0.5), 0.1)
    assert np.abs(moved.positions_m - [[0.1, 0.25, 0.0]]).max() < 1e-12
    assert moved.time_ns == 100_000_000


def test_every_light_has_its_name():
    assert {str(light) for light in RAIL_LIGHTS} == {"sunny", "cloudy", "lamps", "dusk", "moving_shadow", "flicker"}
    assert {str(light) for light in ROAD_LIGHTS} == {"sunny", "cloudy", "dusk", "night"}


class Keeper:
    """A renderer that keeps a still and lays noisy patches on it; ``tells`` whether it says so."""

    def __init__(self, *, tells: bool) -> None:
        self.still = np.random.default_rng(1).integers(0, 256, (320, 420, 3), dtype=np.uint8)
        self.tells = tells

    def render(self, drawn, camera):
        rng = np.random.default_rng(drawn.time_ns)
        image, instances = self.still.copy(), np.zeros(self.still.shape[:2], np.uint8)
        windows = []
        for row in range(6):
            top, left = rng.integers(0, 300), rng.integers(0, 400)
            window = slice(top, min(320, top + 30)), slice(left, min(420, left + 50))
            image[window] = rng.integers(0, 256, image[window].shape, dtype=np.uint8)
            instances[window] = row + 1
            windows.append(window)
        return Rendered(image, instances, self.still if self.tells else None, tuple(windows) if self.tells else ())

    def close(self):
        pass


@pytest.mark.parametrize("speed_mps", [0.0, 0.8])
def test_developing_only_what_changed_gives_the_very_same_frames(speed_mps):
    view = world().cameras[0]
    lens = Lens.of(view.intrinsics)
    assert lens.pinhole.width_px <= 420
    assert lens.pinhole.height_px <= 320
    sensor = SensorSpec(defocus_px=0.8, exposure_ms=20.0)
    films = [CameraFilm(view, lens, Keeper(tells=tells), sensor, noise_seed=0) for tells in (True, False)]
    for k in range(5):
        here = state(("red", 0.1, 0.0, 0.0), time_ns=(k + 1) * 10**9, index=k, speed_mps=speed_mps)
        (fast, fast_truth), (slow, slow_truth) = (film.shoot(here) for film in films)
        assert (fast.image == slow.image).all()
        assert np.array_equal(fast_truth.instances, slow_truth.instances)

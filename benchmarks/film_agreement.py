"""Does the layered film show what the full one shows? Both on the same random states, under every light, at both sizes.

``python -m benchmarks.film_agreement [--states 204 --worst 0 --json]``; ``--worst N`` names the N positions that differ
most, each with its state.

Pictures are compared before lens and sensor, class of pixel by class: *edge* within two pixels of another vehicle, face
or the ground; *shadow* within two pixels of ground that a vehicle changes in either film; *rest* is everything else.
Positions are those of the bench's own detector, through lens and sensor, with the same noise, and located with the true
cameras.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from bench.oracles import true_camera
from bench.scores import Score
from bench.wiring import Stages
from benchmarks.command import show
from benchmarks.film_states import SEED, SIZES, random_state, setting
from contracts import BoolArray, Camera, FloatArray, ImageArray
from contracts.truth import Truth
from georef.location import RayPlaneLocator
from sim.box_faces import faces_of
from sim.box_rays import SAMPLES_PX, boxes_of, rays_through, seen
from sim.film import CameraFilm
from sim.full_renderer import FullRenderer
from sim.layered_renderer import LayeredRenderer
from sim.lens import Lens, pinhole_camera
from sim.lights import RAIL_LIGHTS, LightPreset
from sim.outlines import window_around
from sim.renderer import Rendered, Renderer

STATES = 204
VEHICLES = 8  # one of each colour: the detector looks for one of each
COLOUR_LEVELS = 2
CLASSES = ("edge", "shadow", "rest")
_REACH = np.ones((5, 5), np.uint8)


@dataclass(frozen=True, eq=False)
class Difference:
    """What differs in one picture: identities in pixels; by class, how many pixels there are and how many differ."""

    identities: int
    pixels: dict[str, int]
    differing: dict[str, int]


@dataclass(frozen=True)
class Shift:
    """One vehicle's two positions; distance_m is infinite where the detector found it in one film only."""

    size: str
    light: LightPreset
    number: int
    camera: str
    label: str
    distance_m: float


class Remembering:
    """A renderer that remembers what it drew at mid-exposure, which is the first picture of a frame."""

    def __init__(self, renderer: Renderer) -> None:
        self._renderer = renderer
        self.pictures: list[Rendered] = []

    def render(self, state: Truth, camera: str) -> Rendered:
        self.pictures.append(self._renderer.render(state, camera))
        return self.pictures[-1]

    def close(self) -> None:
        self._renderer.close()


class Film:
    """One renderer, and what the detector makes of its frames."""

    def __init__(self, renderer: Renderer, size: str) -> None:
        rig, cameras, _ = setting(size)
        self.renderer = Remembering(renderer)
        self._cameras = {camera.name: camera for camera in cameras}
        self._films = {
            camera.name: CameraFilm(
                camera, Lens.of(camera.intrinsics), self.renderer, rig.sensor, noise_seed=SEED, keep_instances=False
            )
            for camera in cameras
        }
        self._locator = RayPlaneLocator({camera.name: true_camera(camera) for camera in cameras})

    def shoot(self, state: Truth, camera: str) -> tuple[Rendered, dict[str, FloatArray]]:
        """The clean picture; positions (2,) by label."""
        self.renderer.pictures.clear()
        frame, _ = self._films[camera].shoot(state)
        perceiver = Stages().make_perceiver(self._cameras[camera])
        found = self._locator.locate(perceiver.perceive(frame))
        return self.renderer.pictures[0], dict(zip(found.labels, found.positions_m, strict=True))


def compare(count: int) -> tuple[list[Difference], list[Shift]]:
    """``count`` states, dealt out to sizes and lights in turn; each is filmed by every camera of its rig."""
    differences: list[Difference] = []
    shifts: list[Shift] = []
    kinds = [(size, light) for size in SIZES for light in RAIL_LIGHTS]
    for first, (size, light) in enumerate(kinds):
        for difference, shift in compare_under(size, light, range(first, count, len(kinds))):
            differences.append(difference)
            shifts += shift
    return differences, shifts


def compare_under(size: str, light: LightPreset, numbers: range) -> Iterator[tuple[Difference, list[Shift]]]:
    """The states of these numbers under one light."""
    _, cameras, scene = setting(size)
    pinholes = [pinhole_camera(camera, Lens.of(camera.intrinsics)) for camera in cameras]
    full, layered = (Film(make(scene, pinholes, light), size) for make in (FullRenderer, LayeredRenderer))
    for number in numbers:
        state = state_of(number)
        for pinhole in pinholes:
            picture, places = full.shoot(state, pinhole.name)
            fast, fast_places = layered.shoot(state, pinhole.name)
            empty = layered.renderer.render(_without_vehicles(state), pinhole.name)
            yield (
                difference_of(picture, fast, empty.image, faces(state, pinhole)),
                [
                    Shift(
                        size, light, number, pinhole.name, label, _distance(places.get(label), fast_places.get(label))
                    )
                    for label in sorted(places.keys() | fast_places.keys())
                ],
            )
    full.renderer.close()
    layered.renderer.close()


def state_of(number: int) -> Truth:
    return random_state(np.random.default_rng(number), VEHICLES, index=number)


def faces(state: Truth, pinhole: Camera) -> ImageArray:
    """(H, W) which face of a box each pixel's centre shows, were nothing in front of it; 0 for none."""
    numbers = pinhole.intrinsics
    shown = np.zeros((numbers.height_px, numbers.width_px), np.uint8)
    nearest = np.full(shown.shape, np.inf, np.float32)
    for row, box in enumerate(boxes_of(state)):
        if (window := window_around(pinhole, faces_of(box, pinhole).points_px)) is not None:
            depth, axis = (each[0] for each in seen(rays_through(pinhole, window, box, SAMPLES_PX[:1]), box))
            np.copyto(shown[window], axis + np.uint8(1 + 3 * row), where=depth < nearest[window])
            np.minimum(nearest[window], depth, out=nearest[window])
    return shown


def difference_of(full: Rendered, layered: Rendered, empty: ImageArray, shown: ImageArray) -> Difference:
    """Compare two clean pictures; ``empty`` is the scene without vehicles, ``shown`` from ``faces``."""
    differs = _apart(full.image, layered.image)
    edge = _changes(shown) | _changes(full.instances) | _changes(layered.instances)
    ground = (full.instances == 0) & (layered.instances == 0)
    changed = (_apart(full.image, empty) | _apart(layered.image, empty)) & ground
    shadow = cv2.dilate(changed.view(np.uint8), _REACH).astype(bool) & ground & ~edge
    masks = dict(zip(CLASSES, (edge, shadow, ~edge & ~shadow), strict=True))
    return Difference(
        int((full.instances != layered.instances).sum()),
        {name: int(mask.sum()) for name, mask in masks.items()},
        {name: int((mask & differs).sum()) for name, mask in masks.items()},
    )


def scores_of(differences: list[Difference], shifts: list[Shift]) -> list[Score]:
    pictures = len(differences)
    identities = np.array([difference.identities for difference in differences])
    scores = [
        Score.of("film_agreement.identity_max_px", identities.max(initial=0), "px", pictures),
        Score.of("film_agreement.identity_mean_px", identities.mean() if pictures else np.nan, "px", pictures),
    ]
    everything = sum(sum(difference.pixels.values()) for difference in differences)
    for name in CLASSES:
        pixels, differing = (sum(each[name] for each in counts) for counts in _counts(differences))
        scores += [
            Score.of(f"film_agreement.{name}_differing", differing / max(pixels, 1), "1", pixels),
            Score.of(f"film_agreement.{name}_differing_of_image", differing / max(everything, 1), "1", everything),
        ]
    return scores + _shift_scores(shifts)


def _shift_scores(shifts: list[Shift]) -> list[Score]:
    found = np.array([shift.distance_m for shift in shifts if np.isfinite(shift.distance_m)])
    single = len(shifts) - len(found)
    if not found.size:
        found = np.array([np.nan])
    return [
        Score.of("film_agreement.position_rms_m", float(np.sqrt(np.mean(found**2))), "m", len(found)),
        Score.of("film_agreement.position_median_m", float(np.median(found)), "m", len(found)),
        Score.of("film_agreement.position_p99_m", float(np.percentile(found, 99)), "m", len(found)),
        Score.of("film_agreement.position_max_m", float(found.max()), "m", len(found)),
        Score.of("film_agreement.found_in_one_film_only", single, "count", len(shifts)),
    ]


def _counts(differences: list[Difference]) -> tuple[list[dict[str, int]], list[dict[str, int]]]:
    return [difference.pixels for difference in differences], [difference.differing for difference in differences]


def _apart(one: ImageArray, other: ImageArray) -> BoolArray:
    return np.asarray(cv2.absdiff(one, other).max(axis=2) > COLOUR_LEVELS)


def _changes(labels: ImageArray) -> BoolArray:
    """Where another label lies within two pixels."""
    return np.asarray(cv2.dilate(labels, _REACH) != cv2.erode(labels, _REACH))


def _distance(one: FloatArray | None, other: FloatArray | None) -> float:
    return float("inf") if one is None or other is None else float(np.hypot(*(one - other)))


def _without_vehicles(state: Truth) -> Truth:
    none = np.empty((0, 3))
    return Truth(state.index, state.time_ns, (), (), none, np.empty(0), none, np.empty((0, 2)), switches=state.switches)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--states", type=int, default=STATES)
    parser.add_argument("--worst", type=int, default=0, metavar="N")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    differences, shifts = compare(arguments.states)
    for shift in sorted(shifts, key=lambda shift: -shift.distance_m)[: arguments.worst]:
        print(shift, file=sys.stderr)
    scores = scores_of(differences, shifts)
    show(scores, title="film agreement", json=arguments.json)


if __name__ == "__main__":
    main()

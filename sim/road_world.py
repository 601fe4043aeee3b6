"""The road world: traffic on a network, filmed by a rig of pole cameras, with exact truth."""

import itertools
from collections.abc import Iterator, Sequence

from contracts import Camera, Frame, InputError, Survey
from contracts.truth import Step
from sim.air import Weather
from sim.board import BOARD, board_views
from sim.lens import Lens
from sim.light_program import LightProgram
from sim.lights import light_at
from sim.network_scene import scene_of_network
from sim.rail_world import Motion, step_of
from sim.rain import RainSpec
from sim.renderer import RendererName
from sim.rig import RigSpec, nominal_cameras, true_cameras
from sim.road_network import RoadNetwork
from sim.road_studio import RoadStudio
from sim.sensor import SensorSpec


class RoadWorld:
    """A ``contracts.truth.World``.

    times_ns: mid-exposures of the frames.
    seed: decides the true cameras, what stands beside the road and how users look; the motion has its own.
    noise_seed: of the sensors' noise; ``seed`` if not given.
    film, workers, keep_instances, renderer, sensor: as of ``sim.rail_world.RailWorld``.
    """

    def __init__(
        self,
        network: RoadNetwork,
        motion: Motion,
        times_ns: Sequence[int],
        *,
        rig: RigSpec,
        light: LightProgram,
        weather: Weather = Weather.DRY,
        seed: int,
        noise_seed: int | None = None,
        film: bool = True,
        workers: int = 1,
        keep_instances: bool = True,
        renderer: RendererName | str = RendererName.LAYERED,
        sensor: SensorSpec | None = None,
    ) -> None:
        if renderer not in list(RendererName):
            raise InputError(f"renderer {renderer!r} is unknown; choose from {', '.join(RendererName)}")
        self._network, self._motion, self._times_ns, self._rig = network, motion, tuple(times_ns), rig
        self._light, self._weather, self._renderer = light, weather, RendererName(renderer)
        self._seed, self._noise_seed = seed, seed if noise_seed is None else noise_seed
        self._film, self._workers, self._keep_instances = film, workers, keep_instances
        self._sensor = rig.sensor if sensor is None else sensor
        self._cameras = true_cameras(rig, seed)
        self._survey = Survey(nominal_cameras(rig), (), BOARD)  # type: ignore[arg-type]

    @property
    def survey(self) -> Survey:
        """Nominal cameras and the checkerboard; what is surveyed of a road is its map."""
        return self._survey

    @property
    def cameras(self) -> tuple[Camera, ...]:
        """The true cameras."""
        return self._cameras

    def __len__(self) -> int:
        return len(self._times_ns)

    def steps(self) -> Iterator[Step]:
        """Film the run from its start."""
        states, filmed = itertools.tee(self._motion.run(self._times_ns))
        if not self._film:
            return (Step((), state) for state in states)
        from sim.crew import FilmSpec, film

        scene = scene_of_network(self._network, self._cameras, self._seed)
        spec = FilmSpec(
            RoadStudio(scene, self._light, self._weather, self._seed, self._renderer),
            self._cameras,
            self._sensor,
            noise_seed=self._noise_seed,
            keep_instances=self._keep_instances,
            rain=RainSpec.of(self._weather, light_at(self._light.first, 0), self._sensor.exposure_ms * 1e-3),
        )
        return map(step_of, states, film(spec, filmed, workers=self._workers))

    def board_views(self, camera: str) -> Iterator[Frame]:
        """The checkerboard in many poses before ``camera``; InputError if the rig has no such camera."""
        known = {each.name: each for each in self._cameras}
        if camera not in known:
            raise InputError(f"camera {camera} is not in this rig; it has {', '.join(known)}")
        chosen = known[camera]
        lens = Lens.of(chosen.intrinsics)
        return board_views(chosen, lens, self._sensor, BOARD, seed=self._seed, noise_seed=self._noise_seed)

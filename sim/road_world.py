"""The road world: traffic on a network, filmed by a rig of pole cameras, with exact truth."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from contracts import Survey
from sim.air import Weather
from sim.board import BOARD
from sim.filmed_world import FilmedWorld, Filming, Motion
from sim.light_program import LightProgram
from sim.lights import light_at
from sim.network_scene import scene_of_network
from sim.rain import RainSpec
from sim.rig import nominal_cameras
from sim.road_network import RoadNetwork
from sim.road_studio import RoadStudio

if TYPE_CHECKING:
    from sim.crew import FilmSpec


class RoadWorld(FilmedWorld):
    """A ``contracts.truth.World``; the seed decides what stands beside the road and how users look, too.

    times_ns: mid-exposures of the frames.
    """

    def __init__(
        self,
        network: RoadNetwork,
        motion: Motion,
        times_ns: Sequence[int],
        filming: Filming,
        *,
        light: LightProgram,
        weather: Weather = Weather.DRY,
    ) -> None:
        super().__init__(motion, times_ns, filming)
        self._network, self._light, self._weather = network, light, weather
        self._survey = Survey(nominal_cameras(filming.rig), (), BOARD)  # type: ignore[arg-type]

    @property
    def survey(self) -> Survey:
        """Nominal cameras and the checkerboard; what is surveyed of a road is its map."""
        return self._survey

    def _film_spec(self) -> "FilmSpec":
        from sim.crew import FilmSpec

        scene = scene_of_network(self._network, self._cameras, self._seed)
        return FilmSpec(
            RoadStudio(scene, self._light, self._weather, self._seed, self._renderer),
            self._cameras,
            self._sensor,
            noise_seed=self._noise_seed,
            keep_instances=self._keep_instances,
            rain=RainSpec.of(self._weather, light_at(self._light.first, 0), self._sensor.exposure_ms * 1e-3),
        )

"""The rail world: vehicles on a plant, filmed by a rig of cameras, with exact truth."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from contracts import InputError, Survey
from rail import Plant
from sim.board import BOARD
from sim.filmed_world import FilmedWorld, Filming, Motion
from sim.light_program import LightProgram
from sim.lights import RAIL_LIGHTS, LightPreset
from sim.plant_scene import scene_of_plant
from sim.rig import nominal_cameras
from sim.studio import PlantStudio
from sim.surroundings import Surroundings

if TYPE_CHECKING:
    from sim.crew import FilmSpec

_BARE = Surroundings()


class RailWorld(FilmedWorld):
    """A ``contracts.truth.World``; the seed decides the floor and the clutter, too.

    times_ns: mid-exposures of the frames. surroundings: what an author put round the track.
    """

    def __init__(
        self,
        plant: Plant,
        motion: Motion,
        times_ns: Sequence[int],
        filming: Filming,
        *,
        light: LightPreset | LightProgram | str,
        surroundings: Surroundings = _BARE,
    ) -> None:
        if not isinstance(light, LightProgram) and light not in RAIL_LIGHTS:
            raise InputError(f"light {light!r} is unknown; choose from {', '.join(RAIL_LIGHTS)}")
        super().__init__(motion, times_ns, filming)
        self._light = light if isinstance(light, LightProgram) else LightPreset(light)
        self._highlights = surroundings.highlights
        self._scene = scene_of_plant(plant, self.cameras, filming.seed, surroundings)
        nominal = nominal_cameras(filming.rig)
        self._survey = Survey(nominal, self._scene.control_points_m, BOARD, self._scene.centrelines_m)

    @property
    def survey(self) -> Survey:
        """Nominal cameras, the marks on the floor, the checkerboard, the plan of the track."""
        return self._survey

    def _film_spec(self) -> "FilmSpec":
        from sim.crew import FilmSpec

        return FilmSpec(
            PlantStudio(self._scene, self._light, self._renderer),
            self._cameras,
            self._sensor,
            noise_seed=self._noise_seed,
            keep_instances=self._keep_instances,
            highlights=self._highlights,
        )

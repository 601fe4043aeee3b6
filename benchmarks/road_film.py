"""What the road's lights and weathers cost, and how well the layered film keeps to the one drawn anew.

``python -m benchmarks.road_film [--json] [--scenario NAME]``; times are of one picture of the busy road without lens
and sensor. Compare the ratios: they are of one run.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench.scores import Score
from benchmarks.command import show
from contracts import Camera
from contracts.truth import Truth
from scenarios.loader import load_scenario
from scenarios.network_file import load_network, routes_of
from scenarios.rig_file import load_rig
from scenarios.schema import RoadScenario
from sim.air import Weather
from sim.lens import Lens, pinhole_camera
from sim.light_program import LightProgram
from sim.lights import ROAD_LIGHTS, LightPreset
from sim.network_scene import scene_of_network
from sim.renderer import Rendered, RendererName
from sim.rig import true_cameras
from sim.road_scene import RoadScene
from sim.road_studio import RoadStudio
from sim.traffic import TrafficMotion

STATES, EVERY_NS = 12, 500_000_000
FULL_STATES = 3
DIFFERS = 4  # levels


@dataclass(frozen=True, eq=False)
class Stage:
    scene: RoadScene
    pinholes: Sequence[Camera]
    states: Sequence[Truth]
    seed: int

    @staticmethod
    def of(name: str) -> "Stage":
        scenario = load_scenario(name)
        assert isinstance(scenario, RoadScenario)
        network = load_network(scenario.network)
        cameras = true_cameras(load_rig(scenario.rig), scenario.seed)
        motion = TrafficMotion(network, routes_of(network), scenario.traffic, scenario.seed)
        return Stage(
            scene_of_network(network, cameras, scenario.seed),
            [pinhole_camera(camera, Lens.of(camera.intrinsics)) for camera in cameras],
            list(motion.run([k * EVERY_NS for k in range(STATES)])),
            scenario.seed,
        )

    def pictures(
        self, light: LightPreset, weather: Weather, name: RendererName, states: Sequence[Truth]
    ) -> tuple[list[Rendered], float]:
        """Of every state by every camera, and the median of their times in ms; what is kept is drawn before."""
        renderer = RoadStudio(self.scene, LightProgram(light), weather, self.seed, name).renderer(self.pinholes)
        for camera in self.pinholes:
            renderer.render(states[0], camera.name)
        rendered, times = [], []
        for state in states:
            for camera in self.pinholes:
                begin = time.perf_counter()
                rendered.append(renderer.render(state, camera.name))
                times.append(time.perf_counter() - begin)
        renderer.close()
        return rendered, 1e3 * float(np.median(times))


def measure(stage: Stage, light: LightPreset, weather: Weather) -> list[Score]:
    layered, layered_ms = stage.pictures(light, weather, RendererName.LAYERED, stage.states)
    checked = stage.states[-FULL_STATES:]
    full, full_ms = stage.pictures(light, weather, RendererName.FULL, checked)
    apart = [
        (np.abs(ours.image.astype(np.int16) - oracle.image).max(axis=2) > DIFFERS).mean()
        for ours, oracle in zip(layered[-len(full) :], full, strict=True)
    ]
    name, n = f"{light}_{weather}", len(layered)
    return [
        Score(f"road_film.layered_ms_{name}", layered_ms, "ms", n, True),
        Score(f"road_film.speedup_{name}", full_ms / layered_ms, "1", n, True),
        Score(f"road_film.apart_{name}", float(np.mean(apart)), "1", len(full), True),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--scenario", default="crossroads-day")
    arguments = parser.parse_args()
    stage = Stage.of(arguments.scenario)
    scores = [score for light in ROAD_LIGHTS for weather in Weather for score in measure(stage, light, weather)]
    show(scores, title="road film", json=arguments.json)


if __name__ == "__main__":
    main()

"""How fast the film is: frames per second with full truth, the layered renderer against the full one in one run.

``python -m benchmarks.film [--json] [--endurance N]``; N frames, under every light, also measure
how memory grows and whether OpenGL contexts remain.
"""

import argparse
import gc
import itertools
import resource
import time
from itertools import pairwise

import mujoco
import numpy as np

from bench.scores import Score
from benchmarks.command import show
from benchmarks.film_states import SEED, SIZES, random_state, random_switches, setting
from contracts.truth import Truth
from sim.crew import FilmSpec, film
from sim.lights import RAIL_LIGHTS, LightPreset
from sim.renderer import RendererName
from sim.studio import PlantStudio

VEHICLES = (1, 5, 20)
WARM_STATES = 3  # contexts, backdrops and caches come into being
LAYERED_STATES, FULL_STATES = 100, 4
ROUNDS = 4  # of all lights, when endurance is tried


def states(count: int, vehicles: int) -> list[Truth]:
    rng = np.random.default_rng(vehicles)
    switches = random_switches(rng)
    return [random_state(rng, vehicles, index=k, switches=switches) for k in range(count)]


def spec(size: str, renderer: RendererName, light: LightPreset = LightPreset.SUNNY) -> FilmSpec:
    rig, cameras, scene = setting(size)
    return FilmSpec(PlantStudio(scene, light, renderer), cameras, rig.sensor, noise_seed=SEED, keep_instances=True)


def rates(filmed: FilmSpec, *, each: int, workers: int) -> list[tuple[float, float]]:
    """For each number of vehicles: camera frames per second of wall clock, processor time of this process per frame.

    One film of them all, so that contexts, backdrops and caches come into being once, before the clock starts.
    """
    drawn = itertools.chain(states(WARM_STATES, 1), *(states(each, vehicles) for vehicles in VEHICLES))
    takes = film(filmed, drawn, workers=workers)
    for _ in range(WARM_STATES):
        next(takes)
    measured = []
    for _ in VEHICLES:
        wall, processor = time.perf_counter(), time.process_time()
        frames = sum(len(take) for take in itertools.islice(takes, each))
        measured.append((frames / (time.perf_counter() - wall), (time.process_time() - processor) / frames))
    return measured


def measure(size: str) -> list[Score]:
    slow = rates(spec(size, RendererName.FULL), each=FULL_STATES, workers=1)
    fast = rates(spec(size, RendererName.LAYERED), each=LAYERED_STATES, workers=1)
    team = rates(spec(size, RendererName.LAYERED), each=LAYERED_STATES, workers=2)
    scores = []
    for vehicles, (full_fps, _), (fps, cpu_s), (team_fps, _) in zip(VEHICLES, slow, fast, team, strict=True):
        name, n = f"{vehicles}_{size}", 2 * LAYERED_STATES
        scores += [
            Score(f"film.full_fps_{name}", full_fps, "1/s", 2 * FULL_STATES, True),
            Score(f"film.fps_{name}", fps, "1/s", n, True),
            Score(f"film.fps_{name}_two_processes", team_fps, "1/s", n, True),
            Score(f"film.speedup_{name}", fps / full_fps, "1", n, True),
            Score(f"film.cpu_s_{name}", cpu_s, "s", n, True),
        ]
    growth = [(b - a) / (v - u) for (u, v), ((_, a), (_, b)) in zip(pairwise(VEHICLES), pairwise(fast), strict=True)]
    for (low, high), cpu_s in zip(pairwise(VEHICLES), growth, strict=True):
        scores.append(Score(f"film.cpu_s_per_vehicle_{low}_to_{high}_{size}", cpu_s, "s", 2 * LAYERED_STATES, True))
    return scores


def endure(frames: int) -> list[Score]:
    """Memory and OpenGL contexts while ``frames`` frames are filmed, every light in its turn, each light's film anew.

    Growth: of the peak of the resident memory, from the end of the first round of all lights to the end of the last.
    """
    per_film = frames // (2 * ROUNDS * len(RAIL_LIGHTS))
    peaks_mb = []
    for turn in range(ROUNDS):
        for light in RAIL_LIGHTS:
            drawn = (random_state(np.random.default_rng((turn, k)), 3, index=k) for k in range(per_film))
            for _ in film(spec("720p", RendererName.LAYERED, light), drawn, workers=1):
                pass
        peaks_mb.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0)
    gc.collect()
    contexts = sum(isinstance(each, mujoco.GLContext | mujoco.MjrContext) for each in gc.get_objects())
    filmed = 2 * per_film * ROUNDS * len(RAIL_LIGHTS)
    return [
        Score("film.memory_growth", peaks_mb[-1] - peaks_mb[0], "MB", filmed, True),
        Score("film.contexts_left", contexts, "count", ROUNDS * len(RAIL_LIGHTS), True),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--endurance", type=int, default=0, metavar="N")
    arguments = parser.parse_args()
    scores = [score for size in SIZES for score in measure(size)]
    if arguments.endurance:
        scores += endure(arguments.endurance)
    show(scores, title="film", json=arguments.json)


if __name__ == "__main__":
    main()

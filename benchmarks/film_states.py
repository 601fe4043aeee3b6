"""Random but repeatable traffic on the oval, for measuring the film."""

from dataclasses import replace
from functools import cache

import numpy as np

from contracts import Camera, SwitchState
from contracts.truth import Truth
from rail import Plant
from scenarios.plant_file import load_plant
from scenarios.rig_file import load_rig
from sim.colours import Colour
from sim.plant_scene import scene_of_plant
from sim.rig import RigSpec, true_cameras
from sim.scene import Scene

SIZES = {"720p": (1280, 720, 1600.0), "1200p": (1920, 1200, 1037.0)}
SEED = 1
_APART_M = 0.14

Switches = dict[str, SwitchState]


@cache
def oval() -> Plant:
    return load_plant("oval")


def rig(size: str) -> RigSpec:
    """The rig ``two_overhead``, its cameras of another size."""
    width, height, focal = SIZES[size]
    spec = load_rig("two_overhead")
    return replace(spec, cameras=tuple(replace(c, resolution_px=(width, height), focal_px=focal) for c in spec.cameras))


def setting(size: str) -> tuple[RigSpec, tuple[Camera, ...], Scene]:
    spec = rig(size)
    cameras = true_cameras(spec, SEED)
    return spec, cameras, scene_of_plant(oval(), cameras, SEED)


def random_switches(rng: np.random.Generator) -> Switches:
    """Every switch of the oval one way or the other."""
    return {name: (SwitchState.STRAIGHT, SwitchState.DIVERGING)[rng.integers(2)] for name in oval().switches}


def random_state(
    rng: np.random.Generator, vehicles: int, *, index: int = 0, speed_mps: float = 0.4, switches: Switches | None = None
) -> Truth:
    """Vehicles anywhere on the track, none inside another, at any time of the light; switches any way if not given."""
    sections = list(oval().sections.values())
    places: list[tuple[float, float, float]] = []
    while len(places) < vehicles:
        section = sections[rng.integers(len(sections))]
        pose = section.curve.pose_at(rng.uniform(0.0, section.length_m))
        if all(np.hypot(pose.x_m - x, pose.y_m - y) > _APART_M for x, y, _ in places):
            places.append((pose.x_m, pose.y_m, pose.heading_rad))
    x, y, headings = np.array(places).T
    colours = [str(colour) for colour in Colour]
    return Truth(
        index=index,
        time_ns=int(rng.uniform(0.0, 12e9)),
        ids=tuple(f"v{k}" for k in range(vehicles)),
        labels=tuple(colours[k % len(colours)] for k in range(vehicles)),
        positions_m=np.column_stack([x, y, np.zeros(vehicles)]),
        headings_rad=headings,
        sizes_m=np.tile([0.12, 0.06, 0.06], (vehicles, 1)),
        velocities_mps=speed_mps * np.column_stack([np.cos(headings), np.sin(headings)]),
        switches=random_switches(rng) if switches is None else switches,
    )

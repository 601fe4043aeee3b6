"""The scene as a MuJoCo model: floor, track, switch machines, clutter."""

import mujoco
import numpy as np

from contracts import FloatArray
from sim.floor import MARK_RADIUS_M, PERIOD_M, floor_texture
from sim.lights import Rgb
from sim.meshes import Mesh, boxes, discs, merged, prism, ribbon
from sim.model_parts import add_mesh, add_still, set_quality
from sim.scene import BUFFER_SIZE_M, FLOOR_Z_M, SPOT_HEIGHT_M, SPOT_RADIUS_M, Scene
from sim.streams import stream
from sim.surroundings import SHEET_M

_GAUGE_M = 0.032
_RAIL_M = (0.0028, 0.0035, 0.0085)  # width, bottom, top
_SLEEPER_M = (0.010, 0.062, 0.0035)  # along the track, across, height
_SLEEPER_STEP_M = 0.030

_YELLOW = (0.93, 0.79, 0.08)
_RAIL = (0.55, 0.53, 0.51)
_SLEEPER = (0.27, 0.21, 0.16)
_MACHINE = (0.16, 0.16, 0.17)
_BALISE = (0.85, 0.84, 0.80)
_BUFFER = (0.30, 0.27, 0.25)


def build_model(scene: Scene, *, buffer_px: tuple[int, int]) -> mujoco.MjModel:
    """Compile the scene for off-screen pictures of at most ``buffer_px`` (width, height).

    Geoms named ``spot/<switch>`` are the switch spots; their colour is the renderer's to change. Those named
    ``sheet/<number>`` lie flat on the floor.
    """
    spec = mujoco.MjSpec()
    set_quality(spec, buffer_px)
    _add_floor(spec, scene)
    for name, mesh, colour in _furniture(scene):
        add_mesh(spec, name, mesh)
        add_still(spec, name, colour)
    _add_clutter(spec, scene)
    return spec.compile()


def _add_floor(spec: mujoco.MjSpec, scene: Scene) -> None:
    x0, y0, x1, y1 = scene.floor_m
    picture = floor_texture(scene.seed, scene.floor)
    texture = spec.add_texture(
        name="floor", type=mujoco.mjtTexture.mjTEXTURE_2D, width=picture.shape[1], height=picture.shape[0], nchannel=3
    )
    texture.data = picture.tobytes()
    repeat = ((x1 - x0) / PERIOD_M, (y1 - y0) / PERIOD_M)
    material = spec.add_material(name="floor", texuniform=False, texrepeat=repeat, specular=0, shininess=0)
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[(x1 - x0) / 2, (y1 - y0) / 2, 1.0],
        pos=[(x0 + x1) / 2, (y0 + y1) / 2, FLOOR_Z_M],
        material="floor",
    )


def _furniture(scene: Scene) -> list[tuple[str, Mesh, Rgb]]:
    """Name, mesh and colour of everything but floor and clutter."""
    parts = [("marks", discs(scene.control_points_m, MARK_RADIUS_M), _YELLOW)]
    if scene.centrelines_m:
        parts.append(("rails", merged([rail for line in scene.centrelines_m for rail in _rails(line)]), _RAIL))
        parts.append(("sleepers", merged([_sleepers(line) for line in scene.centrelines_m]), _SLEEPER))
    for spot in scene.spots:
        at, heading = spot.position_m[None], np.array([spot.heading_rad])
        parts.append((f"machine/{spot.switch}", boxes(at, heading, np.array([0.030, 0.016, SPOT_HEIGHT_M])), _MACHINE))
        lid = np.column_stack([at, [SPOT_HEIGHT_M + 0.0003]])
        parts.append((f"spot/{spot.switch}", discs(lid, SPOT_RADIUS_M), _MACHINE))
    if len(scene.balises_m):
        places = scene.balises_m
        parts.append(("balises", boxes(places[:, :2], places[:, 2], np.array([0.012, 0.008, 0.005])), _BALISE))
    if len(scene.buffers_m):
        places = scene.buffers_m
        parts.append(("buffers", boxes(places[:, :2], places[:, 2], BUFFER_SIZE_M), _BUFFER))
    for number, thing in enumerate(scene.things):
        solid = thing.solid
        kind = "sheet" if solid.top_m <= SHEET_M else "object"
        mesh = prism(solid.outline_m, bottom_m=solid.bottom_m, top_m=solid.top_m)
        parts.append((f"{kind}/{number}", mesh, thing.rgb))
    return parts


def _rails(line_m: FloatArray) -> list[Mesh]:
    width, bottom, top = _RAIL_M
    return [
        ribbon(line_m, left_m=side + width / 2, right_m=side - width / 2, bottom_m=bottom, top_m=top)
        for side in (-_GAUGE_M / 2, _GAUGE_M / 2)
    ]


def _sleepers(line_m: FloatArray) -> Mesh:
    """Sleepers at equal distances along the line, none at its very ends."""
    step = np.diff(line_m, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*step.T))])
    count = max(1, round(along[-1] / _SLEEPER_STEP_M))
    at = (np.arange(count) + 0.5) * (along[-1] / count)
    centres = np.column_stack([np.interp(at, along, line_m[:, k]) for k in range(2)])
    segment = np.clip(np.searchsorted(along, at) - 1, 0, len(step) - 1)
    return boxes(centres, np.arctan2(step[segment, 1], step[segment, 0]), np.array(_SLEEPER_M))


def _add_clutter(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Boxes in dull colours: nothing there may pass for a vehicle."""
    rng = stream(scene.seed, "clutter/colour")
    for x, y, heading, length, width, height in scene.clutter_m:
        colour = rng.uniform(0.25, 0.6) + rng.normal(0.0, 0.03, 3)
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=[length / 2, width / 2, height / 2],
            pos=[x, y, height / 2],
            quat=[np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)],
            rgba=[*np.clip(colour, 0.05, 0.9), 1.0],
            contype=0,
            conaffinity=0,
        )

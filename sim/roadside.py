"""What stands beside the road: buildings with windows, trees, and the poles of lamps, signals and signs.

All of it is drawn from the seed, so that it is the same again, and keeps clear of what an owner keeps clear when he
hangs a camera: the first metres before it, and its sight of the road nearby. Farther away trees, poles and corners of
buildings hide what they hide.
"""

from collections.abc import Iterator, Sequence

import numpy as np
import shapely
from scipy.spatial import ConvexHull
from shapely.geometry.base import BaseGeometry

from contracts import Camera, FloatArray
from georef.hd_map import FacilityKind, HdMap
from sim.lights import Rgb
from sim.meshes import Mesh, merged, prism, quads
from sim.poles import STEEL, bar, pole, towards, turns
from sim.road_map import SIGN_HEIGHT_M
from sim.road_network import RoadNetwork
from sim.road_scene import PartKind, StillPart
from sim.signal_heads import head_of, head_parts
from sim.signals import SignalHead
from sim.streams import stream
from sim.terrain import Terrain

LAMP_HEIGHT_M = 8.0
_UP = np.array([0.0, 0.0, 1.0])
_LAMP_ARM_M, _MAST_M = 1.6, 5.6
_TRUNK_SIDES = 6
_STORY_M, _BAY_M, _WINDOW_M = 3.1, 2.6, (1.5, 1.5)  # of a facade
_HOUSE_EVERY_M, _HOUSE_BESIDE_M = 20.0, 6.0
_TREE_EVERY_M, _TREE_BESIDE_M = 11.0, 2.2
_PLANTED = 0.6  # share of the places for trees that have one
_CAMERA_CLEAR_M, _SIGHT_M, _TREE_SIGHT_M, _SIGHT_STEP_M = 7.0, 60.0, 22.0, 4.0

_FACADES: tuple[Rgb, ...] = (
    (0.71, 0.66, 0.58),
    (0.62, 0.46, 0.38),
    (0.74, 0.74, 0.72),
    (0.52, 0.54, 0.57),
    (0.78, 0.71, 0.56),
    (0.58, 0.38, 0.32),
)
_PANE, _ROOF, _BARK, _LUMINAIRE = (0.20, 0.24, 0.29), (0.36, 0.34, 0.33), (0.30, 0.23, 0.17), (0.82, 0.81, 0.76)
_AT_HOME = 0.22  # share of the windows that are lit when it is dark
_LIT_PANE: Rgb = (0.50, 0.36, 0.18)
_BLACK: Rgb = (0.0, 0.0, 0.0)
_LUMINAIRE_SHINES: Rgb = (1.0, 0.92, 0.70)
_PLATE: Rgb = (0.80, 0.12, 0.12)
_LEAVES: tuple[Rgb, ...] = ((0.20, 0.33, 0.12), (0.26, 0.38, 0.15), (0.17, 0.29, 0.14), (0.33, 0.40, 0.17))


def roadside_parts(
    carriageway: BaseGeometry,
    pavement: BaseGeometry,
    road_map: HdMap,
    terrain: Terrain,
    *,
    cameras: Sequence[Camera],
    seed: int,
) -> Iterator[StillPart]:
    """All that stands beside carriageway and pavement, areas on the ground plane; ``cameras`` keep their sight."""
    road = carriageway.union(pavement)
    near, far = (sight_area(road, cameras, reach_m) for reach_m in (_TREE_SIGHT_M, _SIGHT_M))
    houses = list(_houses(road, far, stream(seed, "buildings")))
    at_home = stream(seed, "lit windows")
    for number, house in enumerate(houses):
        yield from _building(number, house, terrain, at_home)
    taken = shapely.union_all([shapely.Polygon(outline).buffer(2.0) for outline, _, _ in houses] + [near])
    yield from _trees(road, taken, terrain, stream(seed, "trees"))
    yield from _poles(carriageway, road_map)


def luminaires(carriageway: BaseGeometry, road_map: HdMap) -> FloatArray:
    """Where the streetlamps shine from, (L, 3)."""
    lamps = [facility for facility in road_map.facilities if facility.kind is FacilityKind.STREETLAMP]
    places = [lamp.position_m + _LAMP_ARM_M * towards(carriageway, lamp.position_m) for lamp in lamps]
    return np.array(places).reshape(-1, 3) + LAMP_HEIGHT_M * _UP


def signal_heads(carriageway: BaseGeometry, road_map: HdMap, network: RoadNetwork) -> Iterator[SignalHead]:
    """The heads of all signals, in the map's order."""
    for signal in road_map.signals:
        yield head_of(network, signal.lanes, signal.position_m, towards(carriageway, signal.position_m))


def sight_area(road: BaseGeometry, cameras: Sequence[Camera], reach_m: float) -> BaseGeometry:
    """What lies between each camera and the road within ``reach_m``, and the ground just around its pole."""
    kept: list[BaseGeometry] = []
    for camera in cameras:
        eye = shapely.Point(camera.pose.position_m[:2])
        kept.append(eye.buffer(_CAMERA_CLEAR_M))
        seen = road.intersection(eye.buffer(reach_m).intersection(_field(camera, reach_m)))
        if not seen.is_empty:
            low_x, low_y, high_x, high_y = seen.bounds
            grid = np.stack(
                np.meshgrid(np.arange(low_x, high_x, _SIGHT_STEP_M), np.arange(low_y, high_y, _SIGHT_STEP_M)), axis=-1
            ).reshape(-1, 2)
            places = grid[shapely.contains_xy(seen, grid[:, 0], grid[:, 1])]
            rays = shapely.linestrings(np.stack([np.broadcast_to(eye.coords[0], places.shape), places], axis=1))
            kept.append(shapely.union_all(shapely.buffer(rays, _SIGHT_STEP_M / 2, quad_segs=1)))
    return shapely.union_all(kept)


def _field(camera: Camera, reach_m: float) -> BaseGeometry:
    """The camera's field of view on the ground plane, a triangle."""
    size, turn = camera.intrinsics, camera.pose.world_from_camera
    edges = np.array([[(u - size.cx_px) / size.fx_px, 0.0, 1.0] for u in (0, size.width_px)]) @ turn.T
    edges = edges[:, :2] / np.linalg.norm(edges[:, :2], axis=1, keepdims=True)
    eye = camera.pose.position_m[:2]
    return shapely.Polygon([eye, eye + 2 * reach_m * edges[0], eye + 2 * reach_m * edges[1]])


def _beside(road: BaseGeometry, gap_m: float, every_m: float) -> Iterator[tuple[FloatArray, float]]:
    """Places (2,) along the outline of the road, so far from it, and the heading of the outline there."""
    for ring in shapely.get_parts(road.buffer(gap_m).boundary):
        for along in np.arange(every_m / 2, ring.length, every_m):
            here, ahead = (np.array(ring.interpolate(at).coords[0]) for at in (along, along + 1.0))
            yield here, float(np.arctan2(*(ahead - here)[::-1]))


def _houses(
    road: BaseGeometry, sight: BaseGeometry, rng: np.random.Generator
) -> Iterator[tuple[FloatArray, float, Rgb]]:
    """Outlines (4, 2), heights and colours of buildings that touch neither the road, nor each other, nor ``sight``."""
    taken = shapely.union_all([road.buffer(_HOUSE_BESIDE_M), sight])
    for place, heading in _beside(road, _HOUSE_BESIDE_M, _HOUSE_EVERY_M):
        width_m, depth_m, height_m = rng.uniform(11.0, 18.0), rng.uniform(9.0, 13.0), rng.integers(2, 8) * _STORY_M
        rgb = _FACADES[rng.integers(len(_FACADES))]
        outward = np.array([np.sin(heading), -np.cos(heading)])
        if shapely.contains_xy(road.buffer(_HOUSE_BESIDE_M), *(place + 0.5 * outward)):
            outward = -outward
        turn = np.column_stack([np.array([np.cos(heading), np.sin(heading)]), outward])
        centre = place + (depth_m / 2 + rng.uniform(0.5, 4.0)) * outward
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (width_m / 2, depth_m / 2) @ turn.T + centre
        outline = shapely.orient_polygons(shapely.Polygon(corners))
        if not outline.intersects(taken):
            taken = taken.union(outline.buffer(1.0))
            yield shapely.get_coordinates(outline)[:4], float(height_m), rgb


def _building(
    number: int, house: tuple[FloatArray, float, Rgb], terrain: Terrain, at_home: np.random.Generator
) -> Iterator[StillPart]:
    """A block with a grid of windows, some of them lit at night."""
    outline_m, height_m, rgb = house
    foot = float(terrain.height_m(outline_m).min()) - 0.5
    top = foot + 0.5 + height_m
    yield StillPart(f"building/{number}", PartKind.BUILDING, prism(outline_m, bottom_m=foot, top_m=top), rgb)
    centre = outline_m.mean(axis=0)
    rim = prism(centre + 1.02 * (outline_m - centre), bottom_m=top, top_m=top + 0.4)
    yield StillPart(f"building/{number}/roof", PartKind.BUILDING, rim, _ROOF)
    walls = zip(outline_m, np.roll(outline_m, -1, 0), strict=True)
    panes = np.concatenate([_windows(a, b, foot + 0.5, height_m) for a, b in walls])
    lit = at_home.uniform(size=len(panes)) < _AT_HOME
    for name, which, shining in (("windows", ~lit, _BLACK), ("lit_windows", lit, _LIT_PANE)):
        if which.any():
            mesh = quads(panes[which])
            yield StillPart(f"building/{number}/{name}", PartKind.BUILDING, mesh, _PANE, adorns=True, shining=shining)


def _windows(a: FloatArray, b: FloatArray, foot_m: float, height_m: float) -> FloatArray:
    """A grid of windows on the wall from ``a`` to ``b`` (2,), which has the outside on its right; (K, 4, 3) corners."""
    length = float(np.linalg.norm(b - a))
    along, out = (b - a) / length, np.array([(b - a)[1], -(b - a)[0]]) / length
    across = (np.arange(max(1, int(length / _BAY_M))) + 0.5) * length / max(1, int(length / _BAY_M))
    floors = foot_m + (np.arange(round(height_m / _STORY_M)) + 0.5) * _STORY_M
    middle = np.stack(np.meshgrid(across, floors), axis=-1).reshape(-1, 2)  # (K, 2) along the wall, up
    corners = middle[:, None] + np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * np.array(_WINDOW_M) / 2  # (K, 4, 2)
    flat = a + corners[..., :1] * along + 0.02 * out
    return np.concatenate([flat, corners[..., 1:]], axis=-1)


def _trees(road: BaseGeometry, taken: BaseGeometry, terrain: Terrain, rng: np.random.Generator) -> Iterator[StillPart]:
    for number, (place, _) in enumerate(_beside(road, _TREE_BESIDE_M, _TREE_EVERY_M)):
        height_m, spread_m = rng.uniform(4.5, 9.0), rng.uniform(1.2, 2.0)
        planted, rgb = rng.uniform() < _PLANTED, _LEAVES[rng.integers(len(_LEAVES))]
        blobs = rng.normal(0.0, 0.35, (3, 3)), rng.uniform(0.6, 1.0, 3)
        crown = shapely.Point(place).buffer(spread_m)
        if not planted or crown.intersects(taken):
            continue
        foot = terrain.lifted(place[None])[0]
        trunk = np.array([place + 0.14 * np.array([np.cos(t), np.sin(t)]) for t in turns(_TRUNK_SIDES)])
        stem = prism(trunk, bottom_m=foot[2] - 0.2, top_m=foot[2] + 0.6 * height_m)
        yield StillPart(f"tree/{number}/trunk", PartKind.TREE, stem, _BARK)
        centre = foot + 0.68 * height_m * _UP
        reach = np.array([spread_m, spread_m, 0.32 * height_m])
        leaves = [blob(centre + shift * reach, share * 0.85 * reach, rng) for shift, share in zip(*blobs, strict=True)]
        yield StillPart(f"tree/{number}/crown", PartKind.TREE, merged(leaves), rgb)


def blob(centre_m: FloatArray, radii_m: FloatArray, rng: np.random.Generator) -> Mesh:
    """A rough ball: an icosahedron whose corners stand out unevenly."""
    golden = (1 + 5**0.5) / 2
    corners = np.array([(0, a, b * golden) for a in (-1, 1) for b in (-1, 1)])
    corners = np.concatenate([np.roll(corners, k, axis=1) for k in range(3)]) / np.hypot(1, golden)  # (12, 3)
    faces = ConvexHull(corners).simplices
    normals = np.cross(corners[faces[:, 1]] - corners[faces[:, 0]], corners[faces[:, 2]] - corners[faces[:, 0]])
    inward = (normals * corners[faces].mean(axis=1)).sum(axis=1) < 0
    faces[inward] = faces[inward][:, ::-1]
    rough = corners * rng.uniform(0.85, 1.15, (12, 1)) * radii_m + centre_m
    return Mesh(rough[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3))


def _poles(carriageway: BaseGeometry, road_map: HdMap) -> Iterator[StillPart]:
    for facility in road_map.facilities:
        if facility.kind is FacilityKind.STREETLAMP:
            yield from _lamp(facility.id, facility.position_m, towards(carriageway, facility.position_m))
        else:
            yield pole(facility.id, facility.position_m, _MAST_M, 0.08)
    for signal in road_map.signals:
        yield from head_parts(signal.id, signal.position_m, towards(carriageway, signal.position_m))
    for sign in road_map.signs:
        inward = towards(carriageway, sign.position_m)
        yield pole(f"{sign.id}/post", sign.position_m - SIGN_HEIGHT_M * _UP, SIGN_HEIGHT_M + 0.4, 0.035)
        across = 0.33 * np.array([-inward[1], inward[0], 0.0])
        plate = bar(sign.position_m - across, sign.position_m + across, 0.04, 0.65)
        yield StillPart(f"{sign.id}/plate", PartKind.POLE, plate, _PLATE)


def _lamp(name: str, foot_m: FloatArray, inward: FloatArray) -> Iterator[StillPart]:
    """A streetlamp whose luminaire hangs over the road's edge."""
    top = foot_m + LAMP_HEIGHT_M * _UP
    tip = top + _LAMP_ARM_M * inward
    yield pole(f"{name}/post", foot_m, LAMP_HEIGHT_M, 0.09)
    yield StillPart(f"{name}/arm", PartKind.POLE, bar(top, tip, 0.06), STEEL)
    housing = bar(tip - 0.3 * inward, tip + 0.4 * inward, 0.16)
    yield StillPart(f"{name}/lamp", PartKind.POLE, housing, _LUMINAIRE, shining=_LUMINAIRE_SHINES)

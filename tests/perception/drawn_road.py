"""Pictures of a road's paint as OpenCV draws it, under cameras whose pose and lens are known exactly."""

from dataclasses import replace

import cv2
import numpy as np
import shapely
from scipy.spatial.transform import Rotation

from contracts import Camera, ImageArray, Intrinsics, Pose
from georef.hd_map import HdMap
from scenarios.network_file import load_network
from sim.projection import project
from sim.rig import look_down
from sim.road_map import map_of_network
from sim.road_surface import painted

CROSSROADS = map_of_network(load_network("crossroads"))
ROUNDABOUT = map_of_network(load_network("roundabout"))
LENS = np.array([-0.1, 0.03, 0.0, 0.0, 0.0])


def nominal_camera(position_m=(-17.0, -17.0, 8.0), pan_deg: float = 45.0, tilt_deg: float = 66.0) -> Camera:
    plain = Intrinsics(1280, 720, 850.0, 850.0, 639.5, 359.5, np.zeros(5))
    return Camera("pole", plain, Pose(look_down(tilt_deg, pan_deg), np.array(position_m)))


def true_camera(nominal: Camera) -> Camera:
    """Some degrees and centimetres off, with a lens."""
    turn = Rotation.from_rotvec(np.radians([0.9, -1.4, 0.8])).as_matrix()
    pose = Pose(turn @ nominal.pose.world_from_camera, nominal.pose.position_m + np.array([0.04, -0.05, 0.03]))
    lens = Intrinsics(1280, 720, 852.5, 852.5, 643.0, 355.0, LENS)
    return replace(nominal, intrinsics=lens, pose=pose)


def picture(camera: Camera, hd_map: HdMap) -> ImageArray:
    """The map's paint before the camera, drawn four times as large and averaged; noise as of a sensor."""
    image = np.full((720 * 4, 1280 * 4), 78, np.uint8)
    ahead = _before(camera)
    for colour in {line.colour for line in hd_map.lane_markings}:
        for outline in painted(hd_map, colour):
            for part in (part for part in shapely.get_parts(outline.intersection(ahead)) if part.area > 0):
                ring = np.array(part.segmentize(0.5).exterior.coords)
                pixels, valid = project(camera, np.column_stack([ring, np.zeros(len(ring))]))
                if valid.all():
                    fixed = np.rint((pixels + 0.5) * 4 * 16).astype(np.int32) - 8
                    cv2.fillPoly(image, [fixed], 225, cv2.LINE_8, 4)
    small = cv2.resize(image, (1280, 720), interpolation=cv2.INTER_AREA).astype(np.float64)
    small = cv2.GaussianBlur(small, (0, 0), 0.5)
    small += np.random.default_rng(2).normal(0.0, 1.5, small.shape)
    return np.repeat(np.clip(small, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def _before(camera: Camera) -> shapely.Polygon:
    """The ground that lies more than a metre and less than 120 m before a camera."""
    ahead = camera.pose.world_from_camera[:2, 2]
    ahead = ahead / np.linalg.norm(ahead)
    side = 120.0 * np.array([-ahead[1], ahead[0]])
    near, far = camera.pose.position_m[:2] + np.outer([1.0, 120.0], ahead)
    return shapely.Polygon([near - side, far - side, far + side, near + side])

"""Where on the floor does a pixel lie, and how sure is that? The code that real cameras use, without any simulation."""

import numpy as np

from contracts import Camera, Detections, Intrinsics, Pose, Tracks
from georef.calibrated import PARAMETERS, CalibratedCamera
from georef.location import RayPlaneLocator

LOOK_DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])  # image u is east, v is south

if __name__ == "__main__":
    intrinsics = Intrinsics(1280, 720, 1600.0, 1600.0, 639.5, 359.5, np.zeros(5))
    camera = Camera("ceiling", intrinsics, Pose(LOOK_DOWN, np.array([0.0, 0.0, 2.8])))
    sigmas = dict.fromkeys(PARAMETERS, 0.0) | {"x": 0.001, "y": 0.001, "z": 0.002}  # the pose is known to 1-2 mm
    calibrated = CalibratedCamera(camera, np.diag([sigmas[name] ** 2 for name in PARAMETERS]))

    roof_px = np.array([[900.0, 200.0]])
    track = Tracks(
        ids=[0],
        objects=Detections(
            camera="ceiling",
            index=0,
            time_ns=0,
            labels=("blue",),
            scores=[1.0],
            boxes_px=[[865.0, 182.0, 935.0, 218.0]],
            quads_px=[[[865.0, 182.0], [935.0, 182.0], [935.0, 218.0], [865.0, 218.0]]],
            anchors_px=roof_px,
            anchor_heights_m=[0.06],
            anchor_covs_px2=[0.09 * np.eye(2)],
        ),
    )
    ground = RayPlaneLocator({"ceiling": calibrated}).locate(track)
    x_m, y_m = ground.positions_m[0]
    print(f"x = {x_m:.4f} m, y = {y_m:.4f} m, sigma = {1000 * np.sqrt(np.diag(ground.covs_m2[0])).round(5)} mm")

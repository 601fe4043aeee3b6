"""A detector of one's own: blobs of saturated colour, nothing more.

gantry check detector examples.e02_own_detector:SaturatedBlobs
gantry run oval-one-vehicle --detector examples.e02_own_detector:SaturatedBlobs
"""

import cv2
import numpy as np

from contracts import Detections, Frame


class SaturatedBlobs:
    """Calls every saturated blob a vehicle and lets its centroid stand for it, as if it lay on the floor."""

    def reset(self) -> None:
        """Nothing to forget."""

    def detect(self, frame: Frame) -> Detections:
        """Connected regions of saturated colour."""
        saturation = cv2.cvtColor(frame.image, cv2.COLOR_BGR2HSV)[:, :, 1]
        _, _, stats, centroids = cv2.connectedComponentsWithStats((saturation > 180).astype(np.uint8))
        large = [k for k in range(1, len(stats)) if stats[k, cv2.CC_STAT_AREA] > 500]  # 0 is the background
        n = len(large)
        x, y, width, height = stats[large, :4].astype(float).T
        boxes_px = np.stack([x, y, x + width - 1, y + height - 1], axis=1)
        return Detections(
            camera=frame.camera,
            index=frame.index,
            time_ns=frame.time_ns,
            labels=("blob",) * n,
            scores=np.ones(n),
            boxes_px=boxes_px,
            quads_px=boxes_px[:, [0, 1, 2, 1, 2, 3, 0, 3]].reshape(n, 4, 2),
            anchors_px=centroids[large],
            anchor_heights_m=np.zeros(n),
            anchor_covs_px2=np.tile(25.0 * np.eye(2), (n, 1, 1)),
        )

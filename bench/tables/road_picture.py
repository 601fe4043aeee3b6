"""A camera's picture with the lanes that were found in it, and the same lanes on the map."""

from collections.abc import Sequence
from html import escape

import cv2
import numpy as np

from bench.report.pictures import data_url
from bench.tables.part import Part
from bench.tables.road_film import FilmedCamera
from perception.lane_paths import LanePath

_PATH_BGR = (60, 60, 230)


def road_picture(filmed: FilmedCamera, paths: Sequence[LanePath]) -> Part:
    """What stands still before the camera, with the main path of every lane that was found."""
    image = filmed.picture.copy()
    for path in paths:
        points = np.rint(path.pixels * 16).astype(np.int32).reshape(-1, 1, 2)
        cv2.polylines(image, [points], False, _PATH_BGR, 2, cv2.LINE_AA, 4)
    says = f"Camera “{filmed.true.name}” of “{filmed.scenario.name}”: {len(paths)} lanes within 20 degrees of its axis."
    return Part(
        "lanes",
        "Lanes found in the image",
        says,
        picture=f'<img src="{data_url(image)}" alt="{escape(says)}" style="max-width:100%">',
    )

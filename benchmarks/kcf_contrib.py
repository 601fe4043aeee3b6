"""OpenCV-contrib's TrackerKCF on given frames; runs in an environment of its own, for the two OpenCV packages clash.

``python kcf_contrib.py FRAMES.npy`` reads one order a line from standard input, {"setting", "frames", "box"}, and
answers each with one line, {"centres", "seconds"}: the boxes' centres, null where the tracker says that it has lost
the target, and the processor time of the other updates.
"""

import json
import sys
import time

import cv2
import numpy as np


def params(setting):
    """``default``, or ``grey``: raw grey values alone, nothing compressed. Both pad a box to twice its sides.

    Neither gives up a target by its own threshold. In OpenCV 5.0.0 grey fails in the second frame: an empty matrix.
    """
    chosen = cv2.TrackerKCF.Params()
    chosen.detect_thresh = 0.0
    if setting == "grey":
        grey = 1  # TrackerKCF::GRAY; Python has no name for it
        chosen.desc_npca, chosen.desc_pca, chosen.compress_feature = grey, 0, False
    return chosen


def follow(frames, order):
    tracker = cv2.TrackerKCF.create(params(order["setting"]))
    first, last = order["frames"]
    tracker.init(np.array(frames[first]), tuple(order["box"]))
    centres, seconds = [], 0.0
    for index in range(first + 1, last):
        image = np.array(frames[index])  # from the file into memory, before the clock starts
        begin = time.thread_time()
        try:
            found, (x, y, width, height) = tracker.update(image)
        except cv2.error:  # it fails on a target that leaves the image, and with grey alone always
            found = False
        if found:  # a lost target costs less
            seconds += time.thread_time() - begin
        centres.append([x + (width - 1) / 2, y + (height - 1) / 2] if found else None)
    return {"centres": centres, "seconds": seconds}


def main():
    cv2.setNumThreads(1)
    frames = np.load(sys.argv[1], mmap_mode="r")
    for line in sys.stdin:
        print(json.dumps(follow(frames, json.loads(line))), flush=True)


if __name__ == "__main__":
    main()

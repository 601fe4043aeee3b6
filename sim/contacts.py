"""When two moving boxes touch, however short the contact.

Guarantee: ``first_touch`` returns a time if the boxes touch in the interval, and none if they stay ``TOUCH_M`` apart,
as ``sim.boxes.separation_m`` measures it. No contact falls between samples, because each step in time is too short for
the boxes to close the gap between them, whatever they do.
"""

from collections.abc import Callable

from sim.boxes import Box, separation_m

TOUCH_M = 1e-6  # air below which two bodies count as touching


def first_touch(
    box_a: Callable[[float], Box], box_b: Callable[[float], Box], *, closing_mps: float, until_s: float
) -> float | None:
    """First time in [0, ``until_s``] at which the boxes touch, in seconds; None if they do not.

    box_a, box_b: the footprints at a time.
    closing_mps: no pair of points of the two bodies approaches faster than this.
    Source: conservative advancement (Mirtich 1996, Impulse-based dynamic simulation, §2.3).
    """
    time_s = 0.0
    while time_s <= until_s:
        gap_m = separation_m(box_a(time_s), box_b(time_s))
        if gap_m <= TOUCH_M:
            return time_s
        if closing_mps <= 0.0:
            return None
        time_s += gap_m / closing_mps
    return None

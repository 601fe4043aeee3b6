"""How a railway switch lies."""

from enum import StrEnum


class SwitchState(StrEnum):
    """Which branch a switch connects to its stem; ``MOVING`` connects none, ``UNKNOWN`` is an observer's answer."""

    STRAIGHT = "straight"
    DIVERGING = "diverging"
    MOVING = "moving"
    UNKNOWN = "unknown"

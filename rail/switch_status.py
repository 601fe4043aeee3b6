"""How a switch shows its state: the white spot on its notch, and paper R's table 2 that reads it."""

from contracts import Compass, SwitchState
from contracts.motion import compass
from rail.curves import Pose2
from rail.plant import Side, Switch

# Paper R, table 2: the branch (left or right, as seen from a vehicle under way in that direction, along the switch in
# either sense) on which the switch lies, for switch flag 0 (spot hidden) and 1 (spot visible).
TABLE_2: dict[tuple[Compass, bool], Side] = {
    (Compass.NORTH, False): Side.RIGHT,
    (Compass.NORTH, True): Side.LEFT,
    (Compass.SOUTH, False): Side.LEFT,
    (Compass.SOUTH, True): Side.RIGHT,
    (Compass.WEST, False): Side.RIGHT,
    (Compass.WEST, True): Side.LEFT,
    (Compass.EAST, False): Side.LEFT,
    (Compass.EAST, True): Side.RIGHT,
}


def spot_state(toe: Pose2, diverging_side: Side) -> SwitchState:
    """The state in which the spot shows: the switch then lies to its branch on the south or west side.

    toe: pose looking from the stem into the branches. South counts for switches that run west-east, west for others.
    """
    south_or_west = Side.RIGHT if compass(toe.heading_rad) in (Compass.EAST, Compass.SOUTH) else Side.LEFT
    return SwitchState.DIVERGING if diverging_side is south_or_west else SwitchState.STRAIGHT


def spot_visible(switch: Switch, state: SwitchState) -> bool:
    """Whether the white spot shows (switch flag 1) while the switch is in ``state``; never while it moves."""
    return state is switch.spot_state


def status_from_flag(direction: Compass, spot_is_visible: bool) -> Side:
    """Table 2: the side, as seen from a vehicle under way in ``direction``, of the branch that the switch lies to."""
    return TABLE_2[direction, spot_is_visible]

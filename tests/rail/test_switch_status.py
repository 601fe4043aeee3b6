from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from contracts import Compass, SwitchState
from contracts.motion import compass
from rail.curves import Pose2
from rail.plant import Side
from rail.switch_status import TABLE_2, spot_state, spot_visible, status_from_flag
from scenarios.plant_file import load_plant, plant_names

OTHER = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT}
OPPOSITE = {
    Compass.NORTH: Compass.SOUTH,
    Compass.SOUTH: Compass.NORTH,
    Compass.EAST: Compass.WEST,
    Compass.WEST: Compass.EAST,
}
SWITCHES = [
    pytest.param(switch, id=f"{name}-{switch.id}")
    for name in plant_names()
    for switch in load_plant(name).switches.values()
]


@pytest.mark.parametrize("state", [SwitchState.STRAIGHT, SwitchState.DIVERGING])
@pytest.mark.parametrize("switch", SWITCHES)
def test_table_2_and_the_geometry_agree(switch, state):
    facing_side = switch.diverging_side if state is SwitchState.DIVERGING else OTHER[switch.diverging_side]
    flag = spot_visible(switch, state)
    facing = compass(switch.toe.heading_rad)
    assert status_from_flag(facing, flag) is facing_side
    assert status_from_flag(OPPOSITE[facing], flag) is OTHER[facing_side]  # the same branch for one who comes out of it


@pytest.mark.parametrize("switch", SWITCHES)
def test_the_spot_shows_in_exactly_one_position(switch):
    shows = [spot_visible(switch, state) for state in (SwitchState.STRAIGHT, SwitchState.DIVERGING)]
    assert sorted(shows) == [False, True]
    assert not spot_visible(switch, SwitchState.MOVING)
    assert not spot_visible(switch, SwitchState.UNKNOWN)


def test_table_2_is_complete_and_each_flag_means_one_branch():
    assert set(TABLE_2) == {(direction, flag) for direction in Compass for flag in (False, True)}
    assert all(TABLE_2[direction, True] is OTHER[TABLE_2[direction, False]] for direction in Compass)


@given(st.floats(-10.0, 10.0))
def test_looking_back_is_the_opposite_direction(heading_rad):
    assert compass(heading_rad + pi) is OPPOSITE[compass(heading_rad)]


@pytest.mark.parametrize(
    ("heading_deg", "south_or_west"),
    [(0.0, Side.RIGHT), (90.0, Side.LEFT), (180.0, Side.LEFT), (-90.0, Side.RIGHT)],
)
def test_the_flag_is_up_when_the_switch_lies_south_or_west(heading_deg, south_or_west):
    toe = Pose2(0.0, 0.0, heading_deg * pi / 180.0)
    assert spot_state(toe, south_or_west) is SwitchState.DIVERGING
    assert spot_state(toe, OTHER[south_or_west]) is SwitchState.STRAIGHT

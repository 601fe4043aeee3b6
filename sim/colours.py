"""The vehicles' colours: saturated and far apart in hue, because a vehicle's colour is its identity."""

from enum import StrEnum


class Colour(StrEnum):
    """Names of the palette. Yellow is left to the control points on the floor."""

    RED = "red"
    ORANGE = "orange"
    LIME = "lime"
    GREEN = "green"
    CYAN = "cyan"
    BLUE = "blue"
    VIOLET = "violet"
    MAGENTA = "magenta"

    @property
    def srgb(self) -> tuple[int, int, int]:
        """Red, green, blue of the paint, 0..255."""
        return PALETTE[self]


PALETTE: dict[Colour, tuple[int, int, int]] = {
    Colour.RED: (210, 20, 20),  # hue 0 deg
    Colour.ORANGE: (225, 110, 10),  # 28 deg
    Colour.LIME: (130, 205, 15),  # 84 deg
    Colour.GREEN: (15, 160, 60),  # 139 deg
    Colour.CYAN: (10, 175, 185),  # 184 deg
    Colour.BLUE: (20, 75, 215),  # 223 deg
    Colour.VIOLET: (115, 30, 200),  # 270 deg
    Colour.MAGENTA: (215, 20, 150),  # 320 deg
}

"""The model railway as geometry and graph. No pixels, no motion.

A plant is made from its specification by ``rail.build.build_plant``; ``rail.graph`` moves along it,
``rail.routes`` measures it.
"""

from rail.build import build_plant
from rail.curves import Bend, Curve, Pose2
from rail.graph import Advance, Block, BlockedBy, Location, Passage, SwitchAhead
from rail.plant import Balise, BufferStop, Crossing, End, Plant, Port, Section, Side, Switch
from rail.spec import PlantSpec

__all__ = [
    "Advance",
    "Balise",
    "Bend",
    "Block",
    "BlockedBy",
    "BufferStop",
    "Crossing",
    "Curve",
    "End",
    "Location",
    "Passage",
    "Plant",
    "PlantSpec",
    "Port",
    "Pose2",
    "Section",
    "Side",
    "Switch",
    "SwitchAhead",
    "build_plant",
]

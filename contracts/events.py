"""Things that happen at a moment."""

from dataclasses import dataclass
from enum import StrEnum


class EventKind(StrEnum):
    """What happened."""

    CONTACT = "contact"  # two vehicles touch; subjects: both ids, sorted
    BALISE = "balise"  # a vehicle passes a balise; subjects: vehicle; detail: the code, four hexadecimal digits
    SWITCH = "switch"  # a switch reaches or leaves a position; subjects: switch; detail: the SwitchState
    DERAIL = "derail"  # a vehicle runs into a buffer stop or a switch that lies against it; subjects: vehicle


@dataclass(frozen=True)
class Event:
    """Something that happened at ``time_ns``, which may lie between two frames."""

    time_ns: int
    kind: EventKind
    subjects: tuple[str, ...]
    detail: str = ""

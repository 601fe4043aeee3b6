"""From what an author says (``rail.spec``) to a checked plant: geometry, then joints, then what lies on the track."""

from collections.abc import Iterable, Mapping
from math import degrees, hypot

import numpy as np

from contracts import FloatArray, InputError
from rail.crossings import crossings_of
from rail.curves import Pose2, wrapped
from rail.placement import owner_of, place_sections, port_named
from rail.plant import Balise, BufferStop, End, Plant, Port, Section, Side, Switch, known
from rail.spec import BaliseSpec, PlantSpec, SectionSpec, SwitchSpec
from rail.switch_status import spot_state

MAX_GAP_M = 1e-4
MAX_KINK_DEG = 0.1
PARTING_M = 0.15  # so far from the toe the branches are compared to tell left from right
SPOT_BACK_M = 0.02  # the notch's spot lies so far before the toe
SPOT_ASIDE_M = 0.045  # and so far beside the track's centre line: clear of a vehicle 60 mm wide
SPOT_CLEARANCE_M = 0.04
CODES = 1 << 16


def build_plant(spec: PlantSpec, name: str) -> Plant:
    """The plant that ``spec`` describes.

    Raises InputError, naming the items and sizes, for unknown names, circular placement, gaps above 0.1 mm, kinks above
    0.1 degrees, curves tighter than allowed, dangling or doubly used ports, tracks that cross undeclared, switch spots
    in the way of vehicles, duplicate or impossible balise codes and balises off their section.
    """
    sections = place_sections(spec.section)
    _check_radii(sections, spec.min_radius_m)
    switches = {id_: _switch(id_, switch, sections) for id_, switch in spec.switch.items()}
    joints = _joints(spec, sections, switches)
    buffers = {id_: _buffer(id_, buffer.port, sections) for id_, buffer in spec.buffer.items()}
    _check_ports(sections, switches, joints, buffers)
    points_m = {id_: section.curve.points(0.01) for id_, section in sections.items()}
    _check_spots(switches, points_m)
    all_m = np.concatenate(list(points_m.values()))
    low, high = all_m.min(axis=0).tolist(), all_m.max(axis=0).tolist()
    return Plant(
        name=name,
        sections=sections,
        switches=switches,
        crossings=crossings_of(spec.crossing, sections),
        buffers=buffers,
        balises=_balises(spec.balise, sections),
        joints=joints,
        bounds_m=(low[0], low[1], high[0], high[1]),
    )


def _check_radii(sections: Mapping[str, Section], min_radius_m: float) -> None:
    for section in sections.values():
        if section.curve.min_radius_m < min_radius_m - 1e-9:
            raise InputError(
                f"section {section.id!r} bends with a radius of {section.curve.min_radius_m:.3f} m, less than "
                f"min_radius_m = {min_radius_m}; give it more room"
            )


def _check_joint(a: Port, b: Port, sections: Mapping[str, Section], where: str) -> None:
    """Refuse a gap or a kink between two ports that should meet face to face."""
    pose, other = sections[a.section].pose_out_of(a.end), sections[b.section].pose_out_of(b.end).reversed()
    gap_m = hypot(other.x_m - pose.x_m, other.y_m - pose.y_m)
    kink_deg = abs(degrees(wrapped(other.heading_rad - pose.heading_rad)))
    way_out = "correct the lengths, or end one of them with { close = true }"
    if gap_m > MAX_GAP_M:
        raise InputError(f"{where}: {a} and {b} are {1e3 * gap_m:.2f} mm apart (at most 0.1 mm); {way_out}")
    if kink_deg > MAX_KINK_DEG:
        raise InputError(f"{where}: {a} and {b} meet with a kink of {kink_deg:.2f} deg (at most 0.1); {way_out}")


def _switch(id_: str, spec: SwitchSpec, sections: Mapping[str, Section]) -> Switch:
    owner = f"switch {id_!r}"
    stem, straight, diverging = (port_named(p, sections, owner) for p in (spec.stem, spec.straight, spec.diverging))
    for branch in (straight, diverging):
        _check_joint(stem, branch, sections, owner)
    toe = sections[stem.section].pose_out_of(stem.end)
    parting_m = min(PARTING_M, sections[straight.section].length_m, sections[diverging.section].length_m)
    inside = [_inside(sections[port.section], port.end, parting_m) for port in (diverging, straight)]
    left_m = [toe.left_of(pose.x_m, pose.y_m) for pose in inside]
    if abs(left_m[0] - left_m[1]) < 1e-3:
        raise InputError(f"{owner}: its branches {straight} and {diverging} have not parted {parting_m} m from the toe")
    side = Side.LEFT if left_m[0] > left_m[1] else Side.RIGHT
    spot_side = spec.spot_side or (Side.RIGHT if side is Side.LEFT else Side.LEFT)
    spot_m = toe.offset(-SPOT_BACK_M, SPOT_ASIDE_M if spot_side is Side.LEFT else -SPOT_ASIDE_M)
    return Switch(id_, stem, straight, diverging, toe, side, spot_m, spot_state(toe, side))


def _inside(section: Section, end: End, distance_m: float) -> Pose2:
    return section.curve.pose_at(distance_m if end is End.START else section.length_m - distance_m)


def _check_spots(switches: Mapping[str, Switch], points_m: Mapping[str, FloatArray]) -> None:
    """No vehicle may run over a notch; ``points_m`` are (N, 2) of each section."""
    for switch in switches.values():
        for id_, track_m in points_m.items():
            distance_m = float(np.linalg.norm(track_m - switch.spot_m, axis=1).min())
            if distance_m < SPOT_CLEARANCE_M:
                raise InputError(
                    f"switch {switch.id!r}: its spot stands {1e3 * distance_m:.0f} mm from section {id_!r}, in the way "
                    "of vehicles; choose the other spot_side"
                )


def _joints(spec: PlantSpec, sections: Mapping[str, Section], switches: Mapping[str, Switch]) -> dict[Port, Port]:
    """Simple joints, both ways: each ``after`` and ``to`` that is not a switch's business."""
    switched = {port for switch in switches.values() for port in switch.ports}
    joints: dict[Port, Port] = {}
    for id_, section in spec.section.items():
        for own, named in _neighbours(id_, section, sections):
            if own in switched and named in switched:
                continue
            _check_joint(own, named, sections, owner_of(id_))
            for port, other in ((own, named), (named, own)):
                if joints.setdefault(port, other) != other:
                    raise InputError(f"port {port} is joined to both {joints[port]} and {other}; a switch joins three")
    return joints


def _neighbours(id_: str, spec: SectionSpec, sections: Mapping[str, Section]) -> list[tuple[Port, Port]]:
    named = ((End.START, spec.after), (End.END, spec.to))
    return [(Port(id_, end), port_named(text, sections, owner_of(id_))) for end, text in named if text is not None]


def _buffer(id_: str, port_text: str, sections: Mapping[str, Section]) -> BufferStop:
    port = port_named(port_text, sections, f"buffer {id_!r}")
    return BufferStop(id_, port, sections[port.section].pose_out_of(port.end))


def _check_ports(
    sections: Mapping[str, Section],
    switches: Mapping[str, Switch],
    joints: Mapping[Port, Port],
    buffers: Mapping[str, BufferStop],
) -> None:
    """Every port is used exactly once: by a joint, a switch or a buffer stop."""
    users: dict[Port, list[str]] = {Port(id_, end): [] for id_ in sections for end in End}
    for port, other in joints.items():
        users[port].append(f"the joint with {other}")
    for switch in switches.values():
        for port in switch.ports:
            users[port].append(f"switch {switch.id!r}")
    for buffer in buffers.values():
        users[buffer.port].append(f"buffer {buffer.id!r}")
    for port, by in users.items():
        if not by:
            raise InputError(f"port {port} leads nowhere; join it by 'to' or 'after', or give it a switch or a buffer")
        if len(by) > 1:
            raise InputError(f"port {port} is used by {' and by '.join(by)}; only one of them can have it")


def _balises(specs: Iterable[BaliseSpec], sections: Mapping[str, Section]) -> tuple[Balise, ...]:
    balises: dict[int, Balise] = {}
    for spec in specs:
        what = f"balise {spec.code:#06x}"
        if not 0 <= spec.code < CODES:
            raise InputError(f"{what}: a code has 16 bits, 0 to {CODES - 1:#06x}")
        length_m = sections[known(spec.section, sections, f"{what}: section")].length_m
        if not 0.0 < spec.offset_m < length_m:
            raise InputError(
                f"{what}: offset {spec.offset_m} m lies not within section {spec.section!r}, 0 to {length_m:.3f} m"
            )
        if other := balises.get(spec.code):
            raise InputError(f"{what} lies both on section {other.section!r} and {spec.section!r}; codes are unique")
        balises[spec.code] = Balise(spec.code, spec.section, spec.offset_m)
    return tuple(balises.values())

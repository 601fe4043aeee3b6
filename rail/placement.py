"""Where each section lies: placed by its author, or from the port that it continues or leads to."""

from collections.abc import Iterable, Mapping

from contracts import InputError
from rail.curves import Bend, Curve, Pose2
from rail.pieces import biarc
from rail.plant import End, Port, Section, known
from rail.spec import SectionSpec


def place_sections(specs: Mapping[str, SectionSpec]) -> dict[str, Section]:
    """All sections in their place; InputError for unknown ports, circular placement and impossible pieces."""
    if not specs:
        raise InputError("a plant needs at least one section")
    placer = _Placer(specs)
    return {id_: Section(id_, placer.curve(id_)) for id_ in specs}


def port_named(text: str, sections: Iterable[str], owner: str) -> Port:
    """The port that ``text`` such as ``"north.end"`` names; InputError that says what would do."""
    section, _, end = text.rpartition(".")
    if end not in (End.START, End.END):
        raise InputError(f"{owner}: {text!r} is no port; write SECTION.start or SECTION.end")
    return Port(known(section, sections, f"{owner}: port {text!r}: section"), End(end))


def owner_of(section: str) -> str:
    """How messages call a section."""
    return f"section {section!r}"


class _Placer:
    """Finds every section's curve, each from the port that it continues or leads to."""

    def __init__(self, specs: Mapping[str, SectionSpec]) -> None:
        self._specs = specs
        self._curves: dict[str, Curve] = {}
        self._open: list[str] = []  # what is being placed, to find circles

    def curve(self, id_: str) -> Curve:
        """The section's curve, found once."""
        if id_ not in self._curves:
            self._curves[id_] = self._found(id_)
        return self._curves[id_]

    def _found(self, id_: str) -> Curve:
        start, bends = self._start(id_), list[Bend]()
        for number, piece in enumerate(self._specs[id_].pieces, start=1):
            here = Curve(start, tuple(bends)).end if bends else start
            try:
                bends += self._closing(id_, here) if piece.close else piece.bends()
            except InputError as error:
                raise InputError(f"{owner_of(id_)}, piece {number}: {error}") from error
        if not bends:
            raise InputError(f"{owner_of(id_)} has no pieces; give it at least one")
        return Curve(start, tuple(bends))

    def _start(self, id_: str) -> Pose2:
        spec = self._specs[id_]
        if (spec.at is None) == (spec.after is None):
            raise InputError(f"{owner_of(id_)} needs either a pose 'at' or a port 'after' which it begins, not both")
        return spec.at.pose if spec.at else self._pose_out_of(str(spec.after), id_)

    def _closing(self, id_: str, here: Pose2) -> tuple[Bend, ...]:
        to = self._specs[id_].to
        if to is None:
            raise InputError("close = true needs the port 'to' which the section leads")
        return biarc(here, self._pose_out_of(to, id_).reversed())

    def _pose_out_of(self, port_text: str, asking: str) -> Pose2:
        """Pose of a vehicle that leaves through the named port, for the section ``asking`` to go on from."""
        port = port_named(port_text, self._specs, owner_of(asking))
        if asking in self._open:
            circle = " after ".join([*self._open[self._open.index(asking) :], asking])
            raise InputError(f"sections are placed in a circle ({circle}); give one of them a pose 'at'")
        self._open.append(asking)
        try:
            return self.curve(port.section).end if port.end is End.END else self._start(port.section).reversed()
        finally:
            self._open.pop()

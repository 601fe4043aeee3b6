"""What the contracts of all stages have in common: it can be made, answers in its own type, and repeats itself."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar

from bench.ledger import value_hash
from bench.plugins import require_methods
from contracts import InputError


class Titled(Protocol):
    """Anything that a stage is shown."""

    @property
    def title(self) -> str:
        """Its name in messages."""
        ...


Shown = TypeVar("Shown", bound=Titled)
T = TypeVar("T")


@dataclass(frozen=True)
class Finding:
    """A law that is broken: its short name, and what happened."""

    law: str
    sentence: str

    def __str__(self) -> str:
        return f"{self.law}: {self.sentence}"


class BrokenLawError(Exception):
    """A law is broken so badly that the following ones cannot be tried."""

    def __init__(self, law: str, sentence: str) -> None:
        super().__init__(sentence)
        self.finding = Finding(law, sentence)


def findings_of(found: Iterator[Finding]) -> list[Finding]:
    """All that ``found`` yields, and the broken law that ended it."""
    findings = []
    try:
        for finding in found:
            findings.append(finding)
    except BrokenLawError as broken:
        findings.append(broken.finding)
    return findings


def made(factory: Callable[[], object], protocol: type) -> Iterator[Finding]:
    """That it can be made, and has every method of its stage."""
    try:
        subject = factory()
    except Exception as error:
        raise BrokenLawError("made", f"It cannot be made without arguments: {_told(error)}.") from error
    try:
        require_methods(subject, protocol, name=type(subject).__name__)
    except InputError as error:
        yield Finding("methods", f"{error}.")


def repeats(
    factory: Callable[[], Any], scenes: Sequence[Shown], answer: Callable[[object, Shown], object]
) -> Iterator[Finding]:
    """What must hold of the same frames seen again."""

    def answer_hash(subject: object, scene: Shown) -> str:
        return value_hash(answer(subject, scene))

    subject = factory()
    first = [answer_hash(subject, scene) for scene in scenes]
    subject.reset()
    if [answer_hash(subject, scene) for scene in scenes] != first:
        yield Finding("reset", "After reset() it gives other answers to the same frames than at first.")
    second = factory()
    if [answer_hash(second, scene) for scene in scenes] != first:
        yield Finding("same again", "A second instance gives other answers to the same frames.")
        return
    pair = factory(), factory()
    if any({answer_hash(one, scene) for one in pair} != {alone} for scene, alone in zip(scenes, first, strict=True)):
        yield Finding("alone", "Two instances that take turns give other answers than each alone: they share a state.")


def answer_of(subject: object, scene: Shown, act: Callable[[Any, Shown], object], kind: type[T]) -> T:
    """What ``subject`` answers to ``scene``, which must be a ``kind``."""
    try:
        given = act(subject, scene)
    except Exception as error:
        if "read-only" in str(error):
            raise BrokenLawError("frame untouched", f"It tries to write into {scene.title}: {error}.") from error
        raise BrokenLawError("runs", f"It fails on {scene.title}: {_told(error)}.") from error
    if not isinstance(given, kind):
        told = f"It answered {type(given).__name__} to {scene.title}, not {kind.__name__}."
        raise BrokenLawError("answer", told)
    return given


def _told(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".rstrip(".")

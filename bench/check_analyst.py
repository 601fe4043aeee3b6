"""The contract of an analyst, tried out on small made-up ground tracks."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.check_laws import Finding, answer_of, findings_of, made, repeats
from bench.ledger import value_hash
from contracts import Analyst, GroundTracks, Motions
from contracts.ground import FUSED

PERIOD_NS = 40_000_000


@dataclass(frozen=True)
class Moment:
    """The ground tracks of one moment, and its name in messages."""

    title: str
    ground: GroundTracks


def check_analyst(factory: Callable[[], Analyst]) -> list[Finding]:
    """Broken laws of the analyst that ``factory`` makes; empty if all hold."""

    def answer(subject: object, moment: Moment) -> Motions:
        return answer_of(subject, moment, lambda analyst, shown: analyst.analyse(shown.ground), Motions)

    unmade = findings_of(made(factory, Analyst))
    if unmade:
        return unmade
    findings = findings_of(_laws(factory, _drive(), answer)) or findings_of(repeats(factory, _drive(), answer))
    return list(dict.fromkeys(findings))


def _drive(count: int = 20) -> list[Moment]:
    """One vehicle stands, one drives a curve, one is now and then without a place or not there; at last nobody is."""
    moments = []
    for index in range(count):
        turned = 0.06 * index
        places_m = np.array([[0.2, 0.1], [np.cos(turned), np.sin(turned)], [0.02 * index, -0.5]])
        placed = np.array([True, True, index % 5 != 2])
        places_m[~placed] = np.nan
        covs_m2 = np.where(placed[:, None, None], 1e-6 * np.eye(2), np.nan)
        rows = [] if index == count - 1 else [2, 0, 1] if index % 7 else [0, 1]
        labels = tuple(np.array(["red", "blue", "green"])[rows].tolist()) if rows else ()
        ground = GroundTracks(
            FUSED, index * PERIOD_NS, np.array([4, 9, 6])[rows], labels, places_m[rows], covs_m2[rows], placed[rows]
        )
        moments.append(Moment(f"moment {index} of a plain drive", ground))
    return moments


def _laws(
    factory: Callable[[], Any], moments: Sequence[Moment], answer: Callable[[object, Moment], Motions]
) -> Iterator[Finding]:
    """What must hold of every single answer."""
    subject = factory()
    for moment in moments:
        before = value_hash(moment.ground)
        given = answer(subject, moment)
        if value_hash(moment.ground) != before:
            yield Finding("tracks untouched", f"It changed the tracks of {moment.title}.")
        yield from _copied(given, moment)
        yield from _well_formed(given, moment)


def _copied(given: Motions, moment: Moment) -> Iterator[Finding]:
    wanted = Motions.unknown(moment.ground)
    for name in ("time_ns", "ids", "labels"):
        if not np.array_equal(getattr(given, name), getattr(wanted, name)):
            told = (
                f"It answered {name} {getattr(given, name)!r} to {moment.title}, whose are {getattr(wanted, name)!r}."
            )
            yield Finding("copied", told)


def _well_formed(given: Motions, moment: Moment) -> Iterator[Finding]:
    """What the type itself does not enforce."""
    velocities, covs = given.velocities_mps[given.valid], given.velocity_covs_m2ps2[given.valid]
    if not (np.isfinite(velocities).all() and np.isfinite(covs).all()):
        yield Finding("well formed", f"It called a velocity valid that is not finite, in {moment.title}.")
    elif len(covs) and (not np.allclose(covs, np.swapaxes(covs, 1, 2)) or np.linalg.eigvalsh(covs).min() < -1e-9):
        yield Finding("well formed", f"It gave a velocity_covs_m2ps2 in {moment.title} that is no covariance.")

"""Holds a run against the ``[expect]`` of its scenario."""

from collections.abc import Iterable, Iterator, Sequence

from bench.recording import Recording
from bench.scores import Score, by_name, unit_text, value_text
from bench.scoring.contacts import contact_pairs
from contracts import EventKind
from scenarios.schema import Bound, Expect


def check(expect: Expect, scores: Sequence[Score], recording: Recording) -> list[str]:
    """What the run did not keep, one sentence each; empty if it kept everything.

    Contacts and derailments are read from the truth. Limits of scores are held where something was filmed: a run of
    the truth alone measures nothing. There a score without a value fails, for it does not show what it should.
    """
    return [
        *_contact_failures(expect, recording),
        *_derail_failures(expect, recording),
        *(_score_failures(expect.scores, scores) if was_filmed(recording) else ()),
    ]


def was_filmed(recording: Recording) -> bool:
    """Whether any camera saw the world of this run."""
    return any(step.truth is not None and step.truth.cameras for step in recording.steps)


def _contact_failures(expect: Expect, recording: Recording) -> Iterator[str]:
    wanted = {tuple(sorted(pair)) for pair in expect.contact}
    seen = contact_pairs(recording)
    yield from (f"{_joined(pair)} were expected to touch and did not" for pair in sorted(wanted - seen))
    yield from (f"{_joined(pair)} touched, which was not expected" for pair in sorted(seen - wanted))


def _derail_failures(expect: Expect, recording: Recording) -> Iterator[str]:
    events = (event for step in recording.steps if step.truth is not None for event in step.truth.events)
    seen = {event.subjects[0] for event in events if event.kind is EventKind.DERAIL}
    wanted = set(expect.derail)
    yield from (f"{name} was expected to derail and did not" for name in sorted(wanted - seen))
    yield from (f"{name} derailed, which was not expected" for name in sorted(seen - wanted))


def _score_failures(bounds: dict[str, Bound], scores: Sequence[Score]) -> Iterator[str]:
    named = by_name(scores)
    for name, bound in bounds.items():
        score = named.get(name)
        if score is None:
            yield f"{name} was expected to be {_limits(bound)}, but there is no such score"
        elif score.value is None:
            yield f"{name} was expected to be {_limits(bound)}, but has no value: nothing was there to measure"
        elif not bound.holds(score.value):
            shown = f"{value_text(score)} {unit_text(score)}".rstrip()
            yield f"{name} is {shown}, expected {_limits(bound)} (n = {score.n})"


def _limits(bound: Bound) -> str:
    parts = []
    if bound.min is not None:
        parts.append(f"at least {bound.min:g}")
    if bound.max is not None:
        parts.append(f"at most {bound.max:g}")
    return " and ".join(parts)


def _joined(names: Iterable[str]) -> str:
    return " and ".join(names)

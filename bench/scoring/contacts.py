"""What really touched: the contacts of the truth, against which warnings are judged."""

from bench.recording import Recording
from bench.scores import Score
from contracts import Event, EventKind


def contacts(recording: Recording) -> tuple[Event, ...]:
    """Every contact of two vehicles, in order; a contact shorter than a frame is among them."""
    truths = (step.truth for step in recording.steps if step.truth is not None)
    return tuple(event for truth in truths for event in truth.events if event.kind is EventKind.CONTACT)


def contact_pairs(recording: Recording) -> set[tuple[str, ...]]:
    """The pairs of vehicles that touched at least once, each sorted."""
    return {tuple(sorted(event.subjects)) for event in contacts(recording)}


def contact_scores(recording: Recording) -> list[Score]:
    """Number of contacts and of pairs that touched, over the frames that have a truth."""
    frames = sum(step.truth is not None for step in recording.steps)
    return [
        Score.of("contact.count", len(contacts(recording)), "count", frames),
        Score.of("contact.pairs", len(contact_pairs(recording)), "count", frames),
    ]

"""The contract kit for analysts: who obeys has no finding, and every law can be broken."""

from dataclasses import replace

import numpy as np
import pytest

from bench.check import check_plugin
from bench.check_analyst import check_analyst
from contracts import Motions
from georef.motion import WindowAnalyst


def laws(factory):
    return {finding.law for finding in check_analyst(factory)}


def changed(**fields):
    """An analyst class whose answers have other fields; each value is a function of the answer."""

    class Changed(WindowAnalyst):
        def analyse(self, ground):
            answer = super().analyse(ground)
            return replace(answer, **{name: make(answer) for name, make in fields.items()})

    return Changed


class Silent:
    """Knows nothing and obeys every law."""

    def analyse(self, ground):
        return Motions.unknown(ground)

    def reset(self):
        pass


@pytest.mark.parametrize("factory", [WindowAnalyst, Silent])
def test_whoever_obeys_has_no_findings(factory):
    assert check_analyst(factory) == []
    assert check_plugin("analyst", "georef.motion:WindowAnalyst") == []


@pytest.mark.parametrize(
    ("fields", "law"),
    [
        ({"time_ns": lambda answer: answer.time_ns + 1}, "copied"),
        ({"ids": lambda answer: answer.ids + 1}, "copied"),
        ({"labels": lambda answer: ("x",) * len(answer)}, "copied"),
        ({"valid": lambda answer: np.ones(len(answer), bool)}, "well formed"),
        ({"velocity_covs_m2ps2": lambda answer: -answer.velocity_covs_m2ps2}, "well formed"),
        ({"velocities_mps": lambda answer: answer.velocities_mps[:, :1]}, "runs"),
    ],
)
def test_an_answer_that_breaks_a_law_is_found(fields, law):
    assert law in laws(changed(**fields))


def test_what_is_not_forgotten_is_found():
    class Elephant(WindowAnalyst):
        def reset(self):
            pass

    assert laws(Elephant) & {"reset", "runs"}


def test_a_state_that_is_shared_is_found():
    shared = WindowAnalyst()

    class Shared(Silent):
        def analyse(self, ground):
            return shared.analyse(ground) if shared._time_ns != ground.time_ns else Motions.unknown(ground)

        def reset(self):
            shared.reset()

    assert laws(Shared)


def test_an_answer_of_another_type_is_found():
    class Wordy(Silent):
        def analyse(self, ground):
            return "east"

    assert laws(Wordy) == {"answer"}


def test_what_cannot_be_made_or_lacks_methods_is_found():
    assert laws(lambda: 1 / 0) == {"made"}
    assert laws(object) == {"methods"}

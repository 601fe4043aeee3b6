import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.codec import decode, encode, json_schema
from bench.recording import LedgerEntry, Manifest, RecordedStep
from contracts import Detections, GroundTracks, InputError, Tracks
from contracts.truth import Truth
from tests.bench import strategies
from tests.bench.equality import same


@pytest.mark.parametrize(
    ("kind", "values"),
    [
        (Tracks, strategies.tracks()),
        (GroundTracks, strategies.ground_tracks()),
        (Truth, strategies.truths()),
        (Manifest, strategies.manifests()),
        (Detections, strategies.detections()),
        (RecordedStep, strategies.steps_with_frames().map(lambda pair: pair[0])),
        (LedgerEntry, st.builds(LedgerEntry)),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
@settings(max_examples=20)
@given(data=st.data())
def test_what_is_read_back_equals_what_was_written_to_the_bit(kind, values, data):
    value = data.draw(values)
    assert same(decode(encode(value), kind), value)


@settings(max_examples=10)
@given(strategies.truths())
def test_the_schema_describes_what_is_written(truth):
    assert set(json_schema(Truth)["properties"]) == {field.name for field in dataclasses.fields(truth)}


def test_a_schema_is_an_object_without_references():
    schema = json_schema(Manifest)
    assert schema["type"] == "object"
    assert "$ref" not in str(schema)


def test_infinity_is_refused():
    ground = GroundTracks("west", 0, [1], ("red",), [[np.inf, 0]], np.zeros((1, 2, 2)), [True])
    with pytest.raises(InputError, match="infinity"):
        encode(ground)


def test_what_has_no_json_form_is_refused():
    with pytest.raises(InputError, match="dict cannot be recorded: object has no JSON form"):
        encode({"a": object()})


@pytest.mark.parametrize("data", [b"", b"[]", b"{}", b"\xff", b'{"ids": [1, 2], "objects": {}}'])
def test_what_does_not_fit_is_named(data):
    with pytest.raises(InputError, match="Tracks cannot be read"):
        decode(data, Tracks)


def test_a_value_that_its_own_type_refuses_is_refused():
    twice = encode(Tracks([], Detections.empty("west", 0, 0))).replace(b'"ids":[]', b'"ids":[1]')
    with pytest.raises(InputError, match=r"Tracks\.ids has shape"):
        decode(twice, Tracks)

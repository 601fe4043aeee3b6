"""The form of a score, and its way to a file and back."""

import io
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from bench.scores import Score, by_name, from_json, read_scores, table, to_json, value_text, write_scores
from contracts import InputError

scores = st.builds(Score.of, st.text(), st.floats(), st.sampled_from(["m", "1", "px", "count"]), st.integers(0, 10**9))


@given(st.lists(scores))
def test_scores_come_back_from_json(original):
    assert list(from_json(to_json(original))) == original


@given(scores)
def test_json_holds_five_keys_and_null_for_what_is_not_known(score):
    (row,) = json.loads(to_json([score]))
    assert list(row) == ["name", "value", "unit", "n", "valid"]
    assert (row["value"] is None) == (not row["valid"])


@given(st.floats())
def test_a_score_without_a_population_is_not_valid(value):
    score = Score.of("detection.recall", value, "1", 0)
    assert not score.valid
    assert score.value is None


@pytest.mark.parametrize(
    ("value", "valid", "n"), [(None, True, 3), (0.0, False, 3), (float("nan"), True, 3), (1.0, True, -1)]
)
def test_contradictory_scores_are_refused(value, valid, n):
    with pytest.raises(InputError, match=r"ground\.mean_m"):
        Score("ground.mean_m", value, "m", n, valid)


def test_two_scores_of_one_name_are_refused():
    score = Score.of("a", 1.0, "m", 1)
    with pytest.raises(InputError, match="named a"):
        by_name([score, score])


@pytest.mark.parametrize(
    "text", ["", "{}", '[{"name": "a"}]', '[{"name":"a","value":"1","unit":"m","n":1,"valid":true}]']
)
def test_a_broken_file_is_named(tmp_path, text):
    path = tmp_path / "scores.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"scores\.json"):
        read_scores(path)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"scores\.json"):
        read_scores(tmp_path / "scores.json")


def test_a_file_comes_back(tmp_path):
    original = (Score.of("a.b", 0.25, "m", 4), Score.of("c", 0.0, "1", 0))
    write_scores(tmp_path / "scores.json", original)
    assert read_scores(tmp_path / "scores.json") == original


def test_values_are_read_easily():
    assert value_text(Score.of("a", 0.00123456, "m", 1)) == "0.001235"
    assert value_text(Score.of("a", 3.0, "count", 1)) == "3"
    assert value_text(Score.of("a", 0.0, "m", 0)) == "—"


def test_the_table_names_every_score():
    console = Console(width=100, record=True, file=io.StringIO())
    console.print(table([Score.of("a.b", 0.25, "m", 4), Score.of("c.d", 0.0, "1", 0)], title="scores"))
    text = console.export_text()
    assert "a.b" in text
    assert "c.d" in text

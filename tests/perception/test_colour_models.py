from dataclasses import replace

import msgspec
import numpy as np
import pytest

from contracts import InputError
from perception.colour_models import ColourModels
from perception.hue_saturation import SHAPE


def test_what_is_saved_is_loaded(models, tmp_path):
    path = tmp_path / "models.json"
    models.save(path)
    loaded = ColourModels.load(path)
    for before, after in zip(models.models, loaded.models, strict=True):
        assert np.abs(before.histogram - after.histogram).max() <= 0.5 / 10_000
        assert replace(before, histogram=after.histogram).anchor_moments_px2 == after.anchor_moments_px2
        assert (before.label, before.roof_size_m, before.fill_min) == (after.label, after.roof_size_m, after.fill_min)


def test_saving_what_was_loaded_changes_no_byte(models, tmp_path):
    models.save(tmp_path / "a.json")
    ColourModels.load(tmp_path / "a.json").save(tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"label": ""}, "label"),
        ({"histogram": np.zeros(SHAPE)}, "histogram"),
        ({"histogram": np.zeros((2, 2))}, "histogram"),
        ({"roof_size_m": (4.0, 5.0)}, "roof_size_m"),
        ({"roof_size_m": (float("nan"), 4.0)}, "roof_size_m"),
        ({"fill_min": 1.5}, "fill_min"),
        ({"roof_height_m": float("inf")}, "roof_height_m"),
        ({"anchor_moments_px2": {"both": (1.0, 1.0)}}, "single"),
    ],
)
def test_an_impossible_model_is_refused_by_name(models, change, told):
    with pytest.raises(InputError, match=told):
        replace(models.models[0], **change)


def test_models_are_unique_and_not_none(models):
    with pytest.raises(InputError, match="no model"):
        ColourModels((), 1600.0, 2.8)
    with pytest.raises(InputError, match="unique"):
        ColourModels(models.models[:1] * 2, 1600.0, 2.8)
    with pytest.raises(InputError, match="sees no roof"):
        ColourModels(models.models, 1600.0, 0.01)


def test_a_file_that_is_no_model_is_refused_by_name(models, tmp_path):
    path = tmp_path / "bad.json"
    with pytest.raises(InputError, match=r"bad\.json"):
        ColourModels.load(path)
    path.write_text("{ no json")
    with pytest.raises(InputError, match=r"bad\.json"):
        ColourModels.load(path)
    models.save(path)
    content = msgspec.json.decode(path.read_bytes())
    content["models"][0]["roof_size_m"] = "large"
    path.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=r"bad\.json.*roof_size_m"):
        ColourModels.load(path)
    content["models"][0] |= {"roof_size_m": [2.0, 1.0], "histogram": [[1]]}
    path.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=r"bad\.json.*histogram"):
        ColourModels.load(path)
    content["models"][0]["histogram"] = [[90, 0, 5]]
    path.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=r"bad\.json.*90 x 32"):
        ColourModels.load(path)
    del content["models"][0]["histogram"]
    path.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=r"bad\.json.*histogram"):
        ColourModels.load(path)

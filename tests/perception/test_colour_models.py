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
        assert np.abs(before.histogram - after.histogram).max() <= 0.5
        assert replace(before, histogram=after.histogram).anchor_moments_px2 == after.anchor_moments_px2
        assert (before.label, before.area_px, before.roof_long_px) == (after.label, after.area_px, after.roof_long_px)


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
        ({"area_px": (5.0, 4.0)}, "area_px"),
        ({"roof_long_px": (float("nan"), 4.0)}, "roof_long_px"),
        ({"rectangularity_min": 1.5}, "rectangularity_min"),
        ({"roof_height_m": float("inf")}, "roof_height_m"),
        ({"anchor_moments_px2": {"both": (1.0, 1.0)}}, "single"),
    ],
)
def test_an_impossible_model_is_refused_by_name(models, change, told):
    with pytest.raises(InputError, match=told):
        replace(models.models[0], **change)


def test_models_are_unique_and_not_none(models):
    with pytest.raises(InputError, match="no model"):
        ColourModels(())
    with pytest.raises(InputError, match="unique"):
        ColourModels(models.models[:1] * 2)


def test_a_file_that_is_no_model_is_refused_by_name(models, tmp_path):
    path = tmp_path / "bad.json"
    with pytest.raises(InputError, match=r"bad\.json"):
        ColourModels.load(path)
    path.write_text("{ no json")
    with pytest.raises(InputError, match=r"bad\.json"):
        ColourModels.load(path)
    models.save(path)
    content = msgspec.json.decode(path.read_bytes())
    content["models"][0]["area_px"] = "large"
    path.write_bytes(msgspec.json.encode(content))
    with pytest.raises(InputError, match=r"bad\.json.*area_px"):
        ColourModels.load(path)
    content["models"][0] |= {"area_px": [1.0, 2.0], "histogram": [[1]]}
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

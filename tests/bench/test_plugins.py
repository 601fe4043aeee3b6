import importlib
import sys

import pytest

from bench.plugins import load_factory, load_object, require_methods, short_names
from contracts import Detector, InputError, Tracker

GOOD = """
class Mine:
    def detect(self, frame): ...
    def reset(self): ...
class Half:
    def detect(self, frame): ...
class Outer:
    Inner = Mine
def make(): return Mine()
NUMBER = 3
def nothing(): return None
class Needy(Mine):
    def __init__(self, model): ...
"""


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package ``plug`` on the path."""
    (tmp_path / "plug").mkdir()
    (tmp_path / "plug" / "__init__.py").write_text("")
    (tmp_path / "plug" / "good.py").write_text(GOOD)
    (tmp_path / "plug" / "broken.py").write_text("1 / 0")
    (tmp_path / "plug" / "needy.py").write_text("import surely_not_installed")
    monkeypatch.syspath_prepend(tmp_path)
    yield tmp_path
    for name in [name for name in sys.modules if name.split(".")[0] == "plug"]:
        del sys.modules[name]


def test_a_class_is_found_by_its_path(package):
    assert load_factory("plug.good:Mine", Detector).__name__ == "Mine"


def test_a_nested_name_is_found(package):
    assert load_factory("plug.good:Outer.Inner", Detector).__name__ == "Mine"


def test_a_function_may_make_the_stage(package):
    assert type(load_object("plug.good:make", Detector)).__name__ == "Mine"


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("plug.absent:Mine", "there is no module 'plug.absent' on the path"),
        ("surely.not:Mine", "there is no module 'surely' on the path"),
        ("plug.good:Mime", "plug.good has no 'Mime'; did you mean 'Mine'"),
        ("plug.good:", "plug.good has no ''"),
        (":Mine", "names no module"),
        ("plug.good:NUMBER", "is a int, not a class or function"),
        ("plug.good:Half", r"plug.good:Half is no Detector: it lacks reset\(\)"),
        ("plug.good:Needy", r"plug.good:Needy cannot be made without arguments: TypeError: .*'model'"),
        ("plug.good:nothing", r"plug.good:nothing is no Detector: it lacks detect\(\) and reset\(\)"),
        ("plug.broken:Mine", "importing plug.broken fails: ZeroDivisionError"),
        ("plug.needy:Mine", "plug.needy needs the module 'surely_not_installed', which is not installed"),
        ("mine", "nothing is called 'mine'; give a path such as"),
    ],
)
def test_what_is_wrong_is_said(package, name, message):
    with pytest.raises(InputError, match=message):
        load_object(name, Detector)


def test_an_entry_point_is_found_by_its_short_name(package, monkeypatch):
    info = package / "plug-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plug\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[gantry.detectors]\nmine = plug.good:Mine\n")
    importlib.invalidate_caches()
    assert load_factory("mine", Detector).__name__ == "Mine"
    assert "mine" in short_names(Detector)
    with pytest.raises(InputError, match="nothing is called 'mine'"):
        load_object("mine", Tracker)


def test_missing_methods_are_listed_in_order():
    with pytest.raises(InputError, match=r"it lacks update\(\) and reset\(\)"):
        require_methods(object(), Tracker, name="it")

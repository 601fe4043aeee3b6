from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import msgspec
import numpy as np
import pytest

from contracts import FloatArray, InputError, SwitchState
from scenarios.toml_file import line_of_key, read_toml


@dataclass(frozen=True)
class Wheel:
    radius_m: Annotated[float, msgspec.Meta(gt=0)] = 0.01

    def __post_init__(self) -> None:
        if self.radius_m > 1.0:
            raise InputError(f"a wheel of {self.radius_m} m is no model's; at most 1 m")


@dataclass(frozen=True, eq=False)
class Car:
    id: str
    state: SwitchState = SwitchState.STRAIGHT
    colour: Literal["blue", "red"] = "blue"
    wheels: tuple[Wheel, ...] = ()
    offsets: FloatArray | None = None


@dataclass(frozen=True)
class Train:
    title: str
    length_m: float | None = None
    car: tuple[Car, ...] = ()
    depot: Mapping[str, Car] | None = None
    pair: tuple[int, Wheel] | None = None


def read(folder: Path, text: str) -> Train:
    path = folder / "train.toml"
    path.write_text(text)
    return read_toml(path, Train)


def test_a_good_file_becomes_dataclasses(tmp_path):
    train = read(
        tmp_path,
        """
        title = "express"
        length_m = 2  # a whole number is a length, too
        pair = [1, { radius_m = 0.5 }]

        [[car]]
        id = "a"
        state = "diverging"
        offsets = [1, 2.5]
        wheels = [{ radius_m = 0.02 }, {}]

        [depot.north]
        id = "n"
        """,
    )
    assert train.title == "express"
    assert train.length_m == 2.0
    assert train.pair == (1, Wheel(0.5))
    (car,) = train.car
    assert (car.id, car.state, car.wheels) == ("a", SwitchState.DIVERGING, (Wheel(0.02), Wheel()))
    assert np.array_equal(car.offsets, [1.0, 2.5])
    assert train.depot is not None
    assert train.depot["north"].id == "n"


@pytest.mark.parametrize(
    ("text", "line", "says"),
    [
        ("title = 3", 1, "key title: expected str, got int"),
        ('\ntitle = "x"\nlenght_m = 2', 3, "key lenght_m: unknown key; accepted nearest: length_m "),
        ('title = "x"\n[[car]]\nid = "a"\nwheel = 3', 4, r"key car\[0\].wheel: unknown key; accepted nearest: wheels"),
        ('title = "x"\n[[car]]\nid = "a"\nzzz = 3', 4, "accepted id, state, colour, wheels, offsets"),
        ('title = "x"\n[[car]]\nid = "a"\n[[car]]\nstate = "straight"', 4, r"key car\[1\]: lacks the key id"),
        ("length_m = 1.0", 1, "lacks the key title"),
        (
            'title = "x"\n[[car]]\nid = "a"\nstate = "on"',
            4,
            r"key car\[0\].state: .*accepted: straight, diverging,",
        ),
        ('title = "x"\n[[car]]\nid = "a"\ncolour = "pink"', 4, r"key car\[0\].colour: .*accepted: blue, red"),
        ('title = "x"\n[[car]]\nid = "a"\n\n[[car.wheels]]\nradius_m = 0', 6, r"car\[0\].wheels\[0\].radius_m: .*> 0"),
        ('title = "x"\n[[car]]\nid = "a"\nwheels = [\n  { radius_m = 2.0 },\n]', 4, r"wheels\[0\]: a wheel of 2.0 m"),
        ('title = "x"\nlength_m = nan', 2, "key length_m: nan is no usable number"),
        ('title = "x"\nlength_m = "2"', 2, "key length_m: expected float"),
        ('title = "x"\n[[car]]\nid = "a"\noffsets = ["x"]', 4, r"key car\[0\].offsets: expected an array of numbers"),
        ('title = "x"\n[depot.n]\nid = "n"\n[depot.s]\nid = 7', 5, "key depot.s.id: expected str"),
        ('title = "x"\n[depot.n]\nid = "n"\nids = 7', 4, "key depot.n.ids: unknown key; accepted nearest: id"),
        ('title = "x"\ndepot.n.id = 7', 2, "key depot.n.id: expected str"),
        ('title = "x"\ncar = 7', 2, "key car: expected array"),
        ('title = "x"\npair = [1, { radius = 7 }]', 2, r"key pair\[1\].radius: unknown key; accepted"),
        ('title = "x', 1, "is not TOML: Unterminated string"),
        ('title = "x"\ntitle = "y"', 2, "is not TOML: Cannot overwrite a value"),
    ],
)
def test_a_bad_file_is_refused_with_file_line_key_and_what_is_accepted(tmp_path, text, line, says):
    with pytest.raises(InputError, match=says) as caught:
        read(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(str(tmp_path / "train.toml"))
    assert f"line {line}:" in message
    assert "\n" not in message


def test_a_file_that_is_no_text_or_not_there_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"nowhere\.toml: cannot be read: No such file"):
        read_toml(tmp_path / "nowhere.toml", Train)
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read_toml(tmp_path, Train)
    (tmp_path / "bytes.toml").write_bytes(b'title = "\xff"')
    with pytest.raises(InputError, match="no UTF-8"):
        read_toml(tmp_path / "bytes.toml", Train)


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (("title",), 1),
        (("car", 1, "id"), 5),
        (("car", 1, "wheels", 0, "radius_m"), 7),
        (("car", 0, "nothing"), 2),
        (("depot", "big hall", "id"), 10),
        (("nothing",), 1),
    ],
)
def test_the_line_of_a_key_is_found(keys, line):
    cars = '[[car]]\nid = "a"\n[[car]]\nid = "b"\n[[car.wheels]]\nradius_m = 1\n'
    text = f'title = "x"\n{cars}# more\n[depot."big hall"]\nid = "n"\n'
    assert line_of_key(text, keys) == line

"""Plants by name or by file."""

from pathlib import Path

from contracts import InputError
from rail.build import build_plant
from rail.plant import Plant
from rail.spec import PlantSpec
from scenarios.toml_file import read_toml

PLANTS = Path(__file__).parent / "plants"


def plant_names() -> tuple[str, ...]:
    """Names of the plants that come with Gantry."""
    return tuple(sorted(path.stem for path in PLANTS.glob("*.toml")))


def load_plant(name_or_path: str | Path) -> Plant:
    """The plant of that name, or in that TOML file; InputError naming file and fault.

    A text that ends in ``.toml`` is a path.
    """
    path = Path(name_or_path)
    if path.suffix != ".toml":
        if str(name_or_path) not in plant_names():
            raise InputError(
                f"plant {str(name_or_path)!r} is unknown; there are {', '.join(plant_names())}, or a .toml file"
            )
        path = PLANTS / f"{name_or_path}.toml"
    spec = read_toml(path, PlantSpec)
    try:
        return build_plant(spec, path.stem)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
